"""Comment at the head of a feedforward's files: source, units, rule of friction, what is missing."""

from collections.abc import Iterator

from exidyn import __version__

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
