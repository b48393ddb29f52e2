"""What a person reads of a jog: before, when the arm is found, and after."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from exidyn.identification.arm.robot import Robot
from exidyn.identification.text_table import digits, paragraph, table

from ..terminal.joint_units import JointUnits
from ..terminal.json_output import plain
from .effort import FlangeWay
from .judgements import OF_WAY, Judgement, Verdict
from .there_and_back import BEFORE, Way, duration

LOOK = (
    "This program cannot see the arm. Exchanged drives, and a sign or a scale that is wrong in commands and "
    "measurements alike, show only in where the flange goes."
)


def before(robot: Robot, way: Way, facts: Mapping[str, str]) -> str:
    """What will move, before the controller is opened."""
    units, joint = JointUnits.of(robot), way.joint
    scale, unit = units.scale[joint], units.units[joint]
    lines = [
        f"{robot.name}: {robot.joints[joint]}, joint {joint + 1} of {robot.dof}, "
        f"{scale * way.distance:+.2f} {unit} and back at {scale * way.speed:.2g} {unit}/s, "
        f"about {duration(way):.0f} s"
    ]
    width = max(map(len, facts)) + 2
    return "\n".join([*lines, *(f"  {name + ':':<{width}}{text}" for name, text in facts.items())])


def before_motion(robot: Robot, way: Way, position: np.ndarray, flange: FlangeWay) -> str:
    """Where the arm stands and what it should do, before its drives are powered."""
    units, joint = JointUnits.of(robot), way.joint
    target = position.copy()
    target[joint] += way.distance
    text = (
        f"{robot.joints[joint]} stands at {units.text(position, joint)} (limits {units.range_text(joint)}), "
        f"goes to {units.text(target, joint)} and back, after {BEFORE:g} s of rest"
    )
    return "\n".join([*paragraph(text), *expected(robot, way, flange)])


def expected(robot: Robot, way: Way, flange: FlangeWay) -> list[str]:
    """Where the flange goes by the robot file."""
    kind = "turns about" if robot.revolute[way.joint] else "slides along"
    sign = "" if way.distance > 0.0 else "minus "
    text = (
        f"the flange goes {1e3 * np.linalg.norm(flange.moved):.1f} mm: "
        f"{_vector(1e3 * flange.moved, '{:+.1f}')} mm in the base frame; the joint {kind} "
        f"{sign}({_vector(flange.axis, '{:.2f}')})"
    )
    return paragraph(text)


def _vector(values: np.ndarray, form: str) -> str:
    small = np.where(np.abs(values) < 5e-3, 0.0, values)
    return ", ".join(f"{axis} {form.format(value)}" for axis, value in zip("xyz", small, strict=True))


def after(robot: Robot, way: Way, judgements: Sequence[Judgement], flange: FlangeWay | None) -> str:
    """The result of the jog."""
    rows = [
        [one.name, _number(one.value, one), _range(one), one.unit, str(one.verdict)] for one in judgements
    ]
    lines = ["", *table(["", "measured", "in order", "", ""], rows, left=(0, 2, 3, 4))]
    for text in dict.fromkeys(one.text for one in judgements if one.text):
        names = ", ".join(one.name for one in judgements if one.text == text)
        lines += paragraph(text, " " * 4, f"  {names}: ")
    lines += ["", *paragraph(summary(robot.joints[way.joint], judgements))]
    if flange is not None:
        lines += [*paragraph(LOOK), *expected(robot, way, flange)]
    return "\n".join(lines)


def _range(one: Judgement) -> str:
    if np.isnan(one.low):
        return "-"
    if np.isinf(one.high):
        return f"above {_number(one.low, one)}"
    return f"{_number(one.low, one)} to {_number(one.high, one)}"


def _number(value: float, one: Judgement) -> str:
    return f"{value:.3f}" if one.unit == OF_WAY and np.isfinite(value) else digits(value)


def summary(joint: str, judgements: Sequence[Judgement]) -> str:
    """The verdict in a sentence."""
    named = {v: [one.name for one in judgements if one.verdict is v] for v in Verdict}
    if named[Verdict.WRONG]:
        return f"{joint} is NOT as it should be: {', '.join(named[Verdict.WRONG])}."
    if not named[Verdict.RIGHT]:
        return f"{joint}: nothing can be judged."
    unknown = (
        f" Not shown by this motion: {', '.join(named[Verdict.UNKNOWN])}." if named[Verdict.UNKNOWN] else ""
    )
    return f"{joint} looks right: {', '.join(named[Verdict.RIGHT])}.{unknown}"


def json_table(robot: Robot, way: Way, judgements: Sequence[Judgement]) -> dict[str, Any]:
    """The same for scripts, in SI units."""
    names = {v: v.name.lower() for v in Verdict}
    return {
        "joint": robot.joints[way.joint],
        "distance": way.distance,
        "speed": way.speed,
        "summary": summary(robot.joints[way.joint], judgements),
        "judgements": [
            {
                "name": one.name,
                **plain({"value": one.value, "low": one.low, "high": one.high}),
                "unit": one.unit,
                "verdict": names[one.verdict],
                "text": one.text,
            }
            for one in judgements
        ],
    }
