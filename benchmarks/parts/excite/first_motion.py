"""First motion on an arm whose dynamics are hardly known, and the next ones as fits tell more of it.

The built-in arms with drives that the nominal arm needs nearly all of, and inertias known to 30 per cent. The
first motion is judged on arms drawn here: every parameter on its own, as the priors state it, and all ten
parameters of a link together, as where a link is heavier than stated. Then one arm, drawn once, is simulated
on each motion, and fitted for the next.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from common import show

from exidyn.identification.arm.robot import Robot
from exidyn.identification.effects.rigid_body import with_bodies
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import Sensors, simulate
from exidyn.trajectories.planning.planner import plan
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_check import nominal_torque

TOLERANCE = 0.3
"""Relative standard deviation of the inertias: masses read off a drawing."""
NEEDED = 1.15
"""Torque limit over what the nominal motion of the unlimited arm uses."""
ARMS = 1000
"""Drawn; five per cent of them are known to 0.7."""
CHUNK = 500
"""Samples whose torque is held at once for all arms."""


def weak(name: str, seconds: float) -> Model:
    """An arm whose drives the nominal motion needs nearly all of."""
    model = read_model(name)
    robot = replace(model.robot, inertial_tolerance=TOLERANCE)
    model = replace(model, robot=robot)
    free = planned(model, seconds, sure=0.0)
    used = nominal_torque(free, model).use.share
    limits = replace(robot.limits, torque=NEEDED * used * robot.limits.torque)
    return replace(model, robot=replace(robot, limits=limits))


def planned(model: Model, seconds: float, **wishes: Any) -> Plan:
    """The motion of one start of so many seconds."""
    return plan(model, Wishes(seconds=1.0, **wishes), starts=1, seconds=seconds)[0]


def drawn_apart(model: Model, seed: int) -> np.ndarray:
    """Parameters of arms, each on its own within its prior, shape (p, `ARMS`)."""
    std = np.array([prior.std for prior in model.priors])
    random = np.random.default_rng(seed).normal(size=(len(std), ARMS))
    return model.nominal_values[:, None] + np.where(np.isfinite(std), std, 0.0)[:, None] * random


def drawn_by_links(model: Model, seed: int) -> np.ndarray:
    """The same with all parameters of a link larger or smaller by one factor."""
    found, random = drawn_apart(model, seed), np.random.default_rng(seed)
    for link in model.inertias:
        factor = 1.0 + model.robot.inertial_tolerance * random.normal(size=ARMS)
        found[link] = model.nominal_values[link][:, None] * np.maximum(factor, 0.0)
    return found


def beyond(model: Model, one: Plan, drawn: np.ndarray) -> float:
    """Share of arms that pass a torque limit at some time of a whole run, every 4 ms."""
    states, limit = one.trajectory.every(2 * one.tick), model.robot.limits.torque[:, None]
    found, motion = np.zeros(ARMS, dtype=bool), states.motion()
    for start in range(0, len(motion), CHUNK):
        torque = model.regressor(model.loaded(motion[start : start + CHUNK])) @ drawn
        found |= np.any(np.abs(torque) > limit, axis=(0, 1))
    return float(np.mean(found))


def true_arm(model: Model, seed: int) -> Model:
    """An arm that exists: its links heavier or lighter than nominal by one deviation."""
    random = np.random.default_rng(seed)
    factors = 1.0 + TOLERANCE * random.choice([-1.0, 1.0], size=model.robot.dof)
    bodies = model.nominal_values[np.concatenate([np.r_[one] for one in model.inertias[: model.robot.dof]])]
    robot: Robot = with_bodies(model.robot, factors[:, None] * bodies.reshape(model.robot.dof, 10))
    return replace(model, robot=robot)


def next_fit(model: Model, plant: Model, runs: list[Plan]) -> Fit:
    """The fit of all runs so far, as the arm was recorded on them."""
    recordings = [
        simulate(
            plant,
            plant.nominal_values,
            plant.robot.drive_gain,
            one.trajectory.every(one.tick).motion(),
            model,
            Sensors(),
            name=f"run {number}",
            seed=number,
        )
        for number, one in enumerate(runs)
    ]
    return identify(recordings)


def excursion(one: Plan) -> float:
    """Root mean square velocity of the whole run over the velocity limits, all joints together [-]."""
    velocity = one.trajectory.every(one.tick).velocity / one.limits.velocity
    return float(np.sqrt(np.mean(velocity**2)))


def run(quick: bool) -> dict[str, Any]:
    """Figures and a table."""
    seconds, rows, shares = (2.0 if quick else 10.0), [], list[float]()
    gained = dict[str, float]()
    for name in ("cobot",) if quick else ("cobot", "kr270"):
        model = weak(name, seconds)
        motions = {"room for 95 %": (first := planned(model, seconds))}
        if not quick:
            motions["nominal"] = planned(model, seconds, sure=0.0)
        for words, one in motions.items():
            apart, links = (beyond(model, one, draw(model, 5)) for draw in (drawn_apart, drawn_by_links))
            rows.append([name, words, 100 * apart, 100 * links, excursion(one)])
            shares += [max(apart, links)] if one is first else []
        if quick:
            continue
        plant = true_arm(model, 0)
        fit = next_fit(model, plant, [first])
        later = planned(model, seconds, fit=fit, criterion="volume")
        torque = nominal_torque(later, plant).use.share.max()
        rows.append([name, "after one run", float("nan"), 100.0 * (torque > 1.0), excursion(later)])
        gained[name] = excursion(later) / excursion(first)
    header = ["arm", "motion", "beyond, each parameter %", "beyond, whole links %", "rms velocity of limit"]
    show(f"Torque limits on {ARMS} arms drawn within priors of {100 * TOLERANCE:g} %", header, rows)
    return {"prior_violations": max(shares), "freedom_gained_by_a_run": gained}
