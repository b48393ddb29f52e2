"""Seeded damage to valid files: bytes, lines, numbers, values and nesting that parsers have to survive."""

import contextlib
import copy
import json
import re
import struct
from collections.abc import Callable
from typing import Any

import numpy as np

Mutation = Callable[[bytes, np.random.Generator], bytes]

NUMBER = re.compile(rb"(?<![\w.])-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
ASSIGNED = re.compile(rb"(?<==)[^=\n]+|(?<=:)[^:\n]+")
"""What stands behind an equals sign or a colon, to the end of its line."""
WORD = re.compile(rb"[A-Za-z_]\w+")

NUMBERS = (
    b"nan", b"inf", b"-inf", b"NaN", b"Infinity", b"1e400", b"-1e400", b"1e308", b"-1e308", b"1e-320", b"0",
    b"-1", b"99999999999999999999", b"-99999999999999999999", b"9" * 400, b"9" * 5000, b"0x" + b"f" * 5000,
    b"1e15", b"4294967296", b"0.5", b"1.5", b"true", b'"text"', b"text", b"", b"1,2", b"[1.0, 2.0]",
)  # fmt: skip
VALUES = (
    b' "text"', b" 3", b" -1", b" true", b" []", b" [[]]", b" {}", b" null", b' ""', b" [1, 2, 3]",
    b' ["a", 1]', b" nan", b" 1979-05-27", b" {a = 1}", b' {"a": 1}', b' "' + b"long " * 2000 + b'"',
    b' "\\u0000\\u001b[31m"', b" 99999999999999999999", b" 0x" + b"f" * 5000, b" [" + b"1, " * 5000 + b"1]",
    b"", b' "../../nowhere"',
)  # fmt: skip
OBJECTS: tuple[Any, ...] = (
    None, True, 0, -1, 10**20, 10**400, 1.5, float("nan"), float("inf"), "", "text", "x" * 5000, "\ud800", [],
    [[]], {}, {"a": 1}, [1, 2, 3], ["a", None], [1] * 5000,
)  # fmt: skip
ODD: tuple[Any, ...] = (
    None,
    True,
    0,
    1,
    2.5,
    "",
    "text",
    "N m",
    "1",
    [],
    {},
    {"a": 1},
    "a\nb",
    "<b>&</b>",
    "../x",
)
AMOUNTS = (float("nan"), float("inf"), 1e300, -1e300, 1e-300, 1e99, -1, 0, 0.0, 10**20, "nan", "inf", None)
"""What may stand in place of text, and of a number."""
FACTORS = (0.0, 1.0, -1.0, 1e-3, 1e3, 1e-9, 1e9, 1e-30, 1e30)
DOUBLES = (np.nan, np.inf, -np.inf, 1e308, -1e308, 1e-320, 0.0, -1.0, 1e15)
DEEP = (100, 3000, 100_000)
"""Levels of nesting: what a person might, what Python's stack does not bear, and far beyond it."""


def mutated(data: bytes, random: np.random.Generator, mutations: tuple[Mutation, ...]) -> bytes:
    """Mostly one mutation; now and then up to three, one on top of the other."""
    for _ in range(random.choice(3, p=[0.7, 0.2, 0.1]) + 1):
        data = mutations[random.integers(len(mutations))](data, random)
    return data


def flip(data: bytes, random: np.random.Generator) -> bytes:
    """A few bytes become others."""
    changed = bytearray(data)
    for place in random.integers(0, len(data), random.integers(1, 9)) if data else ():
        changed[place] ^= int(random.integers(1, 256))
    return bytes(changed)


def cut(data: bytes, random: np.random.Generator) -> bytes:
    """The end is missing, or the beginning, or everything."""
    place = int(random.integers(0, len(data) + 1))
    return (data[:place], data[place:], b"")[random.choice(3, p=[0.8, 0.15, 0.05])]


def insert(data: bytes, random: np.random.Generator) -> bytes:
    """Bytes that are no text of UTF-8, or none at all."""
    added = (b"\xff\xfe", b"\x00", b"\xef\xbb\xbf", b"\xed\xa0\x80", b"\x1b[31m", b"\r", b"\xc3")
    place = int(random.integers(0, len(data) + 1))
    return data[:place] + added[random.integers(len(added))] + data[place:]


def recode(data: bytes, random: np.random.Generator) -> bytes:
    """Saved by an editor in another encoding."""
    text = data.decode("utf-8", errors="replace")
    return text.encode(("utf-16", "utf-32", "utf-8-sig")[random.integers(3)])


def lines(data: bytes, random: np.random.Generator) -> bytes:
    """Lines are deleted, doubled, exchanged, or there many times."""
    rows = data.split(b"\n")
    one, other = random.integers(0, len(rows), 2)
    kind = random.integers(4)
    if kind == 0:
        del rows[one : one + int(random.integers(1, 4))]
    elif kind == 1:
        rows.insert(other, rows[one])
    elif kind == 2:
        rows[one], rows[other] = rows[other], rows[one]
    else:
        rows[one:one] = [rows[one]] * 300
    return b"\n".join(rows)


def number(data: bytes, random: np.random.Generator) -> bytes:
    """A number becomes one that no computer or arm has, or none."""
    return _replaced(data, random, NUMBER, NUMBERS)


def value(data: bytes, random: np.random.Generator) -> bytes:
    """What stands behind = or : becomes another type."""
    return _replaced(data, random, ASSIGNED, VALUES)


def word(data: bytes, random: np.random.Generator) -> bytes:
    """A word becomes another one of the file, or something else."""
    found = WORD.findall(data)
    if not found:
        return data
    other = found[random.integers(len(found))]
    return _replaced(data, random, WORD, (other, other, b"", b"x" * 2000, b"\xc3\xbc"))


def deep(data: bytes, random: np.random.Generator) -> bytes:
    """Lists in lists, tables in tables, elements in elements, at some line or in place of a value."""
    levels = DEEP[random.integers(len(DEEP))]
    nested = (
        b"[" * levels + b"]" * levels,
        b'{"a":' * levels + b"1" + b"}" * levels,
        b"{a=" * levels + b"1" + b"}" * levels,
        b"<link>" * levels + b"</link>" * levels,
        b"a." * levels + b"b = 1\n",
    )[random.integers(5)]
    if random.random() < 0.5:
        return _replaced(data, random, ASSIGNED, (nested,))
    rows = data.split(b"\n")
    rows.insert(int(random.integers(0, len(rows) + 1)), nested)
    return b"\n".join(rows)


def double(data: bytes, random: np.random.Generator) -> bytes:
    """Eight bytes become a number that no sensor gives."""
    if len(data) < 8:
        return data
    place = int(random.integers(0, len(data) - 7)) // 8 * 8
    packed = struct.pack("<d", DOUBLES[random.integers(len(DOUBLES))])
    return data[:place] + packed + data[place + 8 :]


def tree(data: bytes, random: np.random.Generator) -> bytes:
    """An entry of a JSON file is missing, or of another type."""
    try:
        table = json.loads(data)
    except (ValueError, RecursionError):
        return data
    places: list[tuple[Any, Any]] = []
    _collect(table, places)
    if not places:
        return data
    holder, key = places[random.integers(len(places))]
    if random.random() < 0.25:
        del holder[key]
    else:
        holder[key] = OBJECTS[random.integers(len(OBJECTS))]
    return json.dumps(table, indent=1).encode()


def edited(data: bytes, random: np.random.Generator) -> bytes:
    """An entry of a JSON file is one that a person makes of it: of the same type, or nearly."""
    table = json.loads(data)
    places: list[tuple[Any, Any]] = []
    _collect(table, places, most=40)
    if not places:  # an earlier mutation took everything
        return data
    for _ in range(random.choice(3, p=[0.8, 0.15, 0.05]) + 1):
        holder, key = places[random.integers(len(places))]
        if key in holder if isinstance(holder, dict) else key < len(holder):
            _edit(holder, key, places, random)
    return json.dumps(table, indent=1).encode()


def _edit(holder: Any, key: Any, places: list[tuple[Any, Any]], random: np.random.Generator) -> None:
    """Removed, doubled, exchanged with another entry, or another value in its place."""
    value, kind = holder[key], random.integers(6)
    if kind == 0:
        del holder[key]
    elif kind == 1 and isinstance(holder, list):
        holder.insert(key, copy.deepcopy(value))
    elif kind == 2:
        other, place = places[random.integers(len(places))]
        if place in other if isinstance(other, dict) else place < len(other):
            holder[key] = copy.deepcopy(other[place])
    elif isinstance(value, list) and value:
        holder[key] = value[: random.integers(len(value))] if kind < 5 else value[::-1]
    elif isinstance(value, bool | str | dict | list) or value is None:
        holder[key] = ODD[random.integers(len(ODD))]
    else:
        value = value if abs(value) < 1e300 else 1  # of whole numbers beyond, no float can be made
        numbers = (*AMOUNTS, -value, str(value), float(value) + 0.5, 1e6 * value, 1e-6 * value, [value])
        holder[key] = numbers[random.integers(len(numbers))]


def scaled(data: bytes, random: np.random.Generator) -> bytes:
    """A fit that is still one: a base parameter or gain with another value, and much more or less sure."""
    table = json.loads(data)
    with contextlib.suppress(TypeError, LookupError, ValueError):  # it is none any more
        _scale(table, random)
    return json.dumps(table).encode()


def _scale(table: Any, random: np.random.Generator) -> None:
    rows, covariance = table["base_parameters"], table["covariance"]
    for _ in range(random.integers(1, 5)):
        place, factor = random.integers(len(covariance)), FACTORS[random.integers(len(FACTORS))]
        covariance[place] = [factor * value for value in covariance[place]]
        for row in covariance:
            row[place] *= factor
        rows[random.integers(len(rows))]["value"] *= FACTORS[random.integers(len(FACTORS))]
        gain = random.integers(len(table["drive_gain"]))
        table["drive_gain"][gain] *= FACTORS[random.integers(1, len(FACTORS))]


def big_double(data: bytes, random: np.random.Generator) -> bytes:
    """Eight bytes anywhere become a number that no controller sends."""
    if len(data) < 8:
        return data
    place = int(random.integers(0, len(data) - 7))
    packed = struct.pack(">d", (*DOUBLES, 1e30, -1e30, 1e5)[random.integers(len(DOUBLES) + 3)])
    return data[:place] + packed + data[place + 8 :]


def _collect(node: Any, places: list[tuple[Any, Any]], most: int = 5) -> None:
    """All pairs of a table or list and a key or place in it; of long lists the first few items."""
    listed = enumerate(node[:most]) if isinstance(node, list) else ()
    for key, inner in node.items() if isinstance(node, dict) else listed:
        places.append((node, key))
        _collect(inner, places, most)


def _replaced(
    data: bytes, random: np.random.Generator, pattern: re.Pattern[bytes], choices: tuple[bytes, ...]
) -> bytes:
    """One match of a pattern, or now and then up to twenty of them, becomes one of the choices."""
    found = list(pattern.finditer(data))
    if not found:
        return data
    count = min(20, max(1, len(found) // 10)) if random.random() < 0.1 else 1
    for place in sorted(random.choice(len(found), count, replace=False), reverse=True):
        match = found[place]
        data = data[: match.start()] + choices[random.integers(len(choices))] + data[match.end() :]
    return data


BINARY: tuple[Mutation, ...] = (flip, flip, cut, double, double, double, insert, word)
TEXT: tuple[Mutation, ...] = (
    flip,
    cut,
    insert,
    recode,
    lines,
    lines,
    number,
    number,
    number,
    value,
    value,
    word,
    deep,
)
PACKETS: tuple[Mutation, ...] = (flip, cut, big_double, big_double, big_double, big_double, insert)
EDITED: tuple[Mutation, ...] = (edited, edited, edited, edited, tree)
"""Of files that remain JSON."""
JSON: tuple[Mutation, ...] = (*TEXT, tree, tree, tree, tree, tree, tree)
