"""Parts that both files of a feedforward share: the comment at the head, and the functions as programs."""

from collections.abc import Iterator
from typing import NamedTuple

from exidyn import __version__

from ..dynamics.dynamics import Dynamics
from ..dynamics.program import Language, Lines, traced_state, written
from ..text_table import paragraph
from .feedforward import Feedforward

RULE = (
    "Friction is compensated by the share below, so that compensation never drives a joint whose friction "
    "is at least that share of the identified friction. Below the band of velocity it is not compensated, so "
    "that noise of a velocity at rest makes no torque; between once and twice the band compensation grows "
    "smoothly."
)


def header(feedforward: Feedforward) -> Iterator[str]:
    """Lines of the comment, without the marks of a comment."""
    robot, turning = feedforward.robot, feedforward.unit
    sentences = [
        f"exidyn {__version__}, {feedforward.title}.",
        f"Joints in order: {', '.join(robot.joints)}.",
        f"Units: positions {_units(feedforward, 'rad')}, velocities {_units(feedforward, 'rad/s')}, "
        f"torques {turning if turning == 'A' else _units(feedforward, 'N m')}.",
        f"Gravity in the base frame: {', '.join(f'{g:g}' for g in robot.gravity)} m/s^2.",
        RULE,
        *(f"{remark[:1].upper()}{remark[1:]}." for remark in feedforward.remarks),
    ]
    for sentence in sentences:
        yield from paragraph(sentence)


def _units(feedforward: Feedforward, turning: str) -> str:
    """Unit of all joints, or of each joint if they differ."""
    units = feedforward.robot.units(turning)
    return units[0] if len(set(units)) == 1 else ", ".join(units)


class Function(NamedTuple):
    """A function of joint states that returns one number per joint."""

    name: str  # name of the function in the file
    arguments: tuple[str, ...]  # names of its arguments, each with one number per joint
    meaning: str  # what it returns, a noun phrase
    lines: Lines  # body of the function


def functions(dynamics: Dynamics, unit: str, language: Language) -> list[Function]:
    """Inverse dynamics, holding torque and friction of an arm, in a language."""
    tape, state = traced_state(dynamics.robot.dof)
    warmth = ("temperature",) if dynamics.needs_temperature else ()
    kinds = (
        ("inverse_dynamics", ("q", "dq", "ddq"), dynamics.torque, "Joint torque of a motion"),
        ("gravity", ("q",), dynamics.gravity_torque, "Joint torque that holds the arm at rest"),
        ("friction", ("q", "dq"), dynamics.friction_torque, "Friction torque as identified, not reduced"),
    )
    return [
        Function(name, arguments + warmth, f"{meaning} [{unit}].", written(tape, torque(state), language))
        for name, arguments, torque, meaning in kinds
    ]
