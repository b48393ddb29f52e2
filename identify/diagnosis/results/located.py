"""Located: the budget of every joint by dependence, with the probability of each dependence."""

from collections.abc import Sequence
from dataclasses import replace

from ..candidates import family_of
from ..findings.diagnosis import Budget, Remainder
from ..findings.family import FAMILIES
from ..findings.located import Hinted, Located
from ..questions.candidate import Candidate
from ..questions.comparison import relative_change
from ..search.held_out import Hint
from ..search.selected import Selected

LEAST = 0.01
"""Smallest share of a joint's squared residual that the table lists [-]: no formula is more exact."""


def dependence_of(candidate: Candidate) -> str:
    """Dependence of the torque of a candidate; the name of its effect without a family."""
    family = family_of(candidate)
    return FAMILIES[family].dependence if family else candidate.effect


def located(
    budget: Budget, selected: Sequence[Selected], remainders: Sequence[Remainder]
) -> tuple[Located, ...]:
    """Rows by joint, the largest share first; findings with the same dependence share a row."""
    known = {(remainder.joint, remainder.depends_on): remainder.probability for remainder in remainders}
    rows: list[Located] = []
    for joint in range(len(budget.before_rms)):
        parts: dict[str, Located] = {}
        for share in budget.shares:
            size, place = float(share.percent[joint]) / 100.0, share.finding
            if place is None:
                part = Located(joint, share.kind, size, known.get((joint, share.kind)), None)
            else:
                finding = selected[place]
                depends_on = dependence_of(finding.answer.candidate)
                probability = finding.dependence_probability if finding.proven else None
                part = Located(joint, depends_on, size, probability, place)
            parts[part.depends_on] = _together(parts.get(part.depends_on), part)
        large = [part for part in parts.values() if part.share >= LEAST]
        rows += sorted(large, key=lambda part: -part.share)
    return tuple(rows)


def _together(row: Located | None, part: Located) -> Located:
    """The row with one more part; finding and probability are those of the likelier part."""
    if row is None:
        return part
    likelier = max(row, part, key=lambda either: either.probability or 0.0)
    return replace(likelier, share=row.share + part.share)


def hinted(hints: Sequence[Hint]) -> tuple[Hinted, ...]:
    """Hints with their numbers."""
    return tuple(map(_hinted, hints))


def _hinted(hint: Hint) -> Hinted:
    answer = hint.answer
    held = ~answer.fitted, hint.joint
    change, std = relative_change(answer.predicted[held], answer.errors[held])
    return Hinted(
        answer.candidate.effect,
        hint.joint,
        dependence_of(answer.candidate),
        float(answer.gain),
        float(answer.held_out),
        change,
        std,
    )
