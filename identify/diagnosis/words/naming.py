"""Naming: joints and effects in words."""

import re
from collections.abc import Sequence

from ..findings.diagnosis import Diagnosis


def joint_words(joint: int, joints: Sequence[str]) -> str:
    """Its number, with its name behind where that does not end in the number."""
    numbered = f"Joint {joint + 1}"
    ending = re.search(r"\d+$", joints[joint])
    return numbered if ending and int(ending[0]) == joint + 1 else f"{numbered} ({joints[joint]})"


PEOPLE = ("Stribeck", "Coulomb")
"""Whose names effects bear."""


def effect_words(effect: str) -> str:
    """An effect's name in words, inside a sentence: load-dependent friction."""
    words = effect.replace("_dependent_", "-dependent ").replace("_", " ")
    person = next((name for name in PEOPLE if words.startswith(name.lower())), "")
    return person + words[len(person) :]


def lower(words: str) -> str:
    """The words inside a sentence."""
    return words if words.startswith(PEOPLE) else words[:1].lower() + words[1:]


def capital(words: str) -> str:
    """The words at the beginning of a sentence."""
    return words[:1].upper() + words[1:]


def named(effect: str, joints: Sequence[int], names: Sequence[str]) -> str:
    """An effect and where it acts: Load-dependent friction of joint 3."""
    where = " and ".join(
        f"link {joint + 1}" if effect == "link_inertia" else lower(joint_words(joint, names))
        for joint in joints
    )
    return capital(effect_words(effect)) + (f" of {where}" if where else "")


def finding_names(diagnosis: Diagnosis) -> list[str]:
    """Effects and where they act, undecided ones last; each with its shape where two are the same."""
    findings = diagnosis.all_findings
    names = [named(finding.effect, finding.joints, diagnosis.joints) for finding in findings]
    return distinct(names, [finding.which for finding in findings])


def change_names(diagnosis: Diagnosis) -> list[str]:
    """The candidates that alone change something, each with its shape where two are the same."""
    names = [named(change.effect, change.joints, diagnosis.joints) for change in diagnosis.changes]
    return distinct(names, [change.which for change in diagnosis.changes])


def joined(words: Sequence[str], last: str = "and") -> str:
    """One sentence part out of several: a, b and c."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} {last} {words[-1]}"


def distinct(names: Sequence[str], which: Sequence[str]) -> list[str]:
    """Names, with what sets them apart behind those that stand several times: torque ripple (harmonic 7)."""
    return [
        f"{name} ({more})" if more and names.count(name) > 1 else name
        for name, more in zip(names, which, strict=True)
    ]
