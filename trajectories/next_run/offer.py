"""Offer: a run that could be made or taken, and what it asks of a person."""

from dataclasses import dataclass

from exidyn.identify.recordings.recording import KnownPayload, Recording

from ..plans.plan import Plan


@dataclass(frozen=True, eq=False)
class Offer:
    """A run on offer.

    Attributes:
        name: What people call it, as "a swept sine" is.
        recording: Of the planned motion as the arm so far known would make it, or one that exists.
        plan: The motion; None for a recording that exists.
        request: What a person has to do before, in a sentence; empty for nothing.
        setup: Time that this takes [s].
    """

    name: str
    recording: Recording
    plan: Plan | None = None
    request: str = ""
    setup: float = 0.0

    @property
    def payload(self) -> KnownPayload | None:
        """What hangs on the flange."""
        return self.recording.payload

    @property
    def motion(self) -> float:
        """How long the arm moves [s]."""
        return float(self.recording.duration if self.plan is None else self.plan.trajectory.duration)

    @property
    def seconds(self) -> float:
        """How long it takes, a person's part included [s]."""
        return self.motion + self.setup
