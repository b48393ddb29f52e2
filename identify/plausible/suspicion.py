"""A probable mistake in a log, as data and as one sentence."""

from dataclasses import dataclass

from ..text_table import percent

CHECK_FIRST = "Check the input first"
UNLESS = "What follows holds only if the input is right."
"""Words before and after a suspicion in a verdict."""
NONE_OF_THESE = "none_of_these"
"""Name of the hypothesis of an unlisted mistake."""


@dataclass(frozen=True)
class Suspicion:
    """Most probable mistake in a log.

    Attributes:
        name: Kind of mistake, a name in the table or `NONE_OF_THESE`.
        joints: Names of the joints that show it.
        what: Clause on what is wrong.
        cure: Instruction for its correction.
        probability: Probability of this mistake, compared with none, another in the table, or an unlisted
            one; None if unknown.
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
