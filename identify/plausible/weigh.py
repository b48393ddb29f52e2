"""Probability of each mistake in a log, compared with no mistake and with unlisted causes."""

from collections.abc import Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np

from .effort_mistakes import of_gravity
from .evidence import Evidence, Reading
from .mistake import Change, LogFacts, Mistake
from .mistakes import MOUNTING, TABLE
from .mounting import search_gravity

Key = TypeVar("Key", bound=Hashable)

MOST = 200
"""Maximum number of samples: a hundred hypotheses are fitted to them."""
ROOM = 0.3
"""Possible gain in log-likelihood with bodies of any mass, beyond which other readings of the positions are
tested; for correct logs of simulated arms it is a few hundredths."""
WRONG_MASSES = -1.0
"""Log-likelihood of a joint for described relative to any masses, below which the masses are contradicted."""
RIGHT_MASSES = 7.0
"""Largest log-likelihood of a joint for described relative to any masses in a correct log."""
BESIDE = 0.3
"""Largest increase of that log-likelihood on a joint that the mistake does not concern."""
FAR_BEHIND = 7.0
"""Log odds behind no mistake at which a hypothesis is not evaluated further: one in a thousand."""
HOPELESS = 3.0
"""Log odds of an upper bound behind no mistake at which a hypothesis is not computed: one in twenty."""
DISAGREES = -1.0
"""Log odds of a mistake over none in a part of the data, below which that part contradicts it."""
SURE = 0.95
"""Largest probability of a mistake that a part of the data, or bodies of any mass, do not support."""
SUPPORTS = 3.0
"""Gain in log-likelihood with bodies of any mass that supports a mistake, twenty to one. The described masses
alone may be arbitrary."""


def posterior(log_odds: Mapping[Key, float]) -> dict[Key, float]:
    """Probability of each hypothesis from log of prior times likelihood, the most probable first."""
    values = np.array(list(log_odds.values()))
    weights = np.exp(values - values.max())
    shares = dict(zip(log_odds, (weights / weights.sum()).tolist(), strict=True))
    return dict(sorted(shares.items(), key=lambda item: -item[1]))


class Case(NamedTuple):
    """One case of a mistake, with its likelihood."""

    mistake: Mistake  # kind of mistake
    clause: str  # clause on what is wrong
    change: Change  # change that corrects the log
    joints: tuple[int, ...]  # indices of the joints that show it
    odds: float  # log of prior times likelihood
    trust: float = 0.0  # probability that the case, not an unlisted cause, explains these joints
    by_bodies: float = 0.0  # log-likelihood with bodies of any mass

    def judged(self, evidence: Evidence) -> "Case":
        """Case with evidence; it must explain each of one or two joints, or most of several joints."""
        trust = evidence.trust[list(self.joints)]
        middle = trust.min() if len(trust) < 3 else np.median(trust)
        by_bodies = float(evidence.by_bodies.sum())
        return self._replace(
            odds=self.odds + evidence.log_likelihood, trust=float(middle), by_bodies=by_bodies
        )


@dataclass(frozen=True)
class Weighed:
    """Result of testing a log for all mistakes in the table."""

    plain: Evidence  # evidence of the log without a correction
    odds: float  # log of prior times likelihood of no mistake
    cases: tuple[Case, ...]  # cases of mistakes, the most probable first

    def share(self, case: Case) -> float:
        """Probability of a case, if the table were complete."""
        return float(np.exp(case.odds - self._all))

    @property
    def unexplained(self) -> float:
        """Share of the joints that no hypothesis in the table explains."""
        best = self.cases[0].trust if self.cases and self.cases[0].odds > self.odds else 0.0
        return min(float(np.mean(1.0 - self.plain.trust)), 1.0 - best)

    @property
    def _all(self) -> float:
        return float(np.logaddexp.reduce([self.odds, *(case.odds for case in self.cases)]))

    @property
    def probability(self) -> float:
        """Probability of the most probable mistake, of any size, that it explains the joints concerned."""
        if not self.cases:
            return 0.0
        best = self.cases[0]
        kind = best.mistake, best.joints
        alike = [case for case in self.cases if (case.mistake, case.joints) == kind]
        return self.sure(best, sum(map(self.share, alike)))

    def sure(self, case: Case, share: float) -> float:
        """Probability that a case of this share explains its joints, up to `SURE` if only masses show it."""
        supported = case.mistake.of_sign or case.by_bodies - self.plain.by_bodies.sum() > SUPPORTS
        return case.trust * share if supported else min(case.trust * share, SURE)


