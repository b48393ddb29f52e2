"""The errors of `identify`, each a fact with a value, a limit and what to try.

ExidynError
├── RobotError          the description of the robot is wrong
│   ├── UnknownKey      a key in a robot file that nobody reads
│   ├── UnknownJoint    a joint the robot does not have
│   └── BrokenTree      kinematics that are not one tree of one-degree-of-freedom joints
├── RecordingError      a recording cannot be what it claims to be
│   ├── WrongShape      columns or rows that do not fit the robot
│   ├── NotFinite       NaN or infinity where a number is needed
│   ├── NotRecorded     a signal that an effect needs, such as temperature, is not in the recording
│   ├── BadTime         time stamps that do not increase
│   ├── BadUnit         values that no joint or motor can have
│   ├── NotAFile        a file that is not what its name says, or is empty
│   └── DifferentRobot  runs of two different robots in one identification
└── FitError            the data cannot carry what is asked of them
    ├── NotExcited      a motion too poor to identify
    └── NeedsPayload    drive gains asked for without a known payload
"""


class ExidynError(Exception):
    """Base of every error raised on purpose; its text is meant for the user."""


class RobotError(ExidynError, ValueError):
    """The description of the robot is wrong."""


class UnknownKey(RobotError):
    """A key that nobody reads; the message lists the valid ones."""

    def __init__(self, key: str, where: str, valid: "list[str] | tuple[str, ...]") -> None:
        super().__init__(f"{where}: unknown key '{key}'. Valid keys: {', '.join(sorted(valid)) or 'none'}")


class UnknownJoint(RobotError, LookupError):
    """A joint that the robot does not have; the message lists the valid ones."""

    def __init__(self, joint: object, robot: str, valid: "list[str] | tuple[str, ...]") -> None:
        said = f"has no joint '{joint}'" if isinstance(joint, str) else f"{joint!r}: joints are given by name"
        super().__init__(f"{robot} {said}. Valid joints: {', '.join(valid)}")


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
    """A file that is missing, empty, or not what its name says."""


class DifferentRobot(RecordingError):
    """Runs of two different robots in one identification."""


class FitError(ExidynError, ArithmeticError):
    """The data cannot carry what is asked of them."""


class NotExcited(FitError):
    """A motion too poor to identify the model."""


class NeedsPayload(FitError):
    """Drive gains were asked for without a run that carries a known mass."""
