"""Which mistake a log has, if any: the whole table against none, and against what is not listed."""

from collections.abc import Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np

from .changes import Change
from .effort_mistakes import of_gravity
from .evidence import Evidence, Reading
from .log_facts import LogFacts, Mistake
from .mistakes import MOUNTING, TABLE
from .mounting import found_gravity

Key = TypeVar("Key", bound=Hashable)

MOST = 200
"""Maximum number of samples that are weighed: a hundred hypotheses are fitted to them."""
ROOM = 0.3
"""Log-likelihood that bodies of any mass must leave to gain, for another reading of the positions to be worth
a look: right logs of simulated arms leave hundredths."""
WRONG_MASSES = -1.0
"""Log-likelihood of a joint by the described masses over any masses, from which on something contradicts
them."""
RIGHT_MASSES = 7.0
"""The same, at most, of the masses of a right description."""
BESIDE = 0.3
"""By how much that may grow on a joint which a mistake of one or two other joints does not concern."""
FAR_BEHIND = 7.0
"""Log odds behind the leader from which on a hypothesis is not looked at any closer: a thousandth."""
HOPELESS = 3.0
"""The same of the most that a hypothesis could reach, from which on it is not computed: one in twenty."""
DISAGREES = -1.0
"""Log odds of a mistake over none in a part of the data, from which on that part speaks against it."""
SURE = 0.95
"""Largest probability of a mistake that some part of the data, or bodies of any mass, do not support."""
SUPPORTS = 3.0
"""Log-likelihood by which bodies of any mass must support a mistake: twenty to one. The described masses
alone may be numbers that nobody measured."""


def posterior(log_odds: Mapping[Key, float]) -> dict[Key, float]:
    """Probability of each hypothesis, from log of prior times likelihood; the likeliest first."""
    values = np.array(list(log_odds.values()))
    weights = np.exp(values - values.max())
    shares = dict(zip(log_odds, (weights / weights.sum()).tolist(), strict=True))
    return dict(sorted(shares.items(), key=lambda item: -item[1]))


class Case(NamedTuple):
    """One case of a mistake, and how likely it is.

    Attributes:
        mistake: Its kind.
        what: What is wrong, in a clause.
        change: What makes the log right.
        joints: Joints that show it.
        odds: Log of prior times likelihood.
        trust: Probability that these joints are explained, and not by chance less badly.
        by_bodies: Log-likelihood by bodies of any mass.
    """

    mistake: Mistake
    what: str
    change: Change
    joints: tuple[int, ...]
    odds: float
    trust: float = 0.0
    by_bodies: float = 0.0

    def judged(self, evidence: Evidence) -> "Case":
        """With evidence: one or two joints have to be explained each, of all joints most."""
        trust = evidence.trust[list(self.joints)]
        middle = trust.min() if len(trust) < 3 else np.median(trust)
        by_bodies = float(evidence.by_bodies.sum())
        return self._replace(
            odds=self.odds + evidence.log_likelihood, trust=float(middle), by_bodies=by_bodies
        )


@dataclass(frozen=True)
class Weighed:
    """A log against the table of mistakes.

    Attributes:
        plain: Evidence of the log as it is read.
        odds: Log of prior times likelihood of that.
        cases: Mistakes, the likeliest first.
    """

    plain: Evidence
    odds: float
    cases: tuple[Case, ...]

    def share(self, case: Case) -> float:
        """Probability of a case, if the table had all mistakes."""
        return float(np.exp(case.odds - self._all))

    @property
    def unexplained(self) -> float:
        """Share of the joints that nothing listed explains."""
        best = self.cases[0].trust if self.cases and self.cases[0].odds > self.odds else 0.0
        return min(float(np.mean(1.0 - self.plain.trust)), 1.0 - best)

    @property
    def _all(self) -> float:
        return float(np.logaddexp.reduce([self.odds, *(case.odds for case in self.cases)]))

    @property
    def probability(self) -> float:
        """Probability of the likeliest mistake, whatever its size, if it explains the joints concerned."""
        if not self.cases:
            return 0.0
        best = self.cases[0]
        kind = best.mistake, best.joints
        alike = [case for case in self.cases if (case.mistake, case.joints) == kind]
        return self.sure(best, sum(map(self.share, alike)))

    def sure(self, case: Case, share: float) -> float:
        """Probability of a case of a share, if it explains its joints; of a size by masses alone `SURE`."""
        supported = case.mistake.of_sign or case.by_bodies - self.plain.by_bodies.sum() > SUPPORTS
        return case.trust * share if supported else min(case.trust * share, SURE)


