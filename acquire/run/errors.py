"""The errors of a run, each a fact with a value, a limit and what to try.

ExidynError
└── RunError          a run cannot begin, or not go on
    ├── NotAllowed    what is asked for must not be done with this arm
    ├── CannotStart   the arm does not stand where the motion can begin
    ├── NotConfirmed  not confirmed
    └── RunStopped    a run was stopped before its end
        └── Unsafe    and the arm still moves, or may
"""

from exidyn.identify.errors import ExidynError


class RunError(ExidynError, RuntimeError):
    """A run cannot begin, or not go on."""


class NotAllowed(RunError):
    """What is asked for must not be done with this arm."""


class CannotStart(RunError):
    """The arm does not stand where the motion can begin."""


class NotConfirmed(RunError):
    """Not confirmed."""


class RunStopped(RunError):
    """A run was stopped before its end, and what comes next needs it whole."""


class Unsafe(RunStopped):
    """A run has ended, and the arm still moves, or nobody knows whether it does."""
