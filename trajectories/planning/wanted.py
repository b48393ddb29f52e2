"""What a user wants to know, in their words, as the base parameters that the words stand for.

"K_r", "gain of joint 2", "friction of elbow", "payload": a parameter's own name, however it is spelled, or
one of a few words for several, of one joint or of all.
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
"""Word -> names of parameters, before the number of the joint."""
INERTIAL = (*WORDS["inertia"], *WORDS["mass"])
OF_JOINT = re.compile(r"^(?P<what>.+?)(?:\s+of)?(?:\s+joint)?\s+(?P<joint>\S+)$")
NUMBER = re.compile(r"^(?P<what>\D+?)\s*(?P<joint>\d+)$")


def wanted_names(
    asked: Sequence[str], names: Sequence[str], joints: Sequence[str], payloads: Sequence[str]
) -> list[str]:
    """Names of base parameters, or beginnings of them, that commas and spaces separate in what is asked.

    Args:
        asked: Words of the user; those with a comma are several.
        names: Base parameters.
        joints: Names of the joints.
        payloads: Names of bodies in the runs.

    Raises:
        UnknownChoice: Words that stand for none of them, with the nearest that do.
    """
    found = list[str]()
    for phrase in (part.strip() for words in asked for part in words.split(",")):
        if phrase:
            found += _of_phrase(phrase, names, joints, payloads)
    return found


def _of_phrase(
    phrase: str, names: Sequence[str], joints: Sequence[str], payloads: Sequence[str]
) -> list[str]:
    if any(name.startswith(phrase) for name in names):
        return [phrase]  # as typed
    plain = {_plain(name): name for name in reversed(names)}
    if _plain(phrase) in plain:
        return [plain[_plain(phrase)]]
    if phrase.lower() in ("payload", "load"):
        own = [f"{name}{load}" for load in payloads if load for name in INERTIAL]
        return _present(own, names) or _unknown(phrase, names)
    what, numbers = _joint_of(phrase.lower(), joints)
    prefixes = WORDS.get(what) or WORDS.get(what.removesuffix("s"), ())
    own = [f"{prefix}{number}" for prefix in prefixes for number in numbers]
    return _present(own, names) or _unknown(phrase, names)


def _joint_of(phrase: str, joints: Sequence[str]) -> tuple[str, list[int]]:
    """What is asked, and of which joints, from 1; all where none is named."""
    lower = [joint.lower() for joint in joints]
    for pattern in (OF_JOINT, NUMBER):
        if (match := pattern.match(phrase)) is None:
            continue
        joint, what = match["joint"], match["what"].removesuffix(" of joint").strip()
        if joint in lower:
            return what, [lower.index(joint) + 1]
        if joint.isdigit() and 1 <= int(joint) <= len(joints):
            return what, [int(joint)]
    return phrase, list(range(1, len(joints) + 1))


def _present(own: Sequence[str], names: Sequence[str]) -> list[str]:
    """Those of the names, or of the same regrouped, that are base parameters."""
    return [name for name in names if name in own or name.removesuffix("R") in own]


def _plain(name: str) -> str:
    """Without underscores, spaces, case and the R of regrouping."""
    return re.sub(r"[\s_]", "", name.removesuffix("R")).lower()


def _unknown(phrase: str, names: Sequence[str]) -> list[str]:
    valid = [*names, *WORDS, "payload"]
    by_plain = {_plain(name): name for name in valid}
    near = get_close_matches(_plain(phrase), by_plain, 1, cutoff=0.5)  # one of two letters
    meant = f"; did you mean '{by_plain[near[0]]}'?" if near else ""
    raise UnknownChoice("base parameter", phrase, valid, meant)
