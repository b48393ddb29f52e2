"""Touches in MuJoCo and a UR10e: false alarms, forces that are found, delays, a payload taken as a force."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from common import show
from scipy import stats

from exidyn.identification.contact.contact import observed, wrenches
from exidyn.identification.contact.observer import Estimates
from exidyn.identification.contact.threshold import Alarms, Threshold, block_maxima
from exidyn.identification.contact.wrench import flange_jacobian
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify

from ..real.data import LOADED, UR10E
from . import touched_arm

FORCES = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
"""Sizes of the touches [N]."""
EVERY, LASTS, FIRST = 3.0, 1.0, 2.0
"""Time between touches, their duration and the first one [s]."""


def touches(quick: bool) -> dict[str, Any]:
    """A table by force: found, median delay, error of the force."""
    fit = identify([touched_arm.run("train", 1)])
    free = [observed(fit, touched_arm.run(f"free {k}", 10 + k, 60.0)) for k in range(1 if quick else 4)]
    threshold = Threshold.of(free, fit.standstill)
    rows, figures = [], dict[str, Any]()
    for place, size in enumerate(FORCES):
        found, delays, errors, others, count = _touched(fit, threshold, size, 100 + place, 5 if quick else 20)
        rows.append([size, 100.0 * found / count, _median(delays), _median(errors), others])
        figures[f"{size:g} N"] = {"found_percent": 100.0 * found / count, "delay_ms": _median(delays)}
    header = ["force [N]", "found [%]", "delay [ms]", "error of force [N]", "other alarms"]
    show("touched arm in MuJoCo: touches of a second in random directions", header, rows)
    found_all = [size for size, row in zip(FORCES, rows, strict=True) if row[1] >= 95.0]
    return figures | {"least_force_found": min(found_all, default=None)}


def _touched(
    fit: Any, threshold: Threshold, size: float, seed: int, count: int
) -> tuple[int, list[float], list[float], int, int]:
    """Touches found, delays [ms], errors of the force [N], alarms at other times, and touches made."""
    random = np.random.default_rng(seed)
    directions = random.normal(size=(count, 3))
    forces = size * directions / np.linalg.norm(directions, axis=1)[:, None]
    touched = [
        touched_arm.Touch(tuple(force), FIRST + EVERY * k, FIRST + EVERY * k + LASTS)
        for k, force in enumerate(forces)
    ]
    run = touched_arm.run("touched", seed, FIRST + EVERY * count, touched)
    alarms = Alarms(threshold)
    alarms.add(observed(fit, run))
    delays, errors, matched = [], [], 0
    for touch in touched:
        inside = [alarm for alarm in alarms.all if touch.start <= alarm.start < touch.end]
        if inside:
            matched += len(inside)
            delays.append(1e3 * (inside[0].start - touch.start))
            wrench = inside[0].wrench(fit.model.robot)[:3]
            errors.append(float(np.linalg.norm(wrench - touch.force)))
    return len(delays), delays, errors, len(alarms.all) - matched, count


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else np.nan


FREE = (
    "id_ur-20_02_05-20sec_8harm",
    "id_ur-20_02_06-20sec_5harm",
    "id_ur-20_02_10-20sec_7harm",
    "id_ur-20_01_31-unload",
    "id_ur-19_12_23_free",
    *(f"val_ur-20_01_17-p{k}" for k in range(1, 11)),
    *(f"jointwise_ur-20_01_22-joint_{k}" for k in range(1, 7)),
)
"""Runs without contact that neither the fit nor the threshold has seen."""
PUSHED = ("collision_ur-20_01_22-push_pose_1", "collision_ur-20_01_22-push_pose_2")
"""Runs that were pushed by hand; when and how hard is not documented."""
EARTH = 9.81


class Watched(NamedTuple):
    """The arm's fit, and the threshold from its held-out runs."""

    fit: Fit
    threshold: Threshold


