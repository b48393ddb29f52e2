"""Names of joints and effects in words."""

import re
from collections.abc import Sequence

from ..findings.diagnosis import Diagnosis
from ..findings.finding import Hypothesis


def joint_words(joint: int, joints: Sequence[str]) -> str:
    """Number of a joint, followed by its name unless the name ends in that number."""
    numbered = f"Joint {joint + 1}"
    ending = re.search(r"\d+$", joints[joint])
    return numbered if ending and int(ending[0]) == joint + 1 else f"{numbered} ({joints[joint]})"


def joints_words(joints: Sequence[int], names: Sequence[str]) -> str:
    """Several joints within a sentence, such as "joints 1 (shoulder) and 3"."""
    words = [lower(joint_words(joint, names)) for joint in joints]
    return words[0] if len(words) == 1 else f"joints {joined([word[6:] for word in words])}"


PEOPLE = ("Stribeck", "Coulomb")
"""People after whom effects are named; their names keep the capital letter."""


def effect_words(effect: str) -> str:
    """Name of an effect within a sentence, such as "load-dependent friction"."""
    words = effect.replace("_dependent_", "-dependent ").replace("_", " ")
    person = next((name for name in PEOPLE if words.startswith(name.lower())), "")
    return person + words[len(person) :]


def lower(words: str) -> str:
    """The words as they are written within a sentence."""
    return words if words.startswith(PEOPLE) else words[:1].lower() + words[1:]


def capital(words: str) -> str:
    """The words as they are written at the beginning of a sentence."""
    return words[:1].upper() + words[1:]


def named(effect: str, joints: Sequence[int], names: Sequence[str]) -> str:
    """An effect and where it acts, such as "Load-dependent friction of joint 3"."""
    where = " and ".join(
        f"link {joint + 1}" if effect == "link_inertia" else lower(joint_words(joint, names))
        for joint in joints
    )
    return capital(effect_words(effect)) + (f" of {where}" if where else "")


def finding_names(diagnosis: Diagnosis) -> list[str]:
    """Names of all findings, undecided ones last; equal names are followed by their shapes."""
    return distinct(diagnosis.all_findings, diagnosis.joints)


def distinct(effects: Sequence[Hypothesis], joints: Sequence[str]) -> list[str]:
    """Names of effects; those that occur several times with their shapes, "torque ripple (harmonic 7)"."""
    names = [named(effect.effect, effect.joints, joints) for effect in effects]
    return [
        f"{name} ({effect.which})" if effect.which and names.count(name) > 1 else name
        for name, effect in zip(names, effects, strict=True)
    ]


def joined(words: Sequence[str], last: str = "and") -> str:
    """Several words as an enumeration, such as "a, b and c"."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} {last} {words[-1]}"
