"""The errors of `identify`, each a fact with a value, a limit and what to try.

ExidynError
├── RobotError          the description of the robot is wrong
│   ├── UnknownKey      a key in a robot file that is not known
│   ├── UnknownJoint    a joint the robot does not have
│   ├── EffectError     an effect of an installed package that cannot be used
│   └── BrokenTree      kinematics that are not one tree of one-degree-of-freedom joints
├── RecordingError      a recording cannot be what it claims to be
│   ├── WrongShape      columns or rows that do not fit the robot
│   ├── NotFinite       NaN or infinity where a number is needed
│   ├── NotRecorded     a signal that an effect needs, such as temperature, is not in the recording
│   ├── BadTime         time stamps that do not increase
│   ├── BadUnit         values that no joint or motor can have
│   ├── NotAFile        a file that does not hold what its name states, or is empty
│   └── DifferentRobot  runs of two different robots in one identification
├── MissingPackage      an optional package that is not installed
└── FitError            the data cannot carry what is asked of them
    ├── NotExcited      a motion too poor to identify
    └── NeedsPayload    drive gains asked for without a known payload
"""

import difflib
from collections.abc import Iterable

LONGEST = 290
"""Characters of a message: with the command's name before it, at most 300 are printed."""
HEAD = 200
"""Of those, how many are the beginning of a message that was longer; what to try stands at its end."""
LISTED = 200
"""Characters of a list of valid names, so that there is room for what is wrong."""


class ExidynError(Exception):
    """Base of every error raised on purpose; its text, one line of bounded length, is meant for the user."""

    def __init__(self, *arguments: object) -> None:
        super().__init__(*(shortened(one) if isinstance(one, str) else one for one in arguments))


def shortened(text: str) -> str:
    """A message in one line of at most `LONGEST` characters, without what a terminal would not print."""
    line = " ".join(text.split())
    line = "".join(one if one.isprintable() else repr(one)[1:-1] for one in line)
    if len(line) <= LONGEST:
        return line
    return f"{line[:HEAD]} ... {line[HEAD + 5 - LONGEST :]}"


def listed(names: Iterable[str], like: str = "") -> str:
    """Names with commas; if they are too many, those most like a given one, and how many more there are."""
    every = list(names)
    if len(", ".join(every)) <= LISTED:
        return ", ".join(every) or "none"
    near = difflib.get_close_matches(like, every, n=len(every), cutoff=0.0)
    shown: list[str] = []
    for name in near:
        if len(", ".join([*shown, name])) > LISTED:
            break
        shown.append(name)
    return f"{', '.join(shown)} and {len(every) - len(shown)} more" if shown else f"{len(every)} names"


class RobotError(ExidynError, ValueError):
    """The description of the robot is wrong."""


class RobotWarning(UserWarning):
    """Something in the description of a robot that no arm has, and with which one can go on all the same."""


class UnknownKey(RobotError):
    """A key that is not known; the message lists the valid ones."""

    def __init__(self, key: str, where: str, valid: "list[str] | tuple[str, ...]") -> None:
        super().__init__(f"{where}: unknown key '{key}'. Valid keys: {listed(sorted(valid), key)}")


class UnknownJoint(RobotError, LookupError):
    """A joint that the robot does not have; the message lists the valid ones."""

    def __init__(self, joint: object, robot: str, valid: "list[str] | tuple[str, ...]") -> None:
        problem = (
            f"has no joint '{joint}'" if isinstance(joint, str) else f"{joint!r}: joints are given by name"
        )
        super().__init__(f"{robot} {problem}. Valid joints: {listed(valid, str(joint))}")


class EffectError(RobotError):
    """An effect of an installed package that cannot be used; names the package."""


class BrokenTree(RobotError):
    """Kinematics that are not one tree of joints with one degree of freedom each."""


class RecordingError(ExidynError, ValueError):
    """A recording cannot be what it claims to be."""


class WrongShape(RecordingError):
    """Columns or rows that do not fit the robot."""


class NotFinite(RecordingError):
    """NaN or infinity where a number is needed; `time` is that of the first, if its stamp is finite [s]."""

    def __init__(self, text: str, time: float | None = None) -> None:
        super().__init__(text)
        self.time = time


class NotRecorded(RecordingError):
    """A signal that an effect needs, such as temperature, is not in the recording."""


class BadTime(RecordingError):
    """Time stamps that do not increase."""


class BadUnit(RecordingError):
    """Values that no joint or motor can have, such as a joint at 90 rad."""


class NotAFile(RecordingError):
    """A file that is missing, empty, or does not hold what its name states."""


class DifferentRobot(RecordingError):
    """Runs of two different robots in one identification."""


class MissingPackage(ExidynError, ImportError):
    """An optional package that is not installed; names the extra that brings it."""


class FitError(ExidynError, ArithmeticError):
    """The data cannot carry what is asked of them."""


class NotExcited(FitError):
    """A motion too poor to identify the model."""


class NeedsPayload(FitError):
    """Drive gains were asked for without a run that carries a known mass."""
