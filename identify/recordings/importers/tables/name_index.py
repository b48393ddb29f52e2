"""Columns by name, whatever the case, separators and units in the names, and whatever group they lie in."""

import re
from collections.abc import Collection, Sequence

from ....errors import LISTED, listed
from ...units import is_travel, unit_named
from .signal_words import COMMANDED, OTHERS
from .stated_units import stated_unit

_SEPARATORS = re.compile(r"[\W_]+")
_BESIDE_DIGIT = re.compile(r"(?<=[^\W\d])_(?=\d)|(?<=\d)_(?=[^\W\d])")
SHORTEST_RUN = 3
"""Consecutive numbers of one name from which on a list of columns is shortened to `q1 to q6`."""


class NameIndex:
    """Columns of a table by name: as it is written, else by any spelling that only one column has."""

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
        """Whether a column is called so to the letter."""
        return name in self._exact

    def place(
        self, choices: Sequence[str], quantities: Collection[str] = (), taken: Collection[int] = ()
    ) -> int:
        """Number of the first column that has one of some names; -1 if there is none.

        A column with a unit of another quantity in its name is none, nor is one of those that are taken;
        `quantities` are SI units.
        """
        for name in choices:
            if self._exact.get(name, -1) not in (-1, *taken):
                return self._exact[name]
        for alike in self._alike:
            for name in choices:
                places = [k for k in alike.get(spelling_key(name), ()) if k not in taken]
                if len(places) == 1 and self._fits(places[0], quantities):
                    return places[0]
        return -1

    def _fits(self, place: int, quantities: Collection[str]) -> bool:
        unit = stated_unit(self._names[place])[1]
        entry = unit_named(unit)
        return not unit or not quantities or is_travel(unit) or (entry is not None and entry[0] in quantities)


def _in_groups(name: str) -> tuple[str, str]:
    """A name behind its groups, with the last of them and without; as it is in groups of other quantities."""
    *groups, last = re.split(r"[/.]", name)
    words = set(re.split(r"[\W_\d]+", "/".join(groups).lower()))
    return (name, name) if words & (OTHERS | COMMANDED) else ("/".join([*groups[-1:], last]), last)


def spelling_key(name: str) -> str:
    """What all spellings of a name have in common: `J1 Position` is `j1_position`, and q[0] is q_0."""
    return _BESIDE_DIGIT.sub("", _SEPARATORS.sub("_", name.lower()).strip("_"))


def numbered(name: str) -> tuple[str, int, str] | None:
    """A column's name as what stands before its last number, the number, and what stands behind it."""
    match = re.fullmatch(r"(.*?)(\d+)(\D*)", name, re.DOTALL)
    return (match[1], int(match[2]), match[3]) if match else None


def columns_of_array(names: Sequence[str], name: str) -> list[str]:
    """The columns that differ from one only in their number, by their numbers."""
    parts = numbered(name)
    if parts is None:
        return [name]
    same = {other[1]: text for text in names if (other := numbered(text)) and other[::2] == parts[::2]}
    return [same[number] for number in sorted(same)]


def column_words(names: Sequence[str], like: str = "") -> str:
    """Names of columns in their order; where they are many, `q1 to q6` stands for those of one array."""
    if len(", ".join(names)) <= LISTED:
        return ", ".join(names) or "none"
    runs: list[list[str]] = []
    for name in names:
        if runs and _goes_on(runs[-1][-1], name):
            runs[-1].append(name)
        else:
            runs.append([name])
    return listed((_run_words(run) for run in runs), like)


def _goes_on(name: str, after: str) -> bool:
    """Whether a name is the next of an array."""
    one, other = numbered(name), numbered(after)
    return bool(one and other and one[::2] == other[::2] and other[1] == one[1] + 1)


def _run_words(run: Sequence[str]) -> str:
    last = numbered(run[-1])
    return f"{run[0]} to {last[1]}" if last and len(run) >= SHORTEST_RUN else ", ".join(run)
