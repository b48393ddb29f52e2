"""What a short search delivers beside a long one and beside what it showed; the time of a check of sweeps.

Searches are compared by CPU time: each start has the seconds that it has on an idle machine of two cores, by
the clock of its own process, so that other work on the machine takes nothing from a short search. Beside it
stands what `plan` delivers after so many seconds of the clock on the wall.
"""

import os
import time
from collections.abc import Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from common import Kept, show

from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.kinds.rests import Workspace
from exidyn.trajectories.kinds.sweeps import constant_velocity_sweeps
from exidyn.trajectories.limits.usable_limits import usable
from exidyn.trajectories.planning.planner import goal_and_setting, plan
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_check import nominal_torque, violations
from exidyn.trajectories.search import delivery, solve, start
from exidyn.trajectories.search.excite import starts_of
from exidyn.trajectories.search.goals import Goal
from exidyn.trajectories.search.setting import SearchResult, Setting
from exidyn.trajectories.search.start import one_start

from .arm import ARMS, robots

TWO = ("shoulder_pan_joint", "shoulder_lift_joint")
"""Joints of the arm of two."""
IIWA = Path(os.environ.get("EXIDYN_DATA", "")) / "mjcf" / "iiwa14.xml"
"""MuJoCo Menagerie's model, which has no limits of velocity and torque."""
IIWA_VELOCITY = np.radians([85.0, 85.0, 100.0, 75.0, 130.0, 135.0, 135.0])
"""Of the maker's data sheet [rad/s]."""
IIWA_TORQUE = np.array([320.0, 320.0, 176.0, 176.0, 110.0, 40.0, 40.0])
"""The same [N m]."""
SWEEP = 109.0
"""Length of sweeps to which the time of their check is referred [s]."""
STARTS = 4
"""Of a search, unless asked otherwise."""
CORES = 2
"""For which the seconds of each start are counted."""


def arms() -> dict[str, Model]:
    """UR10, KR270, iiwa if its model is there, Panda, and the first two joints of the first."""
    urdf = robots() / ARMS["UR10"]
    panda = robots() / "panda_description" / "urdf" / "panda.urdf"
    found = {
        "UR10": read_model(urdf),
        "KR270": read_model("kr270"),
        "Panda": read_model(panda, [f"panda_joint{k}" for k in range(1, 8)]),
        "two joints": read_model(urdf, TWO),
    }
    if IIWA.is_file():
        return found | {"iiwa": iiwa()}
    print("iiwa: left out; its model is mjcf/iiwa14.xml in the folder that EXIDYN_DATA names")
    return found


def iiwa() -> Model:
    """The iiwa 14 with the limits of its data sheet."""
    model = read_model(IIWA)
    limits = replace(
        model.robot.limits, velocity=IIWA_VELOCITY, velocity_lower=-IIWA_VELOCITY, torque=IIWA_TORQUE
    )
    return replace(model, robot=replace(model.robot, limits=limits))


def by_cpu(pool: Executor, model: Model, seconds: float, seed: int = 0) -> float:
    """Condition number that a search delivers whose starts count seconds of CPU time."""
    goal, setting, _ = goal_and_setting(model, Wishes())
    tasks = starts_of(setting, STARTS, seed, seconds)
    share = seconds / -(-len(tasks) // CORES)
    futures = [pool.submit(_one, goal, one, number, share) for one, number in tasks]
    found = [future.result() for future in futures]
    return goal.reached(min(one.value for one in found if isinstance(one, SearchResult)))


def _count_cpu_time() -> None:
    """In a process of its own: searches look at this clock."""
    clock = SimpleNamespace(monotonic=time.process_time)
    solve.time = start.time = delivery.time = clock  # type: ignore[attr-defined]


def _one(goal: Goal, setting: Setting, seed: int, seconds: float) -> "SearchResult | str":
    return one_start(goal, setting, seed, seconds, lambda: False)


def by_wall(model: Model, seconds: float) -> dict[str, float]:
    """What `plan` delivers and the least that it showed, as condition numbers, and seconds it took."""
    shown, begun = list[str](), time.perf_counter()
    one = plan(model, Wishes(), starts=STARTS, seconds=seconds, progress=shown.append)[0]
    took = time.perf_counter() - begun
    numbers = [float(word) for line in shown for word in line.replace(";", " ").split() if _number(word)]
    return {
        "delivered": one.reached,
        "shown": min(number for number in numbers if number >= 1.0),
        "took": took,
        "load": os.getloadavg()[0],
    }


def _number(word: str) -> bool:
    return "." in word and word.replace(".", "", 1).isdigit()


def short_and_long(seconds: tuple[float, float], kept: Kept, names: Sequence[str] = ()) -> dict[str, Any]:
    """Condition numbers after a short and after a long search, on the arms of these names, or on all."""
    chosen = {name: model for name, model in arms().items() if not names or name in names}
    with ProcessPoolExecutor(CORES, get_context("spawn"), _count_cpu_time) as pool:
        reached = {
            name: [kept.of(f"{name}, {s:g} CPU s", lambda m=model, s=s: by_cpu(pool, m, s)) for s in seconds]
            for name, model in chosen.items()
        }
    short, long = seconds
    walls = {
        name: kept.of(f"{name}, {short:g} s", lambda m=model: by_wall(m, short))
        for name, model in chosen.items()
    }
    ratios = {name: early / late for name, (early, late) in reached.items()}
    rows = [
        [name, *both, ratios[name], *(walls[name][key] for key in ("delivered", "took", "load"))]
        for name, both in reached.items()
    ]
    header = ["arm", f"{short:g} CPU s", f"{long:g} CPU s", "ratio", f"{short:g} s", "took s", "load"]
    show("Condition number that is delivered, by time of search", header, rows)
    return {
        "after_short_over_long": ratios,
        f"after_{short:g}s_over_{long:g}s": max(ratios.values()),
        "arms": len(ratios),
        "delivered_over_shown": max(one["delivered"] / one["shown"] for one in walls.values()),
    }


def sweep_check() -> dict[str, float]:
    """CPU time of the check of a built-in arm's sweeps against all limits, for `SWEEP` seconds of them."""
    model, wishes = read_model("cobot"), Wishes()
    limits, _ = usable(model.robot, wishes.margins)
    middle = 0.5 * (limits.position_lower + limits.position_upper)
    run = constant_velocity_sweeps(Workspace(limits, wishes.tick), range(model.robot.dof), middle)
    plan = Plan.of(run, model, tick=wishes.tick)
    begun = time.process_time()
    found = violations(plan, nominal_torque(plan, model))
    seconds = (time.process_time() - begun) * SWEEP / run.duration
    show(
        "Check of sweeps",
        ["sweeps s", f"CPU s for {SWEEP:g} s", "violations"],
        [[run.duration, seconds, len(found)]],
    )
    return {"sweep_check_seconds": seconds, "sweep_violations": len(found)}
