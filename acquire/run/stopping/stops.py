"""Stops: what was asked of the driver, and why; a level only ever rises."""

from collections.abc import Callable
from dataclasses import replace

from exidyn.drivers import Driver, StopLevel

from .escalation import after_failure
from .stop import FAULT, SILENT, Stop


class Stops:
    """The stops of one run.

    Args:
        driver: Open.
        report: Called with every stop and failure: kind of event, text and details.

    Attributes:
        reason: Why the run ends before its time; None as long as it does not.
        escalated: What was asked for because a stop did not work, in order.
        level: Hardest level asked for so far; 0 for none.
    """

    def __init__(self, driver: Driver, report: Callable[[str, str, dict[str, object]], None]) -> None:
        self._driver, self._report = driver, report
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
        self._report("cause", fault, self.reason.details())

    def _ask(self, stop: Stop) -> None:
        self.level = stop.level
        failure = self._sent(stop.level)
        self._report("stop", stop.text, stop.details())
        if failure is None:
            return
        harder = after_failure(stop.level, failure)
        if harder is not None:
            self.escalate(harder)
        else:
            self._report(
                "warning", f"the driver failed at {stop.level.name}, and nothing is left: {failure}", {}
            )

    def _sent(self, level: StopLevel) -> Exception | None:
        """Hand a level on to the driver; what went wrong. A brake is made by commands."""
        if level == StopLevel.BRAKE:
            return None
        try:
            self._driver.stop(level)
        except Exception as error:  # whatever it is, the next level must be asked for
            return error
        return None
