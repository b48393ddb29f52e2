"""Interpretation of column names: columns that belong together, one per joint, and their probable signal."""

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ..recording import EFFORT
from ..units import SPELLINGS
from .name_index import COMMANDED, OTHERS, TIMES, WORDS, stated_unit

ACCELERATIONS = frozenset("ddq qdd qddot acc accel acceleration accelerations beschleunigung".split())
MEASURED = frozenset("actual ist measured present".split())
"""Words for the measured columns among several of a quantity."""
STAMPS = frozenset(TIMES)
"""Words for time."""
UNITS: dict[str, frozenset[str]] = {
    unit: frozenset((unit, *SPELLINGS.get(unit, "").split()))
    for unit in ("deg", "rad", "mm", "rpm", "s", "ms", "us", "ns")
}
"""Unit that a proposal considers -> words for it."""


class Family(NamedTuple):
    """Columns whose names differ only in the joint."""

    pattern: str  # common name, with {number} or {joint} as placeholder
    places: tuple[int, ...]  # indices of the columns, one per joint in the robot's order
    names: tuple[str, ...]  # names of the columns
    by_name: bool  # whether joint names distinguish the columns; otherwise numbers do
    signal: str  # signal that the words mean; "" if unknown, "other" for a signal that is not read
    unit: str  # key of `UNITS` that the name states, or ""; several if those of the joints differ


def words_of(name: str) -> list[str]:
    """Words of a name in lower case: actual_q_0 -> actual, q; JointPos3[deg] -> joint, pos, deg."""
    return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[^\W\d_A-Z]+|°", name)]


def unit_of(name: str) -> str:
    """Unit that a name states, or ""."""
    # The first word is the quantity: `s` does not mean seconds there.
    words = words_of(stated_unit(name)[1]) or words_of(name)[1:]
    return next((unit for unit, known in UNITS.items() if known.intersection(words)), "")


def signal_of(name: str) -> str:
    """Signal that a name without its joint means; "" if unknown, "other" for a signal that is not read."""
    words = words_of(name)
    if OTHERS.intersection(words):
        return "other"
    signal = next((signal for signal, known in WORDS.items() if known.intersection(words)), "")
    if words in (["action"], ["observation", "state"]):  # LeRobot
        return "command" if words == ["action"] else "position"
    if not COMMANDED.intersection(words):
        return signal
    if ACCELERATIONS.intersection(words):
        return "other"
    return {"position": "command", "velocity": "command_velocity", "": "command"}.get(signal, "other")


def joints_named(names: Sequence[str], joints: Sequence[str], numbered: Sequence[str] = ()) -> list[str]:
    """Joints that column names show to be in the log, which may lack some of the robot's.

    These are the joints with named columns of position and effort; if there are none, the joints with one of
    the two; else all. `numbered` are the joints that the numbers from 1 stand for, if the log states them.
    """
    having: dict[str, set[str]] = {}
    for name in names if not _own_names(names, joints) else ():
        for pattern, place in _readings(name, joints, ()):
            if "{joint}" in pattern:
                having.setdefault(signal_of(pattern.replace("{joint}", " ")), set()).add(joints[place])
    efforts = set().union(*(having.get(signal, set()) for signal in EFFORT))
    positions = having.get("position", set())
    present = positions & efforts or set(numbered) or positions or efforts
    return [joint for joint in joints if joint in present] or list(joints)


def families(names: Sequence[str], joints: Sequence[str], numbered: Sequence[str] = ()) -> list[Family]:
    """Groups of columns with one column per joint, by joint names or else by consecutive numbers.

    Arguments are those of `joints_named`; `joints` are all joints of the robot. A log with names of its own
    for as many joints has them in an unknown order, as if they were numbers.
    """
    own = _own_names(names, joints)
    joints = own or joints
    groups = _families(names, names, joints, numbered)
    used = {place for family in groups for place in family.places}
    # Units in names differ if some joints turn and others slide.
    bare = ["" if place in used else stated_unit(name)[0] for place, name in enumerate(names)]
    mixed = [
        family
        for family in _families(names, bare, joints, numbered)
        if len({stated_unit(name)[1] for name in family.names} - {""}) > 1
    ]
    found = sorted(groups + mixed, key=lambda family: min(family.places))
    return [family._replace(by_name=False) for family in found] if own else found


