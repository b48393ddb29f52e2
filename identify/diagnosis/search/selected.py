"""Selected: a credible effect, and its rivals, which may explain the same."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..candidates import dependence_of, family_of
from ..findings.family import FAMILIES
from ..questions.block_answer import CERTAIN_ODDS, Answer, against_all
from ..questions.candidate import Candidate
from ..questions.comparison import better, competing

NAMED = 0.9
"""Probability from which on an effect is named: nine times that of all alternatives together."""
NAMED_ODDS = float(np.log(NAMED / (1.0 - NAMED)))
"""Log odds at that probability."""
EXCLUDED = 0.01
"""Probability below which a rival is excluded, and not listed."""
EXCLUDED_ODDS = float(-np.log(EXCLUDED))
"""Log odds against a rival from which on it is not compared any further."""
ByBlocks = Callable[[Answer, Answer], float]
"""Log odds of one answer against another, from the scatter of left-out blocks."""


class Selected(NamedTuple):
    """A finding and its rivals."""

    answer: Answer  # the effect
    odds: float  # log odds that it is there, after every check
    others: tuple[tuple[Answer, float], ...] = ()  # rivals, and the log odds against each
    once: bool = False  # whether it happened once, so that no other block predicts it
    alone: bool = False  # whether one joint alone shows an effect on the whole arm, which is then not named
    proven: bool = True  # whether its effect on fitted blocks and on held-out runs excludes zero
    conditional: bool = False  # whether free bodies absorb it, so that it depends on the described ones
    unnamed: float = 0.0  # unexplained squared torque over that explained by it [-]
    fits: bool = True  # whether the model with all findings fits its joints as correct models do

    @property
    def predicts_held_out(self) -> bool:
        """Whether held-out runs can support or contradict it."""
        return not self.once and not self.answer.candidate.by_run

    @property
    def by_priors(self) -> bool:
        """Whether it is credible because nominal values would otherwise be far off."""
        return self.answer.relief > CERTAIN_ODDS

    @property
    def _weights(self) -> np.ndarray:
        """Relative probabilities of "no effect", of this effect (1) and of its rivals, (2 + m,)."""
        return np.exp(-np.clip([self.odds, 0.0, *(odds for _, odds in self.others)], -700.0, 700.0))

    @property
    def probability(self) -> float:
        """Probability that it is there, and is this effect and none of its rivals."""
        return float(self._share / self._weights.sum())

    @property
    def certainty(self) -> float:
        """Probability of the same effect on the same joints, in any shape or at any frequency."""
        here = self.answer.candidate
        alike = [p for rival, p in self.not_excluded if _place(rival.candidate) == _place(here)]
        return self.probability + sum(alike)

    @property
    def together(self) -> float:
        """Log of how much likelier this effect or any rival on its joints is than this effect alone."""
        here = self.answer.candidate.joints
        alike = [-odds for rival, odds in self.others if rival.candidate.joints == here]
        return float(np.logaddexp.reduce([0.0, *alike]))

    @property
    def family(self) -> tuple[str, float]:
        """The narrowest family on its joints that is certain enough to be named, and its probability.

        Empty and NaN without such a family, or if the finding is unproven.
        """
        candidate = self.answer.candidate
        families = (family_of(candidate), dependence_of(candidate)) if self.proven and self.fits else ()
        shares = ((name, self._probability_of(name)) for name in families if name)
        return next(((name, p) for name, p in shares if p >= NAMED), ("", float("nan")))

    def _probability_of(self, family: str) -> float:
        """Probability that it is any member of a family on the same joints."""
        here, weights = self.answer.candidate, self._weights
        hypotheses = [here, *(rival.candidate for rival, _ in self.others)]
        members = _families_of(family)
        alike = [other.joints == here.joints and family_of(other) in members for other in hypotheses]
        return float(weights[1:][alike].sum() * self._share / weights.sum())

    @property
    def _share(self) -> float:
        """Share of the probability left to it: unexplained torque of the same size may include its own."""
        return 1.0 / (1.0 + self.unnamed) if self.unnamed >= 1.0 else 1.0

    @property
    def named(self) -> bool:
        """Whether its effect is certain enough to be named."""
        return self.certainty >= NAMED and not self.alone and self.proven and self.fits

    @property
    def elsewhere(self) -> list[tuple[Answer, float]]:
        """Other effects, or other joints, that are not excluded, each once with its probability."""
        here = _place(self.answer.candidate)
        first = {_place(rival.candidate): (rival, p) for rival, p in self.not_excluded[::-1]}
        return [pair for place, pair in reversed(first.items()) if place != here]

    @property
    def not_excluded(self) -> list[tuple[Answer, float]]:
        """Rivals that are credible enough to be reported, with their probability."""
        weights = self._weights
        rivals = zip(self.others, weights[2:] * self._share / weights.sum(), strict=True)
        return [(rival, float(p)) for (rival, _), p in rivals if p > EXCLUDED]


def _families_of(name: str) -> tuple[str, ...]:
    """A family, and the families that it contains."""
    return (name, *(inner for inner, family in FAMILIES.items() if family.dependence == name))


def _place(candidate: Candidate) -> tuple[str, tuple[int, ...]]:
    return candidate.same_torque or (candidate.effect, candidate.joints)


def log_prior(answer: Answer, total: float) -> float:
    """Prior log odds of one hypothesis, given the total prior weight of all hypotheses.

    All hypotheses together are as likely as "no effect".
    """
    return float(np.log(answer.candidate.prior / total))


def odds_of(answer: Answer, total: float) -> float:
    """Log odds that an effect is there, with the prior of its hypothesis.

    It must be seen on joints to which it gives torque: others gain if it frees masses that fit errors there.
    An effect on the whole arm must also be seen without the joint that shows it best. Otherwise -inf.
    """
    seen = float(answer.by_joint[answer.columns.joints].sum())
    if not answer.candidate.joints and len(answer.by_joint) > 1:
        seen = answer.gain - answer.relief - max(float(answer.by_joint.max()), 0.0)
    return odds_on_any_joint(answer, total) if seen + answer.relief > CERTAIN_ODDS else -np.inf


def contradicted(answer: Answer) -> bool:
    """Whether it makes held-out runs less probable than scatter of its coefficients alone would."""
    return answer.held_out < -answer.scatter_held_out


def odds_on_any_joint(answer: Answer, total: float) -> float:
    """Log odds that an effect is there, even if one joint alone sees it: for weighing rivals."""
    if not answer.gain > 0.0:
        return -np.inf
    several = answer.candidate.everywhere and len(answer.by_joint) > 1
    odds = against_all(answer.odds, _common(answer, total)) if several else answer.odds
    return odds + log_prior(answer, total)


def _common(answer: Answer, total: float) -> float:
    """Log odds of one effect on the whole arm against separate effects on the joints that show it.

    Each separate effect costs the prior of one more hypothesis.
    """
    price = float(np.log(total))
    return float(answer.gain - price - np.maximum(answer.by_joint - price, 0.0).sum())


def most_probable(best: Sequence[Answer], total: float, blocks: ByBlocks) -> Selected | None:
    """The most probable credible hypothesis, with its rivals.

    A rival counts for no more than the odds that it is there at all. If no hypothesis is certain enough to be
    named, the likeliest is returned, even if one joint alone shows it.

    Args:
        best: One answer for each hypothesis, most probable first.
        total: Sum of the prior weights of all hypotheses.
        blocks: Returns the log odds of one answer against another from the scatter of blocks.
    """
    against = _against(total, blocks)
    likely = [answer for answer in best if odds_of(answer, total) > CERTAIN_ODDS] or _together(best, total)
    if not likely:
        return None
    first = likely[0]
    for answer in likely[1:]:
        if competing(answer, first) and against(answer, first) > 0.0:
            first = answer
    finding = _with_rivals(first, odds_of(first, total), best, total, against)
    if finding.named or not finding.others or finding.others[0][1] > 0.0:
        return finding
    likelier = finding.others[0][0]
    odds = odds_on_any_joint(likelier, total)
    if odds < CERTAIN_ODDS:
        return finding
    replacement = _with_rivals(likelier, odds, best, total, against)
    return replacement._replace(alone=odds_of(likelier, total) < CERTAIN_ODDS)


def _together(best: Sequence[Answer], total: float) -> list[Answer]:
    """The likeliest of rivals on the same joints that are credible together, though none is alone.

    Hypotheses exclude one another, so their odds against "no effect" add up.
    """
    groups: dict[tuple[int, ...], list[Answer]] = {}
    for answer in best:
        if np.isfinite(odds_of(answer, total)) and answer.candidate.joints:
            groups.setdefault(answer.candidate.joints, []).append(answer)
    odds = {
        joints: float(np.logaddexp.reduce([odds_of(answer, total) for answer in group]))
        for joints, group in groups.items()
    }
    joints = max(odds, key=lambda key: odds[key], default=None)
    if joints is None or odds[joints] < NAMED_ODDS:
        return []
    return [max(groups[joints], key=lambda answer: odds_of(answer, total))]


def compared_with(finding: Selected, best: Sequence[Answer], total: float, blocks: ByBlocks) -> Selected:
    """A finding with its rivals among other hypotheses than those from which it was chosen."""
    return _with_rivals(finding.answer, finding.odds, best, total, _against(total, blocks))


def _against(total: float, blocks: ByBlocks) -> ByBlocks:
    """Log odds of one answer against another, by the scatter of blocks and their priors."""

    def against(answer: Answer, other: Answer) -> float:
        prior = log_prior(answer, total) - log_prior(other, total)
        return better(answer, other, blocks(answer, other), prior)

    return against


def _with_rivals(
    first: Answer, odds: float, best: Sequence[Answer], total: float, against: ByBlocks
) -> Selected:
    """One hypothesis with its rivals."""
    rivals = []
    for answer in best:
        if answer is not first and competing(answer, first) and answer.gain > 0.0:
            # A rival needs no second joint that shows it: one joint alone may show a base tilt.
            least = odds - odds_on_any_joint(answer, total)
            rivals.append((answer, least if least > EXCLUDED_ODDS else max(against(first, answer), least)))
    return Selected(first, odds, tuple(sorted(rivals, key=lambda pair: pair[1])))


def credible(odds: float, finding: Selected) -> bool:
    """Whether a finding with these new log odds is credible, by itself or together with its rivals."""
    return odds > CERTAIN_ODDS or odds + finding.together > NAMED_ODDS


def answers_of(findings: Sequence[Selected]) -> list[Answer]:
    """Answers of findings, in the same order."""
    return [finding.answer for finding in findings]


def keys_of(findings: Sequence[Selected]) -> set[object]:
    """Keys of the hypotheses of findings."""
    return {finding.answer.candidate.key for finding in findings}
