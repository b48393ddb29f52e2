"""Errors of `identify`: each states a fact, a value, a limit and what to try.

ExidynError
├── RobotError          the description of the robot is wrong
│   ├── UnknownKey      an unknown key in a robot file
│   ├── UnknownJoint    a joint the robot does not have
│   ├── EffectError     an effect of an installed package that cannot be used
│   └── BrokenTree      kinematics that are not one tree of one-degree-of-freedom joints
├── RecordingError      a recording is wrong or incomplete
│   ├── WrongShape      columns or rows that do not match the robot
│   ├── NotFinite       NaN or infinity where a number is needed
│   ├── NotRecorded     a signal that an effect needs, such as temperature, is not in the recording
│   ├── BadTime         time stamps that do not increase
│   ├── BadUnit         values that no joint or motor can have
│   ├── NotAFile        a file that does not hold what its name states, or is empty
│   └── DifferentRobot  runs of two different robots in one identification
├── MissingPackage      an optional package that is not installed
└── FitError            the data do not determine the requested parameters
    ├── NotExcited      a motion too poor to identify the model
    └── NeedsPayload    drive gains requested without a known payload
"""

import difflib
from collections.abc import Iterable

LONGEST = 290
"""Maximum length of a message in characters: with the command's name before it, at most 300 are printed."""
HEAD = 200
"""Characters kept from the start of a longer message; the rest come from its end, which says what to try."""
LISTED = 200
"""Maximum length of a list of valid names in characters, which leaves room for what is wrong."""


class ExidynError(Exception):
    """Base of every error raised on purpose; its text is one line of bounded length for the user."""

    def __init__(self, *arguments: object) -> None:
        super().__init__(
            *(shortened(argument) if isinstance(argument, str) else argument for argument in arguments)
        )


def shortened(text: str) -> str:
    """The message in one line of at most `LONGEST` characters, with unprintable characters escaped."""
    line = " ".join(text.split())
    line = "".join(char if char.isprintable() else repr(char)[1:-1] for char in line)
    if len(line) <= LONGEST:
        return line
    return f"{line[:HEAD]} ... {line[HEAD + 5 - LONGEST :]}"


def listed(names: Iterable[str], like: str = "") -> str:
    """Names separated by commas; if the list is too long, the names most similar to `like` and a count."""
    all_names = list(names)
    if len(", ".join(all_names)) <= LISTED:
        return ", ".join(all_names) or "none"
    by_similarity = difflib.get_close_matches(like, all_names, n=len(all_names), cutoff=0.0)
    shown: list[str] = []
    for name in by_similarity:
        if len(", ".join([*shown, name])) > LISTED:
            break
        shown.append(name)
    return (
        f"{', '.join(shown)} and {len(all_names) - len(shown)} more" if shown else f"{len(all_names)} names"
    )


class RobotError(ExidynError, ValueError):
    """The description of the robot is wrong."""


class RobotWarning(UserWarning):
    """An implausible value in the description of a robot, which can be used nevertheless."""


class UnknownKey(RobotError):
    """An unknown key; the message lists the valid keys."""

    def __init__(self, key: str, where: str, valid: "list[str] | tuple[str, ...]") -> None:
        super().__init__(f"{where}: unknown key '{key}'. Valid keys: {listed(sorted(valid), key)}")


class UnknownJoint(RobotError, LookupError):
    """A joint that the robot does not have; the message lists the valid joints."""

    def __init__(self, joint: object, robot: str, valid: "list[str] | tuple[str, ...]") -> None:
        problem = (
            f"has no joint '{joint}'" if isinstance(joint, str) else f"{joint!r}: joints are given by name"
        )
        super().__init__(f"{robot} {problem}. Valid joints: {listed(valid, str(joint))}")


class EffectError(RobotError):
    """An effect of an installed package that cannot be used; the message names the package."""


class BrokenTree(RobotError):
    """Kinematics that are not one tree of joints with one degree of freedom each."""


class RecordingError(ExidynError, ValueError):
    """A recording is wrong or incomplete.

    Attributes:
        fact: The error without advice, if an option of the import may cure it; else empty.
    """

    fact = ""


class WrongShape(RecordingError):
    """Columns or rows that do not match the robot."""


class NotFinite(RecordingError):
    """NaN or infinity where a finite number is needed.

    `time` is the time of the first such sample [s], or None if its time stamp is not finite.
    """

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
    """An optional package that is not installed; the message names the extra that installs it."""


class FitError(ExidynError, ArithmeticError):
    """The data do not determine the requested parameters."""


class NotExcited(FitError):
    """A motion too poor to identify the model."""


class NeedsPayload(FitError):
    """Drive gains were requested without a run that carries a known mass."""
