"""Translation of a user's words to the base parameters that they mean.

Examples are "K_r", "gain of joint 2", "friction of elbow", "payload": the name of a parameter in any
spelling, or a word for a group of parameters of one joint or of all joints.
"""

import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches

from ..errors import UnknownChoice

WORDS: Mapping[str, tuple[str, ...]] = {
    "gain": ("gain",),
    "friction": ("Fv", "Fc"),
    "offset": ("Off",),
    "rotor inertia": ("Ia",),
    "mass": ("M", "MX", "MY", "MZ"),
    "inertia": ("XX", "XY", "XZ", "YY", "YZ", "ZZ"),
}
"""Names of parameters, without the number of the joint, by word."""
INERTIAL = (*WORDS["inertia"], *WORDS["mass"])
OF_JOINT = re.compile(r"^(?P<what>.+?)(?:\s+of)?(?:\s+joint)?\s+(?P<joint>\S+)$")
NUMBER = re.compile(r"^(?P<what>\D+?)\s*(?P<joint>\d+)$")


def wanted_names(
    phrases: Sequence[str], names: Sequence[str], joints: Sequence[str], payloads: Sequence[str]
) -> list[str]:
    """Names of base parameters, or beginnings of names, that phrases mean.

    Raises:
        UnknownChoice: A phrase means no base parameter; the message suggests the most similar one.
    """
    wanted = list[str]()
    for phrase in (part.strip() for words in phrases for part in words.split(",")):
        if phrase:
            wanted += _names_of_phrase(phrase, names, joints, payloads)
    return wanted


def _names_of_phrase(
    phrase: str, names: Sequence[str], joints: Sequence[str], payloads: Sequence[str]
) -> list[str]:
    if any(name.startswith(phrase) for name in names):
        return [phrase]  # as typed
    plain = {_plain(name): name for name in reversed(names)}
    if _plain(phrase) in plain:
        return [plain[_plain(phrase)]]
    if phrase.lower() in ("payload", "load"):
        candidates = [f"{name}{load}" for load in payloads if load for name in INERTIAL]
        return _present(candidates, names) or _unknown(phrase, names)
    quantity, numbers = _joint_of(phrase.lower(), joints)
    prefixes = WORDS.get(quantity) or WORDS.get(quantity.removesuffix("s"), ())
    candidates = [f"{prefix}{number}" for prefix in prefixes for number in numbers]
    return _present(candidates, names) or _unknown(phrase, names)


def _joint_of(phrase: str, joints: Sequence[str]) -> tuple[str, list[int]]:
    """Quantity and numbers of the joints, from 1, in a phrase; all joints if none is named."""
    lower = [joint.lower() for joint in joints]
    for pattern in (OF_JOINT, NUMBER):
        if (match := pattern.match(phrase)) is None:
            continue
        joint, quantity = match["joint"], match["what"].removesuffix(" of joint").strip()
        if joint in lower:
            return quantity, [lower.index(joint) + 1]
        if joint.isdigit() and 1 <= int(joint) <= len(joints):
            return quantity, [int(joint)]
    return phrase, list(range(1, len(joints) + 1))


def _present(candidates: Sequence[str], names: Sequence[str]) -> list[str]:
    """The base parameters that are among the candidates, possibly regrouped."""
    return [name for name in names if name in candidates or name.removesuffix("R") in candidates]


def _plain(name: str) -> str:
    """A name without underscores, spaces, case and the R of regrouping."""
    return re.sub(r"[\s_]", "", name.removesuffix("R")).lower()


def _unknown(phrase: str, names: Sequence[str]) -> list[str]:
    valid = [*names, *WORDS, "payload"]
    by_plain = {_plain(name): name for name in valid}
    matches = get_close_matches(_plain(phrase), by_plain, 1, cutoff=0.5)  # one of two letters agrees
    meant = f"; did you mean '{by_plain[matches[0]]}'?" if matches else ""
    raise UnknownChoice("base parameter", phrase, valid, meant)
