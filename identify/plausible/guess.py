"""A guess about a log."""

from dataclasses import dataclass

DECIDED = 0.95
"""Probability beyond which a guess is written to a file: at most one in twenty at the limit is wrong."""


@dataclass(frozen=True)
class Guess:
    """A guess with its probability.

    Attributes:
        what: Question that the guess answers.
        value: Most probable answer.
        probability: Probability of that answer, given the log and the robot.
        why: Evidence for the answer.
        option: Option or key by which a person can state the answer.
    """

    what: str
    value: str
    probability: float
    why: str
    option: str = ""

    @property
    def decided(self) -> bool:
        """Whether the answer is certain enough to be written to a file."""
        return self.probability > DECIDED
