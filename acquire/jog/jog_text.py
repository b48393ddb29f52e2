"""Texts of a jog: before the controller is opened, before the motion, and after it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from exidyn.identification.arm.robot import Robot
from exidyn.identification.document.text import fact_lines
from exidyn.identification.result_file import to_table
from exidyn.identification.text_table import digits, paragraph, table

from ..terminal.watch_text import JointUnits
from .effort import FlangeTravel
from .judgements import OF_WAY, Judgement, Verdict
from .there_and_back import BEFORE, Travel, duration

LOOK = (
    "This program cannot see the arm. Exchanged drives, and a sign or a scale that is wrong in both commands "
    "and measurements, show only in the displacement of the flange."
)


def before(robot: Robot, travel: Travel, facts: Mapping[str, str]) -> str:
    """The joint, its distance and speed, printed before the controller is opened."""
    units, joint = JointUnits.of(robot), travel.joint
    scale, unit = units.scale[joint], units.units[joint]
    lines = [
        f"{robot.name}: {robot.joints[joint]}, joint {joint + 1} of {robot.dof}, "
        f"{scale * travel.distance:+.2f} {unit} and back at {scale * travel.speed:.2g} {unit}/s, "
        f"about {duration(travel):.0f} s"
    ]
    return "\n".join([*lines, *fact_lines(facts.items())])


def before_motion(robot: Robot, travel: Travel, position: np.ndarray, flange: FlangeTravel) -> str:
    """Position and motion of the joint, and of the flange by the robot file, before drives are powered."""
    units, joint = JointUnits.of(robot), travel.joint
    target = position.copy()
    target[joint] += travel.distance
    text = (
        f"{robot.joints[joint]} stands at {units.text(position, joint)} (limits {units.range_text(joint)}), "
        f"goes to {units.text(target, joint)} and back, after {BEFORE:g} s of rest"
    )
    kind = "turns about" if robot.revolute[travel.joint] else "slides along"
    sign = "" if travel.distance > 0.0 else "minus "
    expected = (
        f"the flange goes {1e3 * np.linalg.norm(flange.moved):.1f} mm: "
        f"{_vector(1e3 * flange.moved, '{:+.1f}')} mm in the base frame; the joint {kind} "
        f"{sign}({_vector(flange.axis, '{:.2f}')})"
    )
    return "\n".join([*paragraph(text), *paragraph(expected)])


def _vector(values: np.ndarray, form: str) -> str:
    small = np.where(np.abs(values) < 5e-3, 0.0, values)
    return ", ".join(f"{axis} {form.format(value)}" for axis, value in zip("xyz", small, strict=True))


def after(robot: Robot, travel: Travel, judgements: Sequence[Judgement]) -> str:
    """The result of the jog."""
    rows = [[j.name, _number(j.value, j), _range(j), j.unit, str(j.verdict)] for j in judgements]
    lines = ["", *table(["", "measured", "expected", "", ""], rows, left=(0, 2, 3, 4))]
    for text in dict.fromkeys(j.text for j in judgements if j.text):
        names = ", ".join(j.name for j in judgements if j.text == text)
        lines += paragraph(text, " " * 4, f"  {names}: ")
    return "\n".join(
        [*lines, "", *paragraph(f"{summary(robot.joints[travel.joint], judgements, names=False)} {LOOK}")]
    )


def _range(judgement: Judgement) -> str:
    if np.isnan(judgement.low):
        return "-"
    if np.isinf(judgement.high):
        return f"above {_number(judgement.low, judgement)}"
    return f"{_number(judgement.low, judgement)} to {_number(judgement.high, judgement)}"


def _number(value: float, judgement: Judgement) -> str:
    return f"{value:.3f}" if judgement.unit == OF_WAY and np.isfinite(value) else digits(value)


def summary(joint: str, judgements: Sequence[Judgement], names: bool = True) -> str:
    """The verdict on the joint in a sentence, with the names of the judgments or without."""
    named = {v: [judgement.name for judgement in judgements if judgement.verdict is v] for v in Verdict}
    words = {v: f": {', '.join(named[v])}" if names else "" for v in Verdict}
    if named[Verdict.WRONG]:
        return f"{joint} is NOT as it should be{words[Verdict.WRONG]}."
    if not named[Verdict.RIGHT]:
        return f"{joint}: nothing can be judged."
    unknown = (
        f" Not shown by this motion{words[Verdict.UNKNOWN]}." if names and named[Verdict.UNKNOWN] else ""
    )
    return f"{joint} looks right{words[Verdict.RIGHT]}.{unknown}"


def json_table(robot: Robot, travel: Travel, judgements: Sequence[Judgement]) -> dict[str, Any]:
    """The result of the jog for JSON, in SI units."""
    return {
        "joint": robot.joints[travel.joint],
        "distance": travel.distance,
        "speed": travel.speed,
        "summary": summary(robot.joints[travel.joint], judgements),
        "judgements": [
            {**to_table(judgement), "verdict": judgement.verdict.name.lower()} for judgement in judgements
        ],
    }
