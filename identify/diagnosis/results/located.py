"""Located: the budget of every joint by what its torque depends on, with the probability of each."""

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
"""Share of a joint's misfit from which on a part of it is in the table [-]: no formula is better."""


def dependence_of(candidate: Candidate) -> str:
    """What the torque of a candidate depends on; its effect's name where that is of no family."""
    family = family_of(candidate)
    return FAMILIES[family].dependence if family else candidate.effect


def located(
    budget: Budget, selected: Sequence[Selected], remainders: Sequence[Remainder]
) -> tuple[Located, ...]:
    """Rows joint by joint, the greatest share first; findings of one dependence are one row."""
    known = {(remainder.joint, remainder.depends_on): remainder.probability for remainder in remainders}
    rows: list[Located] = []
    for joint in range(len(budget.before_rms)):
        parts: dict[str, Located] = {}
        for share in budget.shares:
            size, place = float(share.percent[joint]) / 100.0, share.finding
            if place is None:
                part = Located(joint, share.kind, size, known.get((joint, share.kind)), None)
            else:
                found = selected[place]
                depends_on = dependence_of(found.answer.candidate)
                sure = found.dependence_probability if found.proven else None
                part = Located(joint, depends_on, size, sure, place)
            parts[part.depends_on] = _together(parts.get(part.depends_on), part)
        large = [part for part in parts.values() if part.share >= LEAST]
        rows += sorted(large, key=lambda part: -part.share)
    return tuple(rows)


def _together(row: Located | None, part: Located) -> Located:
    """A row with one more part: of the likelier of them are the place and the probability."""
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
