"""Tables from rows of nested fields, such as JSON objects and messages, and from rows of single joints.

A point joins a field to the field that contains it, and elements count from 1: `motor_state[0].q` becomes
`motor_state.q1`. If the elements have names, as in a joint state, the names replace the numbers:
`position_elbow`.
"""

import json
from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import NotAFile
from ..reading_limits import largest_size, require_gzip, too_large
from .cells import seconds_of
from .column_names import STAMPS, words_of
from .name_index import names_joints, stated_unit
from .table import Table, lines_of, refused_as

SECONDS, NANOSECONDS = ("sec", "secs", "seconds"), ("nanosec", "nsec", "nsecs", "nanos", "nanoseconds")
"""Names of the parts of a time stamp in ROS 1, ROS 2, Foxglove and protobuf."""
NAMES = ("name", "names", "joint_names", "joints")
"""Fields with the names of elements."""
LONGEST = 200
"""Maximum number of elements of a field; more of them are a picture or a cloud of points."""


def read_json_lines(source: Path) -> list[Table]:
    """Read one JSON object per line; numbers, lists and objects in it become columns."""
    with refused_as(source, "JSON lines"):
        require_gzip(source)
        return [table_of_rows(source, _objects(source))]


def _objects(source: Path) -> Iterator[Any]:
    """JSON objects of a file; a last line that a crashed recorder cut off is left out."""
    damaged = 0
    for line, text in lines_of(source):
        if damaged:
            raise NotAFile(f"{source} line {damaged}: not a JSON object")
        if text.strip():
            try:
                row = json.loads(text)
            except ValueError:
                damaged = line
                continue
            damaged = 0 if isinstance(row, Mapping) else line
            yield row


def table_of_rows(source: Path, rows: Iterable[Any], **known: Any) -> Table:
    """Table of rows of nested fields; a field that a row lacks is NaN. `known` are further attributes."""
    columns: dict[str, array[float]] = {}
    labels: dict[str, dict[str, int]] = {}
    limit, count = largest_size(source), 0
    for count, row in enumerate(rows, 1):
        for name, value in fields_of(row):
            if isinstance(value, str):
                value = labels.setdefault(name, {}).setdefault(value, len(labels[name]) + 1)
            column = columns.setdefault(name, array("d"))
            column.extend([np.nan] * (count - len(column)))
            column[-1] = value
        if 8 * count * len(columns) > limit:
            raise too_large(source)
    for column in columns.values():
        column.extend([np.nan] * (count - len(column)))
    if not columns:
        raise NotAFile(f"{source} holds no numbers")
    joints = {name: list(texts) for name, texts in labels.items()}
    return Table(list(columns), np.column_stack([*columns.values()]), labels=joints, **known)


def fields_of(content: Any, name: str = "", labels: Sequence[str] = ()) -> Iterator[tuple[str, float | str]]:
    """Names and values of all numbers in a field and the fields in it, and of texts that name a joint."""
    if is_dataclass(content):
        content = {field.name: getattr(content, field.name) for field in fields(content)}
    if isinstance(content, Mapping):
        if (stamp := stamp_of(content)) is not None:
            yield name, 1e-9 * stamp
            return
        lists = (content[key] for key in NAMES if isinstance(content.get(key), list | tuple))
        labels = next(
            (list(texts) for texts in lists if texts and all(isinstance(t, str) for t in texts)), []
        )
        for key, item in content.items():
            yield from fields_of(item, f"{name}.{key}" if name else str(key), labels)
    elif isinstance(content, str):
        if (seconds := seconds_of(content)) is not None:
            yield name, seconds
        elif names_joints(name):
            yield name, content
    elif isinstance(content, Sequence | np.ndarray):
        yield from _elements(content, name, labels)
    elif isinstance(content, int | float | np.number):
        yield name, float(content)
    elif content is None:
        yield name, np.nan


def _elements(
    content: Sequence[Any] | np.ndarray, name: str, labels: Sequence[str]
) -> Iterator[tuple[str, float | str]]:
    """Names and values of the elements of a sequence, with their number or name behind that of the field."""
    if len(content) > LONGEST or isinstance(content, bytes | bytearray):
        return
    numbers = [str(k) for k in range(1, len(content) + 1)]
    for item, number, label in zip(content, numbers, _labels(content, labels) or numbers, strict=True):
        between = "" if label == number else "_"
        for inner, value in fields_of(item):
            place = ".".join(filter(None, (name, inner)))
            yield f"{place}{'_' if place[-1:].isdigit() else between}{label}", value