def weigh(reading: Reading, facts: LogFacts, kinds: Collection[str] | None = None) -> Weighed:
    """All mistakes that a log may have, or some kinds of them, and none."""
    plain = reading.evidence()
    table = [mistake for mistake in TABLE if kinds is None or mistake.name in kinds]
    odds = float(np.log1p(-sum(mistake.prior for mistake in table))) + plain.log_likelihood
    every = [case for mistake in table for case in _cases(mistake, facts)]
    cases = _of_efforts(reading, plain, odds, [case for case in every if case.change.of_efforts])
    always = [case for case in every if case.change.gravity is not None or case.mistake.always]
    cases += _of_positions(reading, plain, odds, always)
    if suspicious(plain):
        cases += _of_positions(
            reading,
            plain,
            odds,
            [case for case in every if case.change.of_motion and not case.mistake.always],
        )
        # Another direction takes a search: only where much is unexplained, or the masses are contradicted.
        contradicted = plain.drawn and plain.kind > 0
        if contradicted or plain.trust[facts.moving].min(initial=1.0) < 0.5:
            cases += _of_positions(reading, plain, odds, _mountings(reading, facts))
    return Weighed(plain, odds, tuple(sorted(cases, key=lambda case: -case.odds)))


def suspicious(plain: Evidence) -> bool:
    """Whether another reading of the positions, or of gravity, could explain notably more."""
    return bool(plain.room.sum() > ROOM or np.any(plain.by_masses[0] < WRONG_MASSES))


def supported(parts: Sequence[Reading], change: Change) -> bool:
    """Whether no part of the data speaks against a mistake."""
    for part in parts:
        over = change.read(part).evidence(change.factor).log_likelihood - part.evidence().log_likelihood
        if over < DISAGREES:
            return False
    return True


def _cases(mistake: Mistake, facts: LogFacts) -> list[Case]:
    cases = list(mistake.cases(facts))
    prior = float(np.log(mistake.prior / max(len(cases), 1)))
    return [
        Case(mistake, what, change, joints, prior + facts.usual(change)) for what, change, joints in cases
    ]


def _mountings(reading: Reading, facts: LogFacts) -> list[Case]:
    gravity = found_gravity(reading) if len(facts.moving) > 1 else None
    cases = [] if gravity is None else of_gravity(facts, gravity)
    return [Case(MOUNTING, *case, float(np.log(MOUNTING.prior))) for case in cases]


def _of_efforts(reading: Reading, plain: Evidence, odds: float, cases: Iterable[Case]) -> list[Case]:
    """Cases of signs and sizes of efforts, judged: what the masses say of them costs nothing."""
    judged = []
    for case in cases:
        factor = case.change.factor
        assert factor is not None
        best = case.judged(plain.with_room(reading.by_masses(factor)))
        judged.append(case.judged(reading.evidence(factor)) if best.odds > odds - FAR_BEHIND else best)
    return judged


def _at_best(plain: Evidence, case: Case) -> np.ndarray:
    """The most that masses may add to each joint without a mistake, shape (k, n)."""
    most = np.where(plain.by_masses.max(axis=0) < 0.0, RIGHT_MASSES, plain.by_masses.max(axis=0) + BESIDE)
    concerned = list(case.joints)
    most[concerned] = np.maximum(most[concerned], RIGHT_MASSES)
    return np.broadcast_to(most, plain.by_masses.shape)


def _read(reading: Reading, change: Change, motions: dict[bytes, Reading]) -> Reading:
    if change.effort is None or change.scale is not None:
        return change.read(reading)
    order = np.arange(len(change.effort)) if change.position is None else change.position
    moved = motions.setdefault(order.tobytes(), change.motion.read(reading))
    return moved.with_efforts(change.effort)


def _of_positions(reading: Reading, plain: Evidence, odds: float, cases: Iterable[Case]) -> list[Case]:
    """Cases of other positions, orders and gravity, judged: by bodies first, which is quick."""
    judged = []
    motions: dict[bytes, Reading] = {}  # one motion for several orders of efforts
    for case in cases:
        masses = _at_best(plain, case)
        best = case.judged(plain.with_room(masses))
        if best.odds < odds - HOPELESS:
            judged.append(best)
            continue
        other = _read(reading, case.change, motions)
        best = case.judged(other.at_best(masses, case.change.factor))
        if best.odds > odds - FAR_BEHIND:
            best = case.judged(other.evidence(case.change.factor))
        judged.append(best)
    return judged
