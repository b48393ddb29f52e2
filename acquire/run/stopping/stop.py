"""Stop: why a run ends early, who asked for it, what the driver is asked for, and whether the arm stands."""

import signal
from collections.abc import Callable
from dataclasses import dataclass, replace
from types import FrameType
from typing import Any

from exidyn.drivers import Driver, StopLevel

WORDS = {StopLevel.BRAKE: "controlled stop", StopLevel.QUICK: "quick stop", StopLevel.OFF: "power off"}
"""Names of stops in messages."""

FAULT, SILENT = "drive fault", "silence"
"""Kinds of stops: a drive has stopped itself and reports why; a joint is silent."""
BRAKING = ("SIGINT", "SIGTERM", "SIGHUP")
"""Signals that request a stop, if the operating system has them."""


@dataclass(frozen=True)
class Stop:
    """A reason to stop."""

    level: StopLevel  # how hard to stop
    kind: str  # kind of stop: the monitored quantity or the requester
    text: str  # description with joint, value and limit, in a sentence
    joint: str = ""  # name of the joint; empty for all or none
    value: float = float("nan")  # measured or commanded value, in `unit`; NaN if there is none
    limit: float = float("nan")  # limit of the value, in `unit`
    unit: str = ""  # unit of value and limit

    @property
    def announcement(self) -> str:
        """Text printed during the run."""
        return f"{WORDS[self.level]}: {self.text}"

    def details(self) -> dict[str, object]:
        """Known fields for the recording, by name."""
        known = {"joint": self.joint, "value": self.value, "limit": self.limit, "unit": self.unit}
        return {
            "stop": self.kind,
            "level": self.level.name,
            **{n: v for n, v in known.items() if v != "" and v == v},
        }


def harder(first: Stop | None, second: Stop | None) -> Stop | None:
    """The harder of two stops; the first if both are equally hard."""
    if first is None or second is None:
        return first or second
    return second if second.level > first.level else first


class StopRequests:
    """A context manager, for the main thread, that turns signals into reasons to stop.

    Until the first call of `look`, nothing moves, and a driver may be waiting for a person; so the first
    request interrupts, as Ctrl-C usually does. Recorder and view have their own process groups, which Ctrl-C
    does not reach.
    """

    def __init__(self) -> None:
        self.stop: Stop | None = None
        self._looked = False
        self._old_handlers: dict[int, Any] = {}

    def __enter__(self) -> "StopRequests":
        for number in (getattr(signal, name) for name in BRAKING if hasattr(signal, name)):
            if number == getattr(signal, "SIGHUP", None) and signal.getsignal(number) == signal.SIG_IGN:
                continue  # nohup: the run must outlive the terminal
            self._old_handlers[number] = signal.signal(number, self._request)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._old_handlers.items():
            signal.signal(number, handler)

    def look(self) -> Stop | None:
        """The requested stop, if any; after the first call, requests no longer interrupt."""
        self._looked = True
        return self.stop

    def _request(self, number: int, frame: FrameType | None) -> None:
        repeated = self.stop is not None and number == signal.SIGINT
        name = signal.Signals(number).name
        level = StopLevel.QUICK if repeated else StopLevel.BRAKE
        words = "Ctrl-C again: quick stop" if repeated else f"asked to stop ({name})"
        if self.stop is None or level > self.stop.level:
            self.stop = Stop(level, "asked", words)
        if not self._looked:
            self._looked = True  # the cleanup must not be interrupted too
            raise KeyboardInterrupt


def after_failure(level: StopLevel, error: Exception) -> Stop | None:
    """The next harder stop after the driver failed at a level; None if there is none."""
    if level == StopLevel.OFF:
        return None
    return Stop(StopLevel(level + 1), "stop failed", f"the driver failed at {level.name}: {error}")


