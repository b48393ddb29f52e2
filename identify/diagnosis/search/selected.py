"""Selected: an effect that is credible, and what else may explain the same."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..candidates import family_of
from ..findings.family import FAMILIES
from ..questions.block_answer import CERTAIN_ODDS, Answer
from ..questions.candidate import Candidate
from ..questions.comparison import SEEN, better, competing
from ..questions.shape import Shaped

NAMED = 0.9
"""Probability from which on something is named: it is nine times as likely as all else together."""
NAMED_ODDS = float(np.log(NAMED / (1.0 - NAMED)))
"""Logarithm of the odds at that probability."""
EXCLUDED = 0.01
"""Probability below which something is no alternative any more, and is not listed."""
EXCLUDED_ODDS = float(-np.log(EXCLUDED))
"""Logarithm of the odds against something from which on it is not compared any further."""
ByBlocks = Callable[[Answer, Answer], float]
"""Logarithm of the odds of one answer against another, by how blocks left out scatter."""


class FamilyShare(NamedTuple):
    """A family to which an effect belongs, and the probability that it is any member of it."""

    name: str
    probability: float


class Selected(NamedTuple):
    """An effect that was found, and what else it might be."""

    answer: Answer  # the effect
    odds: float  # logarithm of the odds that it is there, after every check
    others: tuple[tuple[Answer, float], ...] = ()  # what may explain the same, log odds against each
    once: bool = False  # whether it happened once, so that no other block predicts it
    alone: bool = False  # whether one joint alone shows what acts on the whole arm: not named then
    proven: bool = True  # whether its effect on fitted blocks and on runs held out excludes zero
    unnamed: float = 0.0  # what is left beside it without a name, over what it explains [-]

    @property
    def predicts_held_out(self) -> bool:
        """Whether runs held out can support or contradict it."""
        return not self.once and not self.answer.candidate.by_run

    @property
    def _weights(self) -> np.ndarray:
        """Of nothing, of the effect itself and of the others, over that of the effect, (2 + m,)."""
        return np.exp(-np.clip([self.odds, 0.0, *(odds for _, odds in self.others)], -700.0, 700.0))

    @property
    def probability(self) -> float:
        """That it is there, and that it is this and nothing else that explains the same."""
        return float(self._share / self._weights.sum())

    @property
    def certainty(self) -> float:
        """The same of its effect on its joints, of whatever shape or frequency."""
        here = self.answer.candidate
        alike = [p for one, p in self.not_excluded if _place(one.candidate) == _place(here)]
        return self.probability + sum(alike)

    @property
    def together(self) -> float:
        """Logarithm of how much likelier it is that any rival on its joints is there than this one alone."""
        here = self.answer.candidate.joints
        alike = [-odds for one, odds in self.others if one.candidate.joints == here]
        return float(np.logaddexp.reduce([0.0, *alike]))

    @property
    def family(self) -> FamilyShare | None:
        """The narrowest family on its joints that is certain enough to be named; None if unproven too."""
        narrow = family_of(self.answer.candidate) if self.proven else ""
        wide = FAMILIES[narrow].dependence if narrow else ""
        shares = (FamilyShare(name, self._probability_of(name)) for name in (narrow, wide) if name)
        return next((one for one in shares if one.probability >= NAMED), None)

    @property
    def dependence_probability(self) -> float:
        """That something is there whose torque depends on what this one's depends on."""
        narrow = family_of(self.answer.candidate)
        return self._probability_of(FAMILIES[narrow].dependence) if narrow else self.certainty

    def _probability_of(self, family: str) -> float:
        """That it is any member of a family on the same joints."""
        here, weights = self.answer.candidate, self._weights
        every = [here, *(one.candidate for one, _ in self.others)]
        members = _families_of(family)
        alike = [one.joints == here.joints and family_of(one) in members for one in every]
        return float(weights[1:][alike].sum() * self._share / weights.sum())

    @property
    def _share(self) -> float:
        """Of what is not noise: where physics without a name does as much, this may be a part of that."""
        return 1.0 / (1.0 + self.unnamed) if self.unnamed >= 1.0 else 1.0

    @property
    def named(self) -> bool:
        """Whether its effect is certain enough to be named."""
        return self.certainty >= NAMED and not self.alone and self.proven

    @property
    def elsewhere(self) -> list[tuple[Answer, float]]:
        """Other effects, or other joints, that are not excluded, each once and with its probability."""
        here = _place(self.answer.candidate)
        first = {_place(one.candidate): (one, p) for one, p in self.not_excluded[::-1]}
        return [pair for place, pair in reversed(first.items()) if place != here]

    @property
    def not_excluded(self) -> list[tuple[Answer, float]]:
        """Others that are credible enough to be reported, with their probability."""
        weights = self._weights
        every = zip(self.others, weights[2:] * self._share / weights.sum(), strict=True)
        return [(one, float(p)) for (one, _), p in every if p > EXCLUDED]


def _families_of(name: str) -> tuple[str, ...]:
    """A family, and those that it contains."""
    return (name, *(inner for inner, family in FAMILIES.items() if family.dependence == name))


def _place(candidate: Candidate) -> tuple[str, tuple[int, ...]]:
    return candidate.same_torque or (candidate.effect, candidate.joints)