def free_motion(quick: bool) -> dict[str, Any]:
    """Tables of the UR10e."""
    train = UR10E.train[:2] if quick else UR10E.train
    fit = identify([UR10E.run(name) for name in train], filtering=UR10E.filtering)
    held_out = [observed(fit, UR10E.run(name)) for name in UR10E.held_out]
    arm = Watched(fit, Threshold.of(held_out, fit.standstill))
    figures = _alarms(arm, FREE[:8] if quick else FREE)
    figures["least_force"] = _least_force(arm, held_out)
    figures["pushes"] = _pushes(arm)
    figures["mass"] = _masses(arm, LOADED[:1] if quick else LOADED)
    return figures


def _alarms(arm: Watched, runs: Sequence[str]) -> dict[str, Any]:
    alarms, blocks, highest = 0, 0, 0.0
    for name in runs:
        estimates = observed(arm.fit, UR10E.run(name))
        score = arm.threshold.score(estimates)
        blocks += len(block_maxima(estimates.time, score))
        highest = max(highest, float(np.nanmax(score)))
        collected = Alarms(arm.threshold)
        collected.add(estimates)
        alarms += len(collected.all)
    hours = blocks / 3600.0
    most = float(stats.chi2.ppf(0.95, 2 * (alarms + 1))) / 2.0 / hours  # exact for a Poisson process
    header = ["threshold from [min]", "free [min]", "alarms", "an hour, 95 % below", "highest / threshold"]
    over = highest / arm.threshold.level
    row = [60 * arm.threshold.hours, 60 * hours, alarms, most, over]
    show("ur10e: false alarms in free motion, for one an hour", header, [row])
    return {"hours": hours, "alarms": alarms, "alarms_an_hour_below": most, "highest_over_threshold": over}


def _least_force(arm: Watched, runs: Sequence[Estimates]) -> dict[str, float]:
    """Steady force on the flange that makes an alarm by itself, along each axis of the base [N]."""
    robot, forces = arm.fit.model.robot, []
    data = robot.kinematics.createData()
    for estimates in runs:
        limit = arm.threshold.torque(estimates)
        for row in np.flatnonzero(np.isfinite(limit).all(axis=1))[::50]:
            jacobian = flange_jacobian(robot, data, estimates.position[row])[:3]
            forces.append(np.min(limit[row] / np.maximum(np.abs(jacobian), 1e-9), axis=1))
    quantiles = np.quantile(forces, [0.1, 0.5, 0.9], axis=0)
    rows = [[name, *values] for name, values in zip(("10 %", "median", "90 %"), quantiles, strict=True)]
    show("ur10e: least steady force on the flange for an alarm [N]", ["of poses", "x", "y", "z"], rows)
    return {"median": float(np.median(forces)), "by_axis_median": quantiles[1].tolist()}


def _pushes(arm: Watched) -> dict[str, int]:
    found, rows = {}, []
    for name in PUSHED:
        collected = Alarms(arm.threshold)
        collected.add(observed(arm.fit, UR10E.run(name)))
        found[name] = len(collected.all)
        for alarm in collected.all:
            force = float(np.linalg.norm(alarm.wrench(arm.fit.model.robot)[:3]))
            rows.append([name, alarm.start, alarm.end, f"J{alarm.joint + 1}", alarm.score, force])
    show("ur10e: pushes by hand", ["run", "from [s]", "to [s]", "joint", "over threshold", "force [N]"], rows)
    return found


def _masses(arm: Watched, runs: Sequence[tuple[str, float]]) -> dict[str, float]:
    """Mass from the force on the flange, which the fit without payload takes the weight for."""
    errors, rows = {}, []
    for name, mass in runs:
        run = UR10E.run(name)
        estimates = observed(arm.fit, run, "", bandwidth=1.0)
        force = wrenches(arm.fit, estimates, arm.threshold)[:, 2]
        # At rest, dry friction holds a part of the weight that nothing shows.
        moving = np.all(np.abs(estimates.velocity) > arm.fit.standstill, axis=1)
        by_force = -np.nanmedian(np.array([force, np.where(moving, force, np.nan)]), axis=1) / EARTH
        error = 100.0 * (by_force / mass - 1.0)
        errors[name] = float(error[1])
        rows.append([name, mass, by_force[0], error[0], by_force[1], error[1]])
    header = ["run", "mass [kg]", "force / g [kg]", "error [%]", "in motion [kg]", "error [%]"]
    show("ur10e: payload taken as an external force", header, rows)
    return errors
