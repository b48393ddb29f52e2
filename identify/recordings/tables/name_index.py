"""Names of columns: lookup in any spelling, words for signals, units, and numbered columns of arrays."""

import re
from collections.abc import Collection, Sequence

from ...arm.robot import Robot
from ...errors import LISTED, listed
from ..units import SPELLINGS, UNITS, is_travel, unit_named

_SEPARATORS = re.compile(r"[\W_]+")
_BESIDE_DIGIT = re.compile(r"(?<=[^\W\d])_(?=\d)|(?<=\d)_(?=[^\W\d])")
SHORTEST_RUN = 3
"""Minimum number of consecutive columns of one name that a list shortens to `q1 to q6`."""
WORDS: dict[str, frozenset[str]] = {
    "temperature": frozenset("temp temps temperature temperatures temperatur".split()),
    "torque": frozenset("tau taus torque torques trq effort efforts moment moments drehmoment nm".split()),
    "link_position": frozenset("ql secondary".split()),
    "velocity": frozenset(
        "dq qd qvel vel velocity velocities speed speeds qdot omega geschwindigkeit drehzahl rpm".split()
    ),
    "position": frozenset("q qpos pos position positions angle angles winkel theta lage".split()),
    "current": frozenset("i cur curr current currents strom amps iq".split()),
}
"""Signal -> words for it; the first signal with a word counts: `current position` is a position."""
TIMES = (
    "t", "time", "timestamp", "timestamps", "time_stamp", "stamp", "zeit", "zeitstempel", "temps", "seconds",
    "secs", "sec", "clock",
)  # fmt: skip
"""Words for time."""
JOINTS = frozenset("joint joints motor motors axis axes servo id ids actuator achse".split())
"""Words for the column that names the joint of a row."""
UNITS_ONLY = frozenset(("nm", "rpm"))
"""Words that are units, and ambiguous without another word."""
COMMANDED = frozenset("ref cmd command commanded target des desired soll setpoint goal reference d".split())
"""Words for commanded quantities."""
OTHERS = frozenset("tcp pose cart cartesian force wrench ext err error std model gravity tool ft".split())
"""Words for quantities that are computed, or not those of a joint."""

BRACKETED = re.compile(r"(.*?)[\s_]*(?:in\s+)?[\[(<{]\s*([^\[\](){}<>]+?)\s*[\])>}]\s*", re.DOTALL)
_WORDS = {name for names in SPELLINGS.values() for name in names.split()} - {"c", "min-1"} | {"nm"}
SUFFIXES = sorted(
    {*UNITS, *_WORDS, "Nm", "mNm", "Nmm", "C", "Deg", "Rad", "NM", "MS", "RPM"}, key=len, reverse=True
)
"""Units behind an underscore, a space or the like; `A` but not `a`, since `tau_a` belongs to a joint a."""
SUFFIXED = re.compile(rf"(.+?)(?:[\s_./,:-]+|\s+in\s+)({'|'.join(map(re.escape, SUFFIXES))})\s*")


class NameIndex:
    """Columns of a table by name: the exact name, else any spelling that only one column has."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = names
        self._exact = {name: place for place, name in enumerate(names)}
        self._alike: list[dict[str, list[int]]] = [{}, {}, {}, {}]
        for place, name in enumerate(names):
            bare = stated_unit(name)[0]
            spellings = (name, bare, *_in_groups(bare))
            for alike, spelling in zip(self._alike, spellings, strict=True):
                alike.setdefault(spelling_key(spelling), []).append(place)

    def exact(self, name: str) -> bool:
        """Whether a column has exactly this name."""
        return name in self._exact

    def place(
        self, choices: Sequence[str], quantities: Collection[str] = (), reserved: Collection[int] = ()
    ) -> int:
        """Index of the first column with one of some names, in the order of preference; -1 if there is none.

        Columns whose names contain a unit of none of the SI `quantities`, and `reserved` ones, are skipped.
        """
        for name in choices:
            if self._exact.get(name, -1) not in (-1, *reserved):
                return self._exact[name]
        for alike in self._alike:
            for name in choices:
                places = [k for k in alike.get(spelling_key(name), ()) if k not in reserved]
                if len(places) == 1 and self.fits(places[0], quantities):
                    return places[0]
        return -1

    def fits(self, place: int, quantities: Collection[str]) -> bool:
        """Whether the unit in a column's name, if there is one, is that of one of the SI `quantities`."""
        unit = stated_unit(self._names[place])[1]
        entry = unit_named(unit)
        return not unit or not quantities or is_travel(unit) or (entry is not None and entry[0] in quantities)


