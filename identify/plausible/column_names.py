"""What the names of columns say: which belong together, one a joint, and what they seem to measure."""

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ..recordings.importers.tables.signal_words import COMMANDED, OTHERS, WORDS
from ..recordings.importers.tables.stated_units import stated_unit
from ..recordings.recording import EFFORT
from ..recordings.units import SPELLINGS

ACCELERATIONS = frozenset("ddq qdd qddot acc accel acceleration accelerations beschleunigung".split())
MEASURED = frozenset("actual ist measured present".split())
"""Words for what was measured, where there is more of a quantity."""
STAMPS = frozenset("t time timestamp timestamps zeit zeitstempel temps stamp clock sec secs seconds".split())
UNITS: dict[str, frozenset[str]] = {
    unit: frozenset((unit, *SPELLINGS.get(unit, "").split()))
    for unit in ("deg", "rad", "mm", "rpm", "s", "ms", "us", "ns")
}
"""Units that a proposal weighs -> words for them."""


class Family(NamedTuple):
    """Columns that differ in nothing but the joint.

    Attributes:
        pattern: Their name, with {number} or {joint} for what differs.
        places: Columns, one a joint in the robot's order.
        names: Their names.
        by_name: Whether the names of the robot's joints tell them apart; else their numbers do.
        signal: What the words say they are, "" for nothing known, "other" for nothing that is read.
        unit: Key of `UNITS` that the name states, or "".
    """

    pattern: str
    places: tuple[int, ...]
    names: tuple[str, ...]
    by_name: bool
    signal: str
    unit: str


def words_of(name: str) -> list[str]:
    """Words of a name in small letters: actual_q_0 -> actual, q; JointPos3[deg] -> joint, pos, deg."""
    return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[^\W\d_A-Z]+|°", name)]


def unit_of(name: str) -> str:
    """Unit that a name states; "" for none."""
    words = (
        words_of(stated_unit(name)[1]) or words_of(name)[1:]
    )  # the first is the quantity: `s` is no second
    return next((unit for unit, known in UNITS.items() if known.intersection(words)), "")


def signal_of(name: str) -> str:
    """Signal that a name without its joint means; "" where it says nothing, "other" for what is not read."""
    words = words_of(name)
    if OTHERS.intersection(words):
        return "other"
    found = next((signal for signal, known in WORDS.items() if known.intersection(words)), "")
    if words in (["action"], ["observation", "state"]):  # LeRobot
        return "command" if words == ["action"] else "position"
    if not COMMANDED.intersection(words):
        return found
    if ACCELERATIONS.intersection(words):
        return "other"
    return {"position": "command", "velocity": "command_velocity", "": "command"}.get(found, "other")


def joints_named(names: Sequence[str], joints: Sequence[str], numbered: Sequence[str] = ()) -> list[str]:
    """Those joints whose position and effort have columns by name.

    Where no joint has both, those that have one of them; where none has, all.

    Args:
        names: Names of all columns.
        joints: Names of joints, of which a log may hold a part.
        numbered: Names of the joints that numbers from 1 on stand for, where the log gives them.
    """
    having: dict[str, set[str]] = {}
    for name in names:
        for pattern, place in _readings(name, joints, ()):
            if "{joint}" in pattern:
                having.setdefault(signal_of(pattern.replace("{joint}", " ")), set()).add(joints[place])
    efforts = set().union(*(having.get(signal, set()) for signal in EFFORT))
    positions = having.get("position", set())
    found = positions & efforts or set(numbered) or positions or efforts
    return [joint for joint in joints if joint in found] or list(joints)


def families(names: Sequence[str], joints: Sequence[str], numbered: Sequence[str] = ()) -> list[Family]:
    """Columns that come in one a joint, by the joints' names or else by consecutive numbers.

    Arguments are those of `joints_named`, `joints` all of the robot's.
    """
    found: dict[str, dict[int, int]] = {}
    for place, name in enumerate(names):
        for pattern, key in _readings(name, joints, numbered):
            found.setdefault(pattern, {})[key] = place
    whole: list[Family] = []
    taken: set[int] = set()
    # Patterns with the joints' own names come first: wrist_1_joint has a number that is not its place.
    for pattern, by_key in sorted(found.items(), key=lambda item: ("{joint}" not in item[0], min(item[1]))):
        keys = sorted(by_key)
        n, first = len(joints), len(keys) % len(joints)
        bare = pattern.replace("{joint}", " ").replace("{number}", " ")
        if keys[-1] - keys[0] != len(keys) - 1 or keys[0] > 1 or len(keys) < n or first > 1:
            continue
        if len(keys) > n and (n == 1 or signal_of(bare)):
            continue  # more than the joints of this robot
        own = "{joint}" in pattern or set(joints) <= set(numbered)
        # Columns of one name for all, such as 1 to 13 of six joints: time, and two signals.
        for start in range(first, len(keys), n):
            places = tuple(by_key[key] for key in keys[start : start + n])
            if taken.isdisjoint(places):
                taken.update(places)
                named = tuple(names[place] for place in places)
                title = pattern if len(keys) == n else f"{named[0]} to {named[-1]}"
                whole.append(Family(title, places, named, own, signal_of(bare), unit_of(bare)))
    return sorted(whole, key=lambda family: min(family.places))


def _readings(name: str, joints: Sequence[str], numbered: Sequence[str]) -> Iterator[tuple[str, int]]:
    """Ways to read a name as a pattern and a joint's place in it."""
    lower = name.lower()
    of_joint = [
        joint for joint in joints if re.search(rf"(?<![^\W_]){re.escape(joint.lower())}(?![^\W_])", lower)
    ]
    if of_joint:
        joint = max(of_joint, key=len)
        begin = lower.index(joint.lower())
        yield name[:begin] + "{joint}" + name[begin + len(joint) :], list(joints).index(joint)
        return
    for match in re.finditer(r"\d+", name):
        pattern, number = name[: match.start()] + "{number}" + name[match.end() :], int(match[0])
        if not set(joints) <= set(numbered):
            yield pattern, number
        elif 0 < number <= len(numbered) and numbered[number - 1] in joints:
            yield pattern, list(joints).index(numbered[number - 1])
    if len(joints) == 1:
        yield name, 0
