"""A mistake that a log seems to have: as data, and in one sentence."""

from dataclasses import dataclass

from ..text_table import percent

CHECK_FIRST = "Check the input first"
UNLESS = "What follows holds only if the input is right."
"""Before and behind a suspicion in a verdict."""
NONE_OF_THESE = "none_of_these"
"""Name of the hypothesis that something is wrong which no row of the table lists."""


@dataclass(frozen=True)
class Suspicion:
    """The likeliest mistake in a log.

    Attributes:
        name: Kind of mistake, a name of the table or `NONE_OF_THESE`.
        joints: Joints that show it.
        what: What is wrong, in a clause.
        cure: What to do about it.
        probability: That it is this mistake, rather than none, another of the table, or something that is not
            listed; None where it is not known.
    """

    name: str
    joints: tuple[str, ...]
    what: str
    cure: str
    probability: float | None

    def __str__(self) -> str:
        """One sentence."""
        sure = "" if self.probability is None else f" (probability {percent(self.probability)})"
        return f"{self.what}{sure}: {self.cure}"
