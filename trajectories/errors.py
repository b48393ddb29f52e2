"""The errors of `trajectories`. Each message states a fact, a value, a limit and what to try."""

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from exidyn.identification.arm.robot import Robot
from exidyn.identification.errors import ExidynError, listed


class TrajectoryError(ExidynError, ValueError):
    """No trajectory meets the request."""


class BadLimits(TrajectoryError):
    """Limits are missing, or no arm can move within them."""


class Infeasible(TrajectoryError):
    """No motion from this start, in this region, keeps to all limits."""


class NotContinuous(TrajectoryError):
    """Parts of a motion do not join in position, velocity or acceleration."""


class NothingToIdentify(TrajectoryError):
    """The model has no parameter that a motion could excite."""


class NotComparable(TrajectoryError):
    """Hypotheses cannot be compared."""


class NotATrajectory(TrajectoryError):
    """The file is no trajectory file, or has another version."""


class OutsideTrajectory(TrajectoryError):
    """A time is before the start or after the end of a trajectory."""


class UnknownChoice(TrajectoryError, LookupError):
    """A criterion, family or format is unknown; the message lists the valid ones."""

    def __init__(self, kind: str, name: str, valid: Iterable[str], meant: str = "") -> None:
        super().__init__(
            f"there is no {kind} called '{name}'{meant or '.'} Valid: {listed(sorted(valid), name)}"
        )


NUMBERED = re.compile(r"\bjoint (\d+)(?=: )")
"""How a message about a joint begins in modules that have limits but no robot."""


@contextmanager
def in_words_of(robot: Robot) -> Iterator[None]:
    """Make errors raised inside name the robot's joints, with meters and newtons for prismatic joints."""
    try:
        yield
    except (BadLimits, Infeasible) as error:
        raise type(error)(named(str(error), robot)) from error


def named(text: str, robot: Robot) -> str:
    """Text with joint numbers replaced by the robot's joint names."""
    before, *parts = NUMBERED.split(text)
    named_parts = [before]
    for number, sentence in zip(parts[::2], parts[1::2], strict=True):
        joint = int(number) - 1
        if joint not in range(robot.dof):
            named_parts.append(f"joint {number}{sentence}")
        elif robot.revolute[joint]:
            named_parts.append(robot.joints[joint] + sentence)
        else:
            in_meters = re.sub(r"\brad\b", "m", re.sub(r"\bN m\b", "N", sentence))
            named_parts.append(robot.joints[joint] + in_meters)
    return "".join(named_parts)