class Stops:
    """The stops of one run.

    Args:
        driver: Open driver.
        report: Function called with kind, text and details of each stop and failure.
        say: Function that prints a text during the run.
    """

    def __init__(
        self,
        driver: Driver,
        report: Callable[[str, str, dict[str, object]], None],
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        self._driver, self._report, self._say = driver, report, say
        self.reason: Stop | None = None  # stop that ends the run early; None if there is none so far
        self.escalated: list[Stop] = []  # harder stops requested because a stop did not work, in order
        self.level = 0  # hardest level requested so far; 0 for none

    @property
    def by_controller(self) -> bool:
        """Whether the controller makes the stop, so that commands have ended."""
        return self.level > StopLevel.BRAKE

    def begin(self, stop: Stop) -> bool:
        """Stop for a reason unless an equally hard stop is under way; return whether a stop has begun."""
        if stop.level <= self.level:
            return False
        self.reason = stop
        self._request(stop)
        return True

    def escalate(self, stop: Stop) -> None:
        """Stop harder because the stop under way does not work."""
        if stop.level <= self.level:
            return
        if self.reason is None:
            self.reason = stop
        else:
            self.escalated.append(stop)
        self._request(stop)

    def explain(self, fault: str) -> None:
        """Add the cause of a silence if the controller reports one later, such as a loss of power."""
        if self.reason is None or self.reason.kind != SILENT:
            return
        self.reason = replace(self.reason, kind=FAULT, text=f"{fault}. Before that, {self.reason.text}")
        self._say(f"reason of the stop: {fault}")
        self._report("cause", fault, self.reason.details())

    def _request(self, stop: Stop) -> None:
        self.level = stop.level
        self._say(stop.announcement)
        failure = self._send(stop.level)
        self._report("stop", stop.text, stop.details())
        if failure is None:
            return
        if harder_stop := after_failure(stop.level, failure):
            self.escalate(harder_stop)
        else:
            text = f"the driver failed at {stop.level.name}, the hardest stop: {failure}"
            self._say(text)
            self._report("warning", text, {})

    def _send(self, level: StopLevel) -> Exception | None:
        """Request a stop from the driver and return its error, if any; commands make a controlled stop."""
        if level == StopLevel.BRAKE:
            return None
        try:
            self._driver.stop(level)
        except Exception as error:  # whatever it is, the next level must be requested
            return error
        return None


RESTING = 0.01
"""Speed below which a joint is at rest [rad/s]: half a degree per second, or seven standard deviations of the
speed that a coarse encoder (1.5 mrad) at 125 Hz shows over half a second at rest."""
EMERGENCY = "PRESS THE EMERGENCY STOP"


@dataclass(frozen=True)
class Standstill:
    """Whether the arm stands."""

    moving: bool | None  # whether the arm still moves; None if unknown
    text: str  # sentence with joint, speed and what to do
    # Name of the fastest joint, or of the joint furthest from its last command; empty for none.
    joint: str = ""
    speed: float = float("nan")  # speed of the fastest joint, in `unit`; NaN where unknown
    unit: str = ""  # "rad/s" or "m/s"
    # Distance of that joint from its last command [rad] or [m], if it exceeds the limit; else NaN.
    away: float = float("nan")

    @property
    def stands(self) -> bool:
        """Whether the arm is known to stand."""
        return self.moving is False

    @property
    def expected(self) -> bool:
        """Whether the arm stands where it was commanded."""
        return self.stands and not self.away > 0.0

    def details(self) -> dict[str, object]:
        """Known fields for JSON and the recording, by name."""
        known = {"joint": self.joint, "speed": self.speed, "unit": self.unit, "away": self.away}
        known = {name: value for name, value in known.items() if value != "" and value == value}
        return {"moving": self.moving, "standstill": self.text, **known}


def unknown_at_end(reason: str) -> Standstill:
    """Standstill of an arm that cannot be observed for some reason."""
    return Standstill(None, f"WHETHER THE ARM STANDS IS NOT KNOWN ({reason}): {EMERGENCY}")
