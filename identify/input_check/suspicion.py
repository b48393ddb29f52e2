"""The likeliest mistake in a recording, as a person reads it."""

from dataclasses import dataclass

from ..text_table import percent

REFUSED = 0.99
"""Probability of a mistake from which on a recording is not used: a fit of wrong input costs more than a
question."""


@dataclass(frozen=True)
class Suspicion:
    """The likeliest mistake in a recording.

    Attributes:
        what: What is wrong, in a clause.
        cure: What to do about it.
        probability: That it is this mistake rather than none or another of those weighed.
        physical: Whether it may as well be found as a physical effect: a base that leans.
    """

    what: str
    cure: str
    probability: float
    physical: bool = False

    @property
    def certain(self) -> bool:
        """Whether the recording is not to be used."""
        return self.probability >= REFUSED and not self.physical

    def __str__(self) -> str:
        """One sentence."""
        return f"{self.what} (probability {percent(self.probability)}): {self.cure}"
