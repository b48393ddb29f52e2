"""Located: the budget of every joint by what its torque depends on, with the probability of each."""

from collections.abc import Sequence

from ..candidates import family_of
from ..findings.family import FAMILIES
from ..findings.finding import Budget, Remainder
from ..findings.located import Hinted, Located
from ..questions.candidate import Candidate
from ..search.held_out import Hint
from ..search.selected import Selected
from .budget import relative_change

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
    sure = {(one.joint, one.depends_on): one.probability for one in remainders}
    rows: list[Located] = []
    for joint in range(len(budget.before)):
        parts: dict[str, Located] = {}
        for share in budget.shares:
            size, place = float(share.shares[joint]), share.finding
            if place is None:
                part = Located(joint, share.kind, size, sure.get((joint, share.kind)), None)
            else:
                found = selected[place]
                depends_on = dependence_of(found.answer.candidate)
                part = Located(joint, depends_on, size, found.dependence_probability, place)
            parts[part.depends_on] = _together(parts.get(part.depends_on), part)
        rows += sorted((one for one in parts.values() if one.share >= LEAST), key=lambda one: -one.share)
    return tuple(rows)


def _together(one: Located | None, other: Located) -> Located:
    """Both as one row: the place and the probability of the likelier one."""
    if one is None:
        return other
    first = max(one, other, key=lambda part: part.probability or 0.0)
    return Located(one.joint, one.depends_on, one.share + other.share, first.probability, first.finding)


def hinted(hints: Sequence[Hint]) -> tuple[Hinted, ...]:
    """Hints with their numbers."""
    return tuple(_hinted(one) for one in hints)


def _hinted(hint: Hint) -> Hinted:
    answer = hint.answer
    change, std = relative_change(answer, ~answer.fitted, hint.joint)
    return Hinted(
        answer.candidate.effect,
        hint.joint,
        dependence_of(answer.candidate),
        float(answer.gain),
        float(answer.held_out),
        change,
        std,
    )
