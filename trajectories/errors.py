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

from collections.abc import Iterable

from exidyn.identify.errors import ExidynError, listed


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

    def __init__(self, kind: str, name: str, valid: Iterable[str]) -> None:
        super().__init__(f"there is no {kind} called '{name}'. Valid: {listed(sorted(valid), name)}")