def log_prior(answer: Answer, total: float) -> float:
    """Logarithm of the prior odds of one hypothesis, of all hypotheses' total weight.

    All together are as likely as nothing.
    """
    return float(np.log(answer.candidate.prior / total))


def odds_of(answer: Answer, total: float) -> float:
    """Logarithm of the odds that an effect is there, with the prior of its hypothesis.

    What acts on the whole arm is not there unless it is also seen without the joint that sees most of it.
    """
    if not answer.candidate.joints and len(answer.by_joint) > 1:
        if not answer.gain - max(float(answer.by_joint.max()), 0.0) > CERTAIN_ODDS:
            return -np.inf
    return _odds(answer, total)


def contradicted(answer: Answer) -> bool:
    """Whether runs held out are less probable with it, beyond what scatter of its coefficients makes."""
    return answer.held_out < -answer.scatter_held_out


def _odds(answer: Answer, total: float) -> float:
    """The same, whether or not one joint alone sees it: so what else may explain a finding is weighed."""
    everywhere = not answer.candidate.everywhere or _everywhere(answer)
    return answer.odds + log_prior(answer, total) if everywhere and answer.gain > 0.0 else -np.inf


def _everywhere(answer: Answer) -> bool:
    """Whether every joint is predicted better, and at least half of them clearly.

    Where the clock that all drives share had to be beyond its prior without it, blocks are predicted as well
    with that clock, and none may be predicted clearly worse.
    """
    if answer.relief > CERTAIN_ODDS:
        return bool(np.all(answer.by_joint > -SEEN))
    return bool(np.all(answer.by_joint > 0.0)) and bool(np.median(answer.by_joint) > SEEN)


def judged(best: Sequence[Answer], total: float, blocks: ByBlocks) -> Selected | None:
    """The most probable hypothesis that is credible, with what else may explain the same.

    Another counts for no more than the odds that it is there at all. Where no name is certain the likeliest
    comes first, even if one joint alone shows it.

    Args:
        best: One answer for each hypothesis, the most probable first.
        total: Sum of the prior weights of all hypotheses.
        blocks: Logarithm of the odds of one answer against another by how blocks scatter.
    """

    def against(one: Answer, other: Answer) -> float:
        prior = log_prior(one, total) - log_prior(other, total)
        return better(one, other, blocks(one, other), prior)

    likely = [one for one in best if odds_of(one, total) > CERTAIN_ODDS] or _together(best, total)
    if not likely:
        return None
    first = likely[0]
    for one in likely[1:]:
        if competing(one, first) and against(one, first) > 0.0:
            first = one
    found = _beside_others(first, odds_of(first, total), best, total, against)
    if found.named or not found.others or found.others[0][1] > 0.0:
        return found
    likelier = found.others[0][0]
    odds = _odds(likelier, total)
    if odds < CERTAIN_ODDS:
        return found
    again = _beside_others(likelier, odds, best, total, against)
    return again._replace(alone=odds_of(likelier, total) < CERTAIN_ODDS)


def _together(best: Sequence[Answer], total: float) -> list[Answer]:
    """The likeliest of rivals on the same joints, none credible alone, where it is credible that it is any.

    Hypotheses exclude one another, so that their odds against nothing add up.
    """
    groups: dict[tuple[int, ...], list[Answer]] = {}
    for one in best:
        if np.isfinite(odds_of(one, total)) and one.candidate.joints:
            groups.setdefault(one.candidate.joints, []).append(one)
    odds = {
        joints: float(np.logaddexp.reduce([odds_of(one, total) for one in group]))
        for joints, group in groups.items()
    }
    joints = max(odds, key=lambda key: odds[key], default=None)
    if joints is None or odds[joints] < NAMED_ODDS:
        return []
    return [max(groups[joints], key=lambda one: odds_of(one, total))]


def _beside_others(
    first: Answer, odds: float, best: Sequence[Answer], total: float, against: ByBlocks
) -> Selected:
    """One hypothesis with what else may explain the same."""
    others = []
    for one in best:
        if one is not first and competing(one, first) and one.gain > 0.0:
            # It does not matter whether a second joint shows it, as a base tilt may be seen on one alone.
            less = odds - _odds(one, total)
            others.append((one, less if less > EXCLUDED_ODDS else max(against(first, one), less)))
    return Selected(first, odds, tuple(sorted(others, key=lambda pair: pair[1])))


def credible(odds: float, one: Selected) -> bool:
    """Whether a finding is there at other odds: itself, or, as one of its rivals would be, any of them."""
    return odds > CERTAIN_ODDS or odds + one.together > NAMED_ODDS


def answers_of(found: Sequence[Selected]) -> list[Answer]:
    """Effects of findings, in their order."""
    return [one.answer for one in found]


def keys_of(found: Sequence[Selected]) -> set[object]:
    """Hypotheses of findings."""
    return {one.answer.candidate.key for one in found}


def shapes_of(found: Sequence[Selected]) -> list[Shaped]:
    """Shapes of findings, to be asked for again."""
    return [Shaped.of(one.answer.candidate) for one in found if one.answer.candidate.bounds]
