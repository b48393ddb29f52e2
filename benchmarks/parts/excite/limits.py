"""Whether optimised runs keep to every limit at all times, over random problems.

The arm that moves may have all masses a fifth more or less than the nominal one, whose file states that
tolerance. Arms are the built-in ones with random position ranges, speeds, accelerations forward and backward,
jerks, drives that are sometimes too weak for what the speeds allow, correction windows, flange regions.
The check here is not the planner's: every run is sampled at 10 kHz, its torques computed by another
library (Pinocchio's recursive Newton-Euler for the rigid part), and Ruckig stops it on every tick.
"""

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pinocchio as pin
from common import Kept, show

from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import RigidBody
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.clearances.region import read_regions
from exidyn.trajectories.errors import Infeasible
from exidyn.trajectories.limits.check import check
from exidyn.trajectories.limits.moves import brake_reach
from exidyn.trajectories.limits.usable_limits import usable
from exidyn.trajectories.planning.planner import plan
from exidyn.trajectories.planning.wishes import Wishes, shortest_run
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.trajectory import States

DENSE = 1e-4
"""Spacing of samples [s]; a joint at 3 rad/s and 20 rad/s^2 moves 3e-8 rad off a straight line."""
MASSES = (0.8, 1.0, 1.2)
"""Of the true arm over nominal, all links alike."""
ROUNDING = 1e-6
"""Share of a limit's range that counts as rounding of the sampled sums."""
SEARCH = 2.0
"""Seconds of search for each problem: the limits must hold however early it is cut short."""


def random_problem(seed: int) -> tuple[Model, Wishes]:
    """An arm with limits, and what is wished, from a seed."""
    random = np.random.default_rng(seed)
    model = read_model(("kr270", "cobot")[seed % 2])
    given = model.robot.limits
    lower, upper = np.maximum(given.position_lower, -np.pi), np.minimum(given.position_upper, np.pi)
    share, where = random.uniform(0.3, 1.0, (2, model.robot.dof))
    off = (1 - share) * (upper - lower)
    lower, upper = lower + where * off, upper - (1 - where) * off
    faster = random.uniform(0.4, 1.5, (4, model.robot.dof))
    jerk = np.where(np.isfinite(given.jerk), given.jerk, 10 * given.acceleration)
    limits = Limits(
        lower,
        upper,
        faster[0] * given.velocity,
        faster[1] * given.acceleration,
        faster[2] * jerk,
        _torque(model, random),
        acceleration_lower=-faster[1] * given.acceleration * random.uniform(0.6, 1.0),
    )
    robot = replace(model.robot, limits=limits, inertial_tolerance=max(MASSES) - 1.0)
    model = replace(model, robot=robot)
    window, start = None, None
    if seed % 3 == 0:  # a correction window around a pose well inside
        start = 0.5 * (lower + upper)
        window = random.uniform(0.2, 0.6) * np.ones(model.robot.dof)
    period = float(random.uniform(5.0, 12.0))
    wishes = Wishes(harmonics=int(random.integers(3, 6)), period=period, window=window, start=start, rest=0.2)
    inside, _ = usable(robot, wishes.margins, window, start)
    wishes = replace(wishes, seconds=shortest_run(wishes, inside) + 4.0)
    if seed % 4 == 0:
        floor = [{"point": "flange", "lower": [-np.inf, -np.inf, _height(model)]}]
        wishes = replace(wishes, clearances=tuple(read_regions(floor, model.robot)))
    return model, wishes


def _torque(model: Model, random: np.random.Generator) -> np.ndarray:
    """Drives that can hold the arm anywhere, but not always move it as fast as the other limits allow."""
    robot = model.robot
    poses = random.uniform(robot.limits.position_lower, robot.limits.position_upper, (200, robot.dof))
    still = np.zeros_like(poses)
    holding = np.abs(_torques(model, States(np.zeros(200), poses, still, still, still))(1.0)).max(axis=0)
    return np.minimum(1.3 * holding + 0.2 * holding.max() + 20.0, robot.limits.torque) * random.uniform(1, 2)


def _height(model: Model) -> float:
    """A floor under the flange that the middle pose clears by 0.3 m."""
    robot = model.robot
    data = robot.kinematics.createData()
    middle = 0.5 * (robot.limits.position_lower + robot.limits.position_upper)
    pin.forwardKinematics(robot.kinematics, data, middle)
    return float((data.oMi[robot.dof] * robot.flange).translation[2]) - 0.3


