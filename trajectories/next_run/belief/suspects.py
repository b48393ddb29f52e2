"""Suspects: what is not in the model after a search, and may be there."""

from typing import NamedTuple

from scipy.special import expit

from exidyn.identify.diagnosis.questions.block_answer import Answer
from exidyn.identify.diagnosis.search.search import SearchResult
from exidyn.identify.diagnosis.search.selected import EXCLUDED, contradicted, log_prior

from .belief import Place
from .rivals import rivals

NEGLIGIBLE = EXCLUDED / 100.0
"""Probability below which an effect that nothing suggests is not asked about; a hundred of them are still
excluded together."""


class Suspects(NamedTuple):
    """What is not in the model and may be there.

    Attributes:
        rivals: Of what was found.
        left: What else may be there without being seen, each in its best shape.
        against: Logarithm of the odds of each finding, by its place, against effects on joints.
    """

    rivals: tuple[Answer, ...]
    left: tuple[Answer, ...]
    against: dict[int, dict[Place, float]]

    @property
    def every(self) -> tuple[Answer, ...]:
        """In the order of their columns."""
        return self.rivals + self.left


def suspects_of(search: SearchResult) -> Suspects:
    """Alternatives of the findings, and what else gives their torque; then all that was not found."""
    others = {place: rivals(search, place) for place in range(len(search.selected))}
    found = [answer for one in search.selected for answer, _ in one.elsewhere]
    found += [rival.answer for own in others.values() for rival in own]
    by_key = {one.candidate.key: one for one in reversed(found)}
    left = [
        one
        for one in search.left
        if one.candidate.key not in by_key and unseen_probability(one, search.total) >= NEGLIGIBLE
    ]
    against = {place: {place_of(rival.answer): rival.odds for rival in own} for place, own in others.items()}
    return Suspects(tuple(by_key.values()), tuple(left), against)


def unseen_probability(one: Answer, total: float) -> float:
    """That an effect which was not found is there; zero where runs held out contradict it."""
    return 0.0 if contradicted(one) else float(expit(one.odds + log_prior(one, total)))


def place_of(one: Answer) -> Place:
    """Effect and joints of an answer."""
    return one.candidate.effect, one.candidate.joints