def _own_names(names: Sequence[str], joints: Sequence[str]) -> list[str]:
    """Names that a log has for the joints, of positions and other signals; empty if they are the robot's."""
    groups: dict[str, list[str]] = {}
    for name in names:
        for match in re.finditer(r"[_./ ]", name):
            groups.setdefault(name[: match.end()], []).append(name[match.end() :])
    sets = {begin: tuple(ends) for begin, ends in groups.items() if len(ends) == len(joints) > 1}
    positions = [ends for begin, ends in sets.items() if signal_of(begin) == "position"]
    each = [*sets.values()]
    shared = [ends for ends in positions if each.count(ends) > 1 and not any(map(signal_of, ends))]
    named = {name for name in names for pattern, _ in _readings(name, joints, ()) if "{joint}" in pattern}
    others = [ends for ends in shared if not all(name in named for name in names if name.endswith(ends))]
    return list(others[0]) if others else []


def _families(
    names: Sequence[str], shown: Sequence[str], joints: Sequence[str], numbered: Sequence[str]
) -> list[Family]:
    """Groups of columns by their shown names; a column whose name is "" is left out."""
    groups: dict[str, dict[int, int]] = {}
    for place, name in enumerate(shown):
        for pattern, key in _readings(name, joints, numbered) if name else ():
            groups.setdefault(pattern, {})[key] = place
    complete: list[Family] = []
    used: set[int] = set()
    # Patterns with joint names come first: the number in wrist_1_joint is not a joint index.
    for pattern, by_key in sorted(groups.items(), key=lambda item: ("{joint}" not in item[0], min(item[1]))):
        keys = sorted(by_key)
        n, first = len(joints), len(keys) % len(joints)
        bare = pattern.replace("{joint}", " ").replace("{number}", " ")
        if keys[-1] - keys[0] != len(keys) - 1 or keys[0] > 1 or len(keys) < n or first > 1:
            continue
        if len(keys) > n and (n == 1 or signal_of(bare)):
            continue  # more columns than this robot has joints
        by_name = "{joint}" in pattern or set(joints) <= set(numbered)
        # One name may cover several signals, such as 1 to 13 for six joints: time, and two signals.
        for start in range(first, len(keys), n):
            places = tuple(by_key[key] for key in keys[start : start + n])
            if used.isdisjoint(places):
                used.update(places)
                named = tuple(names[place] for place in places)
                title = pattern if len(keys) == n else f"{named[0]} to {named[-1]}"
                unit = unit_of(bare) or " ".join(dict.fromkeys(filter(None, map(unit_of, named))))
                complete.append(Family(title, places, named, by_name, signal_of(bare), unit))
    return complete


def _readings(name: str, joints: Sequence[str], numbered: Sequence[str]) -> Iterator[tuple[str, int]]:
    """Interpretations of a name as a pattern and the index of a joint."""
    for spellings in (joints, _short_names(joints)):
        if spelled := [joint for joint in spellings if joint and _spelled(joint, name)]:
            joint = max(spelled, key=len)
            begin = name.lower().index(joint.lower())
            yield name[:begin] + "{joint}" + name[begin + len(joint) :], list(spellings).index(joint)
            return
    for match in re.finditer(r"\d+", name):
        pattern, number = name[: match.start()] + "{number}" + name[match.end() :], int(match[0])
        if not set(joints) <= set(numbered):
            yield pattern, number
        elif 0 < number <= len(numbered) and numbered[number - 1] in joints:
            yield pattern, list(joints).index(numbered[number - 1])
    if len(joints) == 1:
        yield name, 0


def _spelled(joint: str, name: str) -> bool:
    """Whether a column's name contains that of a joint, as a word of its own."""
    return bool(re.search(rf"(?<![^\W_]){re.escape(joint.lower())}(?![^\W_])", name.lower()))


def _short_names(joints: Sequence[str]) -> list[str]:
    """Names of joints without the word joint: FL_hip for FL_hip_joint; empty for a bare number."""
    short = [re.sub(r"(?i)^joint_|_joint$", "", joint) for joint in joints]
    return ["" if name.isdigit() or short.count(name) > 1 else name for name in short]