def _torques(model: Model, states: States) -> Callable[[float], np.ndarray]:
    """Torque by masses over the nominal ones, the rigid part by Pinocchio sample by sample."""
    robot = model.robot
    data = robot.kinematics.createData()
    rigid = [
        pin.rnea(robot.kinematics, data, *one).copy()
        for one in zip(states.position, states.velocity, states.acceleration, strict=True)
    ]
    rest = replace(model, effects=tuple(e for e in model.effects if not isinstance(e, RigidBody)))
    pieces = rest.pieces(states.motion(), model)  # a run has a gigabyte of columns
    others = np.concatenate([columns @ rest.nominal_values + known for columns, known in pieces])
    return lambda share: share * np.array(rigid) + others


def excess(model: Model, wishes: Wishes, one: Plan) -> dict[str, float]:
    """By how much a run passes each kind of limit at worst, as a share of its range; at most zero inside."""
    limits, run = model.robot.limits, one.trajectory
    states = run.every(DENSE)
    ranges = {
        "position": (states.position, limits.position_lower, limits.position_upper),
        "velocity": (states.velocity, limits.velocity_lower, limits.velocity),
        "acceleration": (states.acceleration, limits.acceleration_lower, limits.acceleration),
        "jerk": (states.jerk, -limits.jerk, limits.jerk),
    }
    torque = _torques(model, states)
    for share in MASSES:
        ranges[f"torque, masses {share:g}"] = (torque(share), -limits.torque, limits.torque)
    ticks = run.every(one.tick)
    reach = brake_reach(ticks.velocity, ticks.acceleration, limits)
    for name, side in (("stop down", reach.lower), ("stop up", reach.upper)):
        ranges[name] = (ticks.position + side, limits.position_lower, limits.position_upper)
    if wishes.window is not None and wishes.start is not None:
        ranges["window"] = (states.position, wishes.start - wishes.window, wishes.start + wishes.window)
    found = {name: _beyond(*each) for name, each in ranges.items()}
    step = np.diff(states.position, axis=0) / np.diff(states.time)[:, None]
    mean = 0.5 * (states.velocity[1:] + states.velocity[:-1])
    found["position against velocity"] = float(np.max(np.abs(step - mean) / limits.velocity)) - 1e-3
    for clearance in wishes.clearances:
        found["region"] = float(-np.min(clearance.margins(states.position)))  # metres
    return found


def _beyond(values: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> float:
    room = upper - lower
    return float(np.max(np.maximum((values - upper) / room, (lower - values) / room)))


def one_problem(seed: int) -> tuple[int, str, dict[str, float], float, float]:
    """Seed, why it failed or "", worst excess of each kind, seconds of the planner's check, of the run."""
    model, wishes = random_problem(seed)
    try:
        one = plan(model, wishes, starts=1, seed=seed, seconds=SEARCH)[0]
    except Infeasible as reason:
        return seed, str(reason), {}, 0.0, 0.0
    begun = time.process_time()
    check(one.trajectory, model.robot.limits, one.tick)
    return seed, "", excess(model, wishes, one), time.process_time() - begun, one.trajectory.duration


def run(problems: Sequence[int], kept: Kept) -> dict[str, object]:
    """Plan and check all problems; figures for the benchmark."""
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        names = {seed: f"limits, problem {seed}" for seed in problems}
        new = {s: pool.submit(one_problem, s) for s, name in names.items() if name not in kept.found}
        found = [kept.of(names[seed], lambda seed=seed: new[seed].result()) for seed in problems]
    done = [one for one in found if not one[1]]
    kinds = sorted({kind for one in done for kind in one[2]})
    rows = []
    for kind in kinds:
        values = [one[2][kind] for one in done if kind in one[2]]
        rows.append([kind, len(values), max(values), sum(value > ROUNDING for value in values)])
    violations = sum(int(row[3]) for row in rows)
    show(
        f"{len(done)} of {len(found)} random problems planned; the worst of each kind over all samples",
        ["limit", "problems", "worst excess, share of range", "violations"],
        rows,
    )
    for seed, why, *_ in found:
        if why:
            print(f"  problem {seed}: no run: {why}")
    seconds = float(np.median([one[3] for one in done]))
    length = float(np.median([one[4] for one in done]))
    print(f"  a full check of kinematics and stops takes {1e3 * seconds:.1f} ms for {length:.0f} s at 500 Hz")
    return {
        "limit_violations": violations,
        "limit_problems": len(found),
        "limit_problems_planned": len(done),
        "limit_check_ms": 1e3 * seconds,
    }
