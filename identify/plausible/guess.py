"""One thing that was guessed about a log."""

from dataclasses import dataclass

DECIDED = 0.95
"""Probability from which on a guess is written down: at most one in twenty of those at the limit is wrong."""


@dataclass(frozen=True)
class Guess:
    """One thing that was guessed.

    Attributes:
        what: What is asked.
        value: The likeliest answer.
        probability: Probability of that answer, given the log and the robot.
        why: What speaks for it.
        option: What a person does where it is wrong or not decided.
    """

    what: str
    value: str
    probability: float
    why: str
    option: str = ""

    @property
    def decided(self) -> bool:
        """Whether it is sure enough to be written down."""
        return self.probability > DECIDED