def weigh(reading: Reading, facts: LogFacts, kinds: Collection[str] | None = None) -> Weighed:
    """Test a log for all mistakes in the table, or for some kinds, and for no mistake."""
    plain = reading.evidence()
    table = [mistake for mistake in TABLE if kinds is None or mistake.name in kinds]
    odds = float(np.log1p(-sum(mistake.prior for mistake in table))) + plain.log_likelihood
    all_cases = [case for mistake in table for case in _cases(mistake, facts)]
    cases = _of_efforts(reading, plain, odds, [case for case in all_cases if case.change.of_efforts])
    always = [case for case in all_cases if case.change.gravity is not None or case.mistake.always]
    cases += _of_positions(reading, plain, odds, always)
    if suspicious(plain):
        cases += _of_positions(
            reading,
            plain,
            odds,
            [case for case in all_cases if case.change.of_motion and not case.mistake.always],
        )
        # Another mounting requires a search: only if much is unexplained, or the masses are contradicted.
        contradicted = plain.drawn and plain.kind > 0
        if contradicted or plain.trust[facts.moving].min(initial=1.0) < 0.5:
            cases += _of_positions(reading, plain, odds, _mountings(reading, facts))
    return Weighed(plain, odds, tuple(sorted(cases, key=lambda case: -case.odds)))


def suspicious(plain: Evidence) -> bool:
    """Whether another reading of positions or gravity could explain significantly more."""
    return bool(plain.room.sum() > ROOM or np.any(plain.by_masses[0] < WRONG_MASSES))


def supported(parts: Sequence[Reading], change: Change) -> bool:
    """Whether no part of the data contradicts a mistake."""
    for part in parts:
        over = change.read(part).evidence(change.factor).log_likelihood - part.evidence().log_likelihood
        if over < DISAGREES:
            return False
    return True


def _cases(mistake: Mistake, facts: LogFacts) -> list[Case]:
    cases = list(mistake.cases(facts))
    prior = float(np.log(mistake.prior / max(len(cases), 1)))
    return [
        Case(mistake, clause, change, joints, prior + facts.usual(change)) for clause, change, joints in cases
    ]


def _mountings(reading: Reading, facts: LogFacts) -> list[Case]:
    gravity = search_gravity(reading) if len(facts.moving) > 1 else None
    cases = [] if gravity is None else of_gravity(facts, gravity)
    return [Case(MOUNTING, *case, float(np.log(MOUNTING.prior))) for case in cases]


def _of_efforts(reading: Reading, plain: Evidence, odds: float, cases: Iterable[Case]) -> list[Case]:
    """Cases of signs and sizes of efforts with evidence; that of the masses is quick and comes first."""
    judged = []
    for case in cases:
        factor = case.change.factor
        assert factor is not None
        best = case.judged(plain.with_room(reading.by_masses(factor)))
        judged.append(case.judged(reading.evidence(factor)) if best.odds > odds - FAR_BEHIND else best)
    return judged


def _at_best(plain: Evidence, case: Case) -> np.ndarray:
    """Upper bound of the log-likelihood that masses add to each joint, shape (k, n)."""
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
    """Cases of positions, orders and gravity with evidence; that of the bodies is quick and comes first."""
    judged = []
    motions: dict[bytes, Reading] = {}  # several orders of efforts share one motion
    for case in cases:
        masses = _at_best(plain, case)
        best = case.judged(plain.with_room(masses))
        if best.odds < odds - HOPELESS:
            judged.append(best)
            continue
        other = _read(reading, case.change, motions)
        best = case.judged(other.evidence(case.change.factor, masses))
        if best.odds > odds - FAR_BEHIND:
            best = case.judged(other.evidence(case.change.factor))
        judged.append(best)
    return judged