def _in_groups(name: str) -> tuple[str, str]:
    """A name with its last group and without groups; unchanged in groups of other quantities."""
    *groups, last = re.split(r"[/.]", name)
    words = set(re.split(r"[\W_\d]+", "/".join(groups).lower()))
    return (name, name) if words & (OTHERS | COMMANDED) else ("/".join([*groups[-1:], last]), last)


def spelling_key(name: str) -> str:
    """Normal form of all spellings of a name: `J1 Position` becomes `j1_position`, and q[0] becomes q_0."""
    return _BESIDE_DIGIT.sub("", _SEPARATORS.sub("_", name.lower()).strip("_"))


def numbered(name: str) -> tuple[str, int, str] | None:
    """Text before the last number in a column's name, the number, and the text behind it."""
    match = re.fullmatch(r"(.*?)(\d+)(\D*)", name, re.DOTALL)
    return (match[1], int(match[2]), match[3]) if match else None


def columns_of_array(names: Sequence[str], name: str) -> list[str]:
    """Columns whose names differ from this name only in the number, sorted by number."""
    parts = numbered(name)
    if parts is None:
        return [name]
    array = {other[1]: text for text in names if (other := numbered(text)) and other[::2] == parts[::2]}
    return [array[number] for number in sorted(array)]


def column_words(names: Sequence[str], like: str = "") -> str:
    """Names of columns in their order; if there are many, `q1 to q6` stands for those of an array."""
    if len(", ".join(names)) <= LISTED:
        return ", ".join(names) or "none"
    runs: list[list[str]] = []
    for name in names:
        before, after = numbered(runs[-1][-1] if runs else ""), numbered(name)
        if before and after and after == (before[0], before[1] + 1, before[2]):
            runs[-1].append(name)
        else:
            runs.append([name])
    ends = [numbered(run[-1]) for run in runs]
    words = [
        f"{run[0]} to {end[1]}" if end and len(run) >= SHORTEST_RUN else ", ".join(run)
        for run, end in zip(runs, ends, strict=True)
    ]
    return listed(words, like)


def which_columns(signal: str, array: Sequence[str], robot: Robot) -> str:
    """Question about an array with more columns than an arm has joints, with options that answer it."""
    n, m = robot.dof, len(array)
    half = m // 2
    begins = 0, half if m % 2 == 0 and half >= n else m - n
    blocks = [array[begin : begin + n] for begin in begins]
    words = [
        " to ".join(str(end[1]) for name in (block[0], block[-1]) if (end := numbered(name)))
        for block in blocks
    ]
    first, second = map(_range, blocks)
    return (
        f"{array_name(array)} has {m} columns for {n} joints ({named_joints(robot)}): which? For example "
        f"{words[0]}, or {words[1]}: --columns {signal}={first}, or {signal}={second}"
    )


def _range(array: Sequence[str]) -> str:
    """Consecutive columns as a value of `--columns`: q1..6; names without numbers are listed."""
    first, last = numbered(array[0]), numbered(array[-1])
    if first is None or last is None or last[1] - first[1] != len(array) - 1 or len(array) == 1:
        return ",".join(array)
    return f"{first[0]}{first[1]}..{last[1]}{first[2]}"


def named_joints(robot: Robot, most: int = 3) -> str:
    """Names of the joints; only the first and the last if there are many."""
    joints = robot.joints
    return ", ".join(joints) if len(joints) <= most else f"{joints[0]} to {joints[-1]}"


def array_name(array: Sequence[str]) -> str:
    """Common part of the names of an array's columns."""
    parts = numbered(array[0])
    return (parts[0].rstrip(" _[(.-") + parts[2].lstrip(")] ")) if parts else array[0]


def names_joints(name: str) -> bool:
    """Whether a column may name the joint of each row, by its words."""
    return bool(JOINTS.intersection(re.split(r"[\W_\d]+", name.lower())))


def stated_unit(name: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit; "" if there is none."""
    for pattern in (BRACKETED, SUFFIXED):
        match = pattern.fullmatch(name)
        if match and match[1].strip() and is_unit(match[2]):
            return match[1].strip(), match[2]
    return name, ""


def is_unit(text: str) -> bool:
    """Whether a text is a unit of any signal."""
    return unit_named(text) is not None or is_travel(text)


def is_unit_row(cells: list[str]) -> bool:
    """Whether a row below the names states units: at least two, and mostly units and placeholders."""
    stated = [cell for cell in cells if is_unit(cell)]
    others = [cell for cell in cells if cell.strip("[]()-– ") and not is_unit(cell)]
    return bool(stated) and len(stated) >= min(2, len(cells)) and len(others) <= len(stated)