def _labels(content: Sequence[Any] | np.ndarray, labels: Sequence[str]) -> Sequence[str]:
    """Names of the elements: stated beside them or in each of them; empty if there are none."""
    if len(labels) == len(content):
        return labels
    inside = [
        next((item[key] for key in NAMES if isinstance(item.get(key), str)), "")
        for item in content
        if isinstance(item, Mapping)
    ]
    return inside if len(set(inside) - {""}) == len(content) else ()


def stamp_of(content: Mapping[str, Any]) -> int | None:
    """Time [ns] of a mapping with whole seconds and nanoseconds; None for other mappings."""
    parts = [next((content[key] for key in keys if key in content), None) for keys in (SECONDS, NANOSECONDS)]
    if not all(isinstance(part, int) for part in parts):
        return None
    return int(parts[0]) * 1_000_000_000 + int(parts[1])  # type: ignore[arg-type]


MOST = 64
"""Maximum number of joints of a robot; a column with more values counts samples."""
COMPLETE = 0.8
"""Minimum share of the cells with a value: every joint has about as many rows as the others."""


def by_sample(table: Table) -> Table:
    """The table with one row per sample, if it has one row per joint and sample; else the table itself.

    The columns of each joint have its name, or its number in the order of the identifiers, behind their name.
    Samples begin where a joint occurs again; their time is that of their first row.
    """
    for place in range(len(table.names)):
        identifiers = table.values[:, place]
        if not names_joints(table.names[place]) or not np.isfinite(identifiers).all():
            continue
        known, joint = np.unique(identifiers, return_inverse=True)
        if not 2 <= len(known) <= MOST or not np.array_equal(known, np.round(known)):
            continue
        for sample in (_cycles(joint), _moments(table)):
            if (sample[-1] + 1) * len(known) * COMPLETE <= len(joint):
                texts = table.labels.get(table.names[place], ())
                return _arranged(table, place, sample, joint, [texts[int(k) - 1] for k in known if texts])
    return table


def _cycles(joint: np.ndarray) -> np.ndarray:
    """Number of the sample of each row, which ends before a joint (t,) occurs again, shape (t,)."""
    seen: set[int] = set()
    begins = np.zeros(len(joint), int)
    for row, number in enumerate(joint.tolist()):
        if number in seen:
            begins[row] = 1
            seen.clear()
        seen.add(number)
    return np.cumsum(begins)


def _moments(table: Table) -> np.ndarray:
    """Number of the sample of each row if rows of one time are one sample, shape (t,)."""
    clocks = [place for place, name in enumerate(table.names) if STAMPS.intersection(words_of(name))]
    if not clocks:
        return np.arange(len(table.values))
    return np.asarray(np.unique(table.values[:, clocks[0]], return_inverse=True)[1])


def _arranged(table: Table, place: int, sample: np.ndarray, joint: np.ndarray, labels: list[str]) -> Table:
    """Rows (t,) of joints and samples as one row per sample; column `place` names the joint."""
    count = int(joint.max()) + 1
    names, columns, units = [], [], dict(table.units)
    for name, values in zip(table.names, table.values.T, strict=True):
        cells = np.full((int(sample.max()) + 1, count), np.nan)
        cells[sample, joint] = values
        if name == table.names[place]:
            continue
        if STAMPS.intersection(words_of(name)):
            names.append(name)
            columns.append(np.nanmin(cells, axis=1, initial=np.inf))
            continue
        bare, unit = stated_unit(name)
        each = [f"{bare}_{label}" for label in labels] or [f"{bare}{k}" for k in range(1, count + 1)]
        names += each
        columns += list(cells.T)
        units |= dict.fromkeys(each, units.get(name) or unit)
    lines = None if table.lines is None else table.lines[np.unique(sample, return_index=True)[1]]
    return table._replace(
        names=names, values=np.column_stack(columns), lines=lines, units={k: v for k, v in units.items() if v}
    )
