"""Guesses about a log and probable mistakes in it, as data and as one sentence."""

from dataclasses import dataclass

from ..text_table import percent

DECIDED = 0.95
"""Probability beyond which a guess is written to a file: at most one in twenty at the limit is wrong."""
CHECK_FIRST = "Check the input first"
UNLESS = "What follows holds only if the input is right."
"""Words before and after a suspicion in a verdict."""
NONE_OF_THESE = "none_of_these"
"""Name of the hypothesis of an unlisted mistake."""
OTHER_MASSES = "other_masses"
"""Name of the hypothesis that bodies fit, but not those of the description."""
AT_TIMES = "at_times"
"""Name of the hypothesis of a cause that acts only at times."""


@dataclass(frozen=True)
class Guess:
    """A guess with its probability."""

    what: str  # question that the guess answers
    value: str  # most probable answer
    probability: float  # probability of that answer, given the log and the robot
    why: str  # evidence for the answer
    option: str = ""  # option or key by which a person can state the answer

    @property
    def decided(self) -> bool:
        """Whether the answer is certain enough to be written to a file."""
        return self.probability > DECIDED


@dataclass(frozen=True)
class Suspicion:
    """Most probable mistake in a log."""

    name: str  # kind of mistake, a name in the table or `NONE_OF_THESE`
    joints: tuple[str, ...]  # names of the joints that show it
    what: str  # clause on what is wrong
    cure: str  # instruction for its correction
    # Probability of this mistake, compared with none, another in the table, or an unlisted one; None if
    # unknown.
    probability: float | None

    def __str__(self) -> str:
        """One sentence."""
        sure = "" if self.probability is None else f" (probability {percent(self.probability)})"
        return f"{self.what}{sure}: {self.cure}"
