"""Diagnosis of a set once more, with what was named in its model: nothing should be left to name."""

from typing import Any

from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.findings.diagnosis import Diagnosis
from exidyn.identification.diagnosis.findings.finding import Finding
from exidyn.identification.diagnosis.improved.improved import found_model, left_out

from .sets import Case, Runs
from .sizes import joints_words, size


def again(case: Case, runs: Runs, found: Diagnosis) -> dict[str, Any]:
    """What is named with found.toml for a model, and which of that no model holds.

    As in found.toml, what is undecided is held too.
    """
    model = found_model(found)
    if model is None or not (found.findings or found.undecided):
        return {"held": 0, "lost": [], "named": [], "repeated": []}
    lost = [found.all_findings[place].effect for place in left_out(found)]
    second = diagnose(model, runs, case.title, case.filtering)
    return {
        "held": len(found.findings) + len(found.undecided) - len(lost),
        "lost": lost,
        "named": [words(one) for one in second.findings],
        "repeated": [words(one) for one in second.findings if repeats(one, found, lost)],
    }


def repeats(one: Finding, found: Diagnosis, lost: list[str]) -> bool:
    """Whether it was named before, and no model could hold it."""
    before = [(other.effect, other.joints) for other in found.findings]
    return one.effect in lost and (one.effect, one.joints) in before


def words(one: Finding) -> str:
    """A finding in one line."""
    return f"{one.effect} {joints_words(one.joints)}, {one.probability:.3f}: {size(one)}"
