"""What a short search delivers beside a long one and beside what it showed; the time of a check of sweeps."""

import time
from typing import Any

from common import show

from exidyn.identify.model import Model
from exidyn.identify.robot_files.robot_file import read_model
from exidyn.trajectories.kinds.sweeps import constant_velocity_sweeps
from exidyn.trajectories.limits.usable_limits import usable
from exidyn.trajectories.planning.goals import identification_goal
from exidyn.trajectories.planning.wishes import Wishes, periods_of
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_check import nominal_torque, violations
from exidyn.trajectories.search.excite import excite
from exidyn.trajectories.search.start import Setting

from .arm import Arm

TWO = ("shoulder_pan_joint", "shoulder_lift_joint")
"""Joints of the arm of two."""
SWEEP = 109.0
"""Length of sweeps to which the time of their check is referred [s]."""


def arms(ur10: Arm) -> dict[str, Model]:
    """Five arms: built in, of the package, and the first two joints of one of these."""
    panda = ur10.urdf.parents[2] / "panda_description" / "urdf" / "panda.urdf"
    return {
        "cobot": read_model("cobot"),
        "KR270": read_model("kr270"),
        "UR10": read_model(ur10.urdf),
        "Panda": read_model(panda, [f"panda_joint{k}" for k in range(1, 8)]),
        "two joints": read_model(ur10.urdf, TWO),
    }


def reached(model: Model, seconds: float, seed: int) -> tuple[float, float]:
    """Value that a search delivers and the last one that it showed, both as condition numbers."""
    wishes, shown = Wishes(), list[str]()
    limits, _ = usable(model.robot, wishes.margins)
    goal = identification_goal(model, wishes, limits)
    setting = Setting(limits, wishes.harmonics, periods_of(wishes, limits), tick=wishes.tick)
    found = excite(goal, setting, seed=seed, seconds=seconds, progress=shown.append)
    numbers = [float(word) for line in shown for word in line.replace(";", " ").split() if _number(word)]
    least = min(number for number in numbers if number > 1.0)
    return goal.reached(found.value), least


def _number(word: str) -> bool:
    return "." in word and word.replace(".", "", 1).isdigit()


def short_and_long(
    ur10: Arm, seconds: tuple[float, float], seed: int = 0, count: int | None = None
) -> dict[str, Any]:
    """Condition numbers after a short and after a long search, on the first `count` arms, or on all."""
    rows, ratios, delivered = [], dict[str, float](), list[float]()
    for name, model in list(arms(ur10).items())[:count]:
        (early, shown), (late, last) = (reached(model, each, seed) for each in seconds)
        ratios[name] = early / late
        delivered += [early / shown, late / last]
        rows.append([name, early, late, early / late, max(early / shown, late / last)])
    header = ["arm", *(f"after {each:g} s" for each in seconds), "ratio", "delivered over shown"]
    show("Condition number that is delivered, by time of search", header, rows)
    return {
        "after_short_over_long": ratios,
        "after_5s_over_40s": max(ratios.values()),
        "delivered_over_shown": max(delivered),
    }


def sweep_check() -> dict[str, float]:
    """CPU time of the check of a built-in arm's sweeps against all limits, for `SWEEP` seconds of them."""
    model, wishes = read_model("cobot"), Wishes()
    limits, _ = usable(model.robot, wishes.margins)
    middle = 0.5 * (limits.position_lower + limits.position_upper)
    run = constant_velocity_sweeps(limits, range(model.robot.dof), middle, wishes.tick)
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
