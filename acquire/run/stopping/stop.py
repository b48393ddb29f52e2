"""Stop: why a run ends before its time, what a person asks for, and what was asked of the driver."""

import signal
from collections.abc import Callable
from dataclasses import dataclass, replace
from types import FrameType
from typing import Any

from exidyn.drivers import Driver, StopLevel

WORDS = {StopLevel.BRAKE: "controlled stop", StopLevel.QUICK: "quick stop", StopLevel.OFF: "power off"}
"""Stops as a person reads them."""

FAULT, SILENT = "drive fault", "silence"
"""Kinds of stops: a drive has stopped itself and says why, a joint is not heard."""
BRAKING = ("SIGINT", "SIGTERM", "SIGHUP")
"""What is taken for a request, where the operating system has it."""


@dataclass(frozen=True)
class Stop:
    """One reason to stop.

    Attributes:
        level: How hard.
        kind: A word: what was watched, or who asked.
        text: In a sentence, with joint, value and limit.
        joint: Name of the joint; empty for all or none.
        value: What was measured or asked for, in `unit`; NaN where there is none.
        limit: What the value was held against.
        unit: Unit of value and limit.
    """

    level: StopLevel
    kind: str
    text: str
    joint: str = ""
    value: float = float("nan")
    limit: float = float("nan")
    unit: str = ""

    @property
    def announcement(self) -> str:
        """The stop as it is printed during the run."""
        return f"{WORDS[self.level]}: {self.text}"

    def details(self) -> dict[str, object]:
        """For the recording: what is known of it, by name."""
        known = {"joint": self.joint, "value": self.value, "limit": self.limit, "unit": self.unit}
        return {
            "stop": self.kind,
            "level": self.level.name,
            **{n: v for n, v in known.items() if v != "" and v == v},
        }


def harder(one: Stop | None, other: Stop | None) -> Stop | None:
    """The reason that counts: the first one, unless the second asks for more."""
    if one is None or other is None:
        return one or other
    return other if other.level > one.level else one


UnitOf = Callable[[int, str], str]
"""The unit of one joint, by its column, given that of revolute joints; `Robot.unit`."""


def turning(joint: int, unit: str) -> str:
    """The unit of a joint of an arm that has only revolute ones."""
    return unit


class StopRequests:
    """A context manager that turns signals into reasons to stop. For the main thread.

    Until the request is read, nothing moves, and a driver may be waiting for a person: then the first
    request interrupts, as Ctrl-C usually does. A recorder and a view have process groups of their own, so
    Ctrl-C does not reach them.
    """

    def __init__(self) -> None:
        self.stop: Stop | None = None
        self._looked = False
        self._before: dict[int, Any] = {}

    def __enter__(self) -> "StopRequests":
        for number in (getattr(signal, name) for name in BRAKING if hasattr(signal, name)):
            if number == getattr(signal, "SIGHUP", None) and signal.getsignal(number) == signal.SIG_IGN:
                continue  # nohup: the run is to outlive the terminal
            self._before[number] = signal.signal(number, self._ask)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def look(self) -> Stop | None:
        """What is asked for; from the first look on nothing is interrupted."""
        self._looked = True
        return self.stop

    def _ask(self, number: int, frame: FrameType | None) -> None:
        again = self.stop is not None and number == signal.SIGINT
        name = signal.Signals(number).name
        level = StopLevel.QUICK if again else StopLevel.BRAKE
        words = "Ctrl-C again: quick stop" if again else f"asked to stop ({name})"
        if self.stop is None or level > self.stop.level:
            self.stop = Stop(level, "asked", words)
        if not self._looked:
            self._looked = True  # what is done on the way out must not be interrupted too
            raise KeyboardInterrupt


def after_failure(level: StopLevel, why: Exception) -> Stop | None:
    """What to ask at once of a driver that could not do what was asked; None where nothing is left."""
    if level == StopLevel.OFF:
        return None
    return Stop(StopLevel(level + 1), "stop failed", f"the driver failed at {level.name}: {why}")


class Stops:
    """The stops of one run.

    Args:
        driver: Open.
        report: Called with every stop and failure: kind of event, text and details.
        say: Called with each text that is to be printed during the run.

    Attributes:
        reason: Why the run ends before its time; None as long as it does not.
        escalated: What was asked for because a stop did not work, in order.
        level: Hardest level asked for so far; 0 for none.
    """

    def __init__(
        self,
        driver: Driver,
        report: Callable[[str, str, dict[str, object]], None],
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        self._driver, self._report, self._say = driver, report, say
        self.reason: Stop | None = None
        self.escalated: list[Stop] = []
        self.level = 0

    @property
    def by_controller(self) -> bool:
        """Whether the stop is left to the controller, so that commands have ended."""
        return self.level > StopLevel.BRAKE

    def begin(self, found: Stop) -> bool:
        """Stop for a reason, unless as hard a stop is under way; whether it is not."""
        if found.level <= self.level:
            return False
        self.reason = found
        self._ask(found)
        return True

    def escalate(self, found: Stop) -> None:
        """Stop harder, for the stop under way does not work."""
        if found.level <= self.level:
            return
        if self.reason is None:
            self.reason = found
        else:
            self.escalated.append(found)
        self._ask(found)

    def explain(self, fault: str) -> None:
        """Name the cause of a silence that the controller has reported since, such as a loss of power."""
        if self.reason is None or self.reason.kind != SILENT:
            return
        self.reason = replace(self.reason, kind=FAULT, text=f"{fault}. Before that {self.reason.text}")
        self._say(f"the reason of the stop: {fault}")
        self._report("cause", fault, self.reason.details())

    def _ask(self, stop: Stop) -> None:
        self.level = stop.level
        self._say(stop.announcement)
        failure = self._sent(stop.level)
        self._report("stop", stop.text, stop.details())
        if failure is None:
            return
        if harder_stop := after_failure(stop.level, failure):
            self.escalate(harder_stop)
        else:
            text = f"the driver failed at {stop.level.name}, and nothing is left: {failure}"
            self._say(text)
            self._report("warning", text, {})

    def _sent(self, level: StopLevel) -> Exception | None:
        """Hand a level on to the driver; what went wrong. A brake is made by commands."""
        if level == StopLevel.BRAKE:
            return None
        try:
            self._driver.stop(level)
        except Exception as error:  # whatever it is, the next level must be asked for
            return error
        return None
