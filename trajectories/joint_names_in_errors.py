"""Joint words: messages about joints by their number, in a robot's own names and units."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

from exidyn.identify.arm.robot import Robot

from .errors import BadLimits, Infeasible

NUMBERED = re.compile(r"\bjoint (\d+)(?=: )")
"""How modules that know limits alone, and no robot, begin a sentence about a joint."""


@contextmanager
def in_words_of(robot: Robot) -> Iterator[None]:
    """Errors from inside name the robot's joints, and metres and newtons where one slides."""
    try:
        yield
    except (BadLimits, Infeasible) as error:
        raise type(error)(named(str(error), robot)) from error


def named(text: str, robot: Robot) -> str:
    """Text with the robot's joint names for their numbers."""
    before, *parts = NUMBERED.split(text)
    named_parts = [before]
    for number, sentence in zip(parts[::2], parts[1::2], strict=True):
        joint = int(number) - 1
        if joint not in range(robot.dof):
            named_parts.append(f"joint {number}{sentence}")
        elif robot.revolute[joint]:
            named_parts.append(robot.joints[joint] + sentence)
        else:
            metres = re.sub(r"\brad\b", "m", re.sub(r"\bN m\b", "N", sentence))
            named_parts.append(robot.joints[joint] + metres)
    return "".join(named_parts)
