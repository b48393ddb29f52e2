"""Dataclasses as tables of a file and back, by their annotations, for any family of trajectories.

A field of a family may be a number, a text, a boolean, an array of floats, a tuple of any of these, a
trajectory, or a tuple of trajectories. Integers belong in a tuple, not in an array.
"""

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import MISSING, fields
from functools import partial
from itertools import groupby
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

from exidyn.identification.robot_files.toml_fields import block, boolean, check_keys, integer, number, string

from ..errors import NotATrajectory, TrajectoryError, UnknownChoice
from ..families import FAMILIES
from ..trajectory import Trajectory

FAMILY = "family"
"""Key of the family's name."""
AXES = 3
"""Maximum number of axes of an array: time, joint and coefficient."""
FEW = 5
"""Maximum number of parts of a trajectory that are named one by one."""
_WORDS = {float: "a number", int: "a whole number", str: "a text", bool: "true or false"}

Reader = Callable[[object, str], Any]


def family_words(trajectory: Trajectory) -> str:
    """Names of a trajectory's family and of the families of its parts, with counts of repetitions."""
    inner = [_family_of(part) for value in _values(trajectory).values() for part in _parts(value)]
    rows = [(name, len(list(group))) for name, group in groupby(inner)]
    words = [name if count == 1 else f"{count} {name}" for name, count in rows]
    if len(words) > FEW:
        words = [f"{len(words)} parts"]
    return " of ".join(filter(None, [_family_of(trajectory), ", ".join(words)]))


def trajectory_blocks(trajectory: Trajectory, place: str, heading: str = "[{}]") -> list[str]:
    """TOML of a trajectory, then of its parts; raises `UnknownChoice` if it is of no family in the table."""
    flat: dict[str, Any] = {FAMILY: _family_of(trajectory)}
    inner: list[str] = []
    for name, value in _values(trajectory).items():
        for part in _parts(value):
            below = "[[{}]]" if isinstance(value, tuple) else "[{}]"
            inner += trajectory_blocks(part, f"{place}.{name}", below)
        if not _parts(value) and value is not None:
            flat[name] = value
    return [block(heading.format(place), flat, tall=True), *inner]


def read_trajectory(table: object, where: str) -> Trajectory:
    """Trajectory from its table.

    Raises:
        RobotError: A value is invalid for its key.
        NotATrajectory: A key is missing, or the values form no valid trajectory.
    """
    name = table.get(FAMILY) if isinstance(table, Mapping) else None
    if not isinstance(table, Mapping) or not isinstance(name, str) or name not in FAMILIES:
        reason = f"family {name!r}" if name is not None else "no key 'family'"
        raise NotATrajectory(f"{where}: {reason}; expected one of: {', '.join(sorted(FAMILIES))}")
    kind = FAMILIES[name]
    declared = [f.name for f in fields(kind) if f.init]
    check_keys(table, (FAMILY, *declared), where)
    values = read_fields(kind, table, declared, f"{where} ")
    try:
        return kind(**values)
    except TrajectoryError as error:
        raise NotATrajectory(f"{where}: {error}") from error
    except (ArithmeticError, IndexError, TypeError, ValueError) as error:
        raise NotATrajectory(f"{where}: these values form no valid {name}: {error}") from error


def read_fields(kind: type, table: Mapping[str, Any], names: Collection[str], before: str) -> dict[str, Any]:
    """Some fields of a dataclass from a table; those with a default may be missing.

    `before` is the text before the name of a field in messages.

    Raises:
        RobotError: A value is invalid for its key.
        NotATrajectory: A key is missing.
    """
    hints, values = get_type_hints(kind), {}
    for f in fields(kind):
        needed = f.default is MISSING and f.default_factory is MISSING
        if f.name in table and f.name in names:
            values[f.name] = _reader(hints[f.name], not needed)(table[f.name], before + f.name)
        elif f.name in names and needed:
            where = f"{before.strip()}: " if before else ""
            expected = _words(hints[f.name])
            raise NotATrajectory(
                f"{where}key '{f.name}' is missing, expected {expected}; was the file cut off?"
            )
    return values


def _family_of(trajectory: Trajectory) -> str:
    for name, kind in FAMILIES.items():
        if kind is type(trajectory):
            return name
    raise UnknownChoice("family of trajectories", type(trajectory).__name__, FAMILIES)


def _values(trajectory: Trajectory) -> dict[str, Any]:
    return {f.name: getattr(trajectory, f.name) for f in fields(trajectory) if f.init}


def _parts(value: object) -> tuple[Trajectory, ...]:
    """Trajectories that a field contains; empty if it contains something else."""
    if isinstance(value, Trajectory):
        return (value,)
    return value if isinstance(value, tuple) and value and isinstance(value[0], Trajectory) else ()


def _reader(kind: Any, empty: bool = True) -> Reader:
    """Reader for a field of this type; `empty` is that of `string`."""
    if get_origin(kind) in (Union, UnionType):
        return _reader(next(option for option in get_args(kind) if option is not NoneType), empty)
    if get_origin(kind) is tuple:
        return partial(_tuple, kind)
    if isinstance(kind, type) and issubclass(kind, Trajectory):
        return partial(_inner, kind)
    readers: dict[Any, Reader] = {
        float: number,
        int: integer,
        bool: boolean,
        str: partial(string, empty=empty),
    }
    return _array if get_origin(kind) is np.ndarray or kind is np.ndarray else readers[kind]


def _tuple(kind: Any, value: object, where: str) -> tuple:
    if not isinstance(value, list):
        raise NotATrajectory(f"{where}: expected {_words(kind)}; found {value!r}")
    read = _reader(get_args(kind)[0], empty=False)
    return tuple(read(item, f"{where}[{place}]") for place, item in enumerate(value))


def _inner(kind: type[Trajectory], value: object, where: str) -> Trajectory:
    trajectory = read_trajectory(value, where)
    if not isinstance(trajectory, kind):
        raise NotATrajectory(f"{where}: a {_family_of(trajectory)}, expected {_words(kind)}")
    return trajectory


def _array(value: object, where: str, axes: int = AXES) -> np.ndarray:
    """Array from nested lists of finite numbers with at most `axes` levels and rows of equal length."""
    if not isinstance(value, list):
        return np.asarray(number(value, where))
    if not axes:
        raise NotATrajectory(f"{where}: lists within lists, more than {AXES} deep")
    parts = [_array(item, f"{where}[{place}]", axes - 1) for place, item in enumerate(value)]
    for place, part in enumerate(parts):
        if part.shape != parts[0].shape:
            raise NotATrajectory(
                f"{where}: row {place} has shape {part.shape}, and row 0 {parts[0].shape}; all must be equal"
            )
    return np.array(parts, float)


def _words(kind: Any) -> str:
    """Description of a field's type for messages."""
    if kind in _WORDS:
        return _WORDS[kind]
    if get_origin(kind) is tuple:
        return f"a list, each {_words(get_args(kind)[0])}"
    if isinstance(kind, type) and issubclass(kind, Trajectory):
        valid = [name for name, family in FAMILIES.items() if issubclass(family, kind)]
        return f"a trajectory of family {' or '.join(valid)}"
    return "a list of numbers" if kind is np.ndarray else re.sub(r"\s*\|\s*None", "", str(kind))
