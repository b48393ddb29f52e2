"""The errors of `trajectories`, each a fact with a value, a limit and what to try.

ExidynError
└── TrajectoryError        no trajectory can be what was asked for
    ├── BadLimits          limits that no arm can move within, or that are not given
    ├── Infeasible         nothing keeps to all limits from this start, in this region
    ├── NotContinuous      parts of a motion that do not join
    ├── NothingToIdentify  the model has no parameter that motion could show
    ├── NotComparable      hypotheses that cannot be weighed against each other
    ├── NotATrajectory     a trajectory file that is not one, or of another version
    ├── OutsideTrajectory  a time before the start or after the end
    └── UnknownChoice      a criterion, family or format that there is not
"""

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from exidyn.identification.arm.robot import Robot
from exidyn.identification.errors import ExidynError, listed


class TrajectoryError(ExidynError, ValueError):
    """No trajectory can be what was asked for."""


class BadLimits(TrajectoryError):
    """Limits that no arm can move within, or that are not given."""


class Infeasible(TrajectoryError):
    """Nothing keeps to all limits from this start, in this region."""


class NotContinuous(TrajectoryError):
    """Parts of a motion that do not join in position, velocity or acceleration."""


class NothingToIdentify(TrajectoryError):
    """The model has no parameter that motion could show."""


class NotComparable(TrajectoryError):
    """Hypotheses that cannot be weighed against each other."""


class NotATrajectory(TrajectoryError):
    """A trajectory file that is not one, or of another version."""


class OutsideTrajectory(TrajectoryError):
    """A time before the start or after the end of a trajectory."""


class UnknownChoice(TrajectoryError, LookupError):
    """A criterion, family or format that there is not; the message lists the valid ones."""

    def __init__(self, kind: str, name: str, valid: Iterable[str], meant: str = "") -> None:
        super().__init__(
            f"there is no {kind} called '{name}'{meant or '.'} Valid: {listed(sorted(valid), name)}"
        )


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
