"""A trajectory as a table of a file, by the fields of its dataclass: no family is known by name here.

What a field may be: a number, a text, true or false, an array of floats, a tuple of one of them, a
trajectory, or a tuple of trajectories. An array of whole numbers belongs in a tuple.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, fields
from functools import partial
from itertools import groupby
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

from exidyn.identify.robot_files.toml_fields import boolean, check_keys, integer, number, string
from exidyn.identify.robot_files.toml_text import block

from ..errors import NotATrajectory, TrajectoryError, UnknownChoice
from ..families import FAMILIES
from ..trajectory import Trajectory

FAMILY = "family"
"""Key of the family's name."""

AXES = 3
"""Axes of an array, at most: time, joint and coefficient."""
FEW = 5
"""Parts of a trajectory that are named one by one, at most."""

Reader = Callable[[object, str], Any]


def family_of(trajectory: Trajectory) -> str:
    """Name of a trajectory's family.

    Raises:
        UnknownChoice: It is of none in the table.
    """
    for name, kind in FAMILIES.items():
        if kind is type(trajectory):
            return name
    raise UnknownChoice("family of trajectories", type(trajectory).__name__, FAMILIES)


def family_words(trajectory: Trajectory) -> str:
    """Name of a trajectory's family, and of those it is made of: how many of one kind in a row."""
    inner = [family_of(part) for value in _values(trajectory).values() for part in _parts(value)]
    rows = [(name, len(list(same))) for name, same in groupby(inner)]
    words = [name if count == 1 else f"{count} {name}" for name, count in rows]
    if len(words) > FEW:
        words = [f"{len(words)} parts"]
    return " of ".join(filter(None, [family_of(trajectory), ", ".join(words)]))


def _values(trajectory: Trajectory) -> dict[str, Any]:
    return {f.name: getattr(trajectory, f.name) for f in fields(trajectory) if f.init}


def _parts(value: object) -> tuple[Trajectory, ...]:
    """Trajectories that a field holds; none if it holds something else."""
    if isinstance(value, Trajectory):
        return (value,)
    return value if isinstance(value, tuple) and value and isinstance(value[0], Trajectory) else ()


def trajectory_blocks(trajectory: Trajectory, place: str, heading: str = "[{}]") -> list[str]:
    """TOML of a trajectory and, behind it, of those it is made of."""
    flat: dict[str, Any] = {FAMILY: family_of(trajectory)}
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
        RobotError: A value is not what its key needs.
        NotATrajectory: A key is missing, or its values make no such trajectory.
    """
    kind = _family(table, where)
    declared = {f.name: f for f in fields(kind) if f.init}
    check_keys(table, (FAMILY, *declared), where)
    assert isinstance(table, Mapping)
    hints = get_type_hints(kind)
    for name, declaration in declared.items():
        if name not in table and needed(declaration):
            expected = _words(hints[name])
            raise NotATrajectory(
                f"{where}: key '{name}' is missing, expected {expected}; was the file cut off?"
            )
    given = {name: _reader(hints[name])(table[name], f"{where} {name}") for name in declared if name in table}
    try:
        return kind(**given)
    except TrajectoryError as error:
        raise NotATrajectory(f"{where}: {error}") from error
    except (ArithmeticError, IndexError, TypeError, ValueError) as error:
        raise NotATrajectory(f"{where}: these values make no {table[FAMILY]}: {error}") from error


def _family(table: object, where: str) -> type[Trajectory]:
    name = table.get(FAMILY) if isinstance(table, Mapping) else None
    if not isinstance(name, str) or name not in FAMILIES:
        found = f"family {name!r}" if name is not None else "no key 'family'"
        raise NotATrajectory(f"{where}: {found}; expected one of: {', '.join(sorted(FAMILIES))}")
    return FAMILIES[name]


def needed(declaration: "Field[Any]") -> bool:
    """Whether a field has no default, so that a file must give it."""
    return declaration.default is MISSING and declaration.default_factory is MISSING


def _reader(kind: Any) -> Reader:
    """How a field of this type is read."""
    if get_origin(kind) in (Union, UnionType):
        return _reader(next(option for option in get_args(kind) if option is not NoneType))
    if get_origin(kind) is tuple:
        item = _reader(get_args(kind)[0])
        return lambda value, where: tuple(item(v, f"{where}[{i}]") for i, v in enumerate(_list(value, where)))
    if isinstance(kind, type) and issubclass(kind, Trajectory):
        return lambda value, where: _of_kind(read_trajectory(value, where), kind, where)
    if get_origin(kind) is np.ndarray:
        return array
    return READERS[kind]


def _of_kind(found: Trajectory, kind: type[Trajectory], where: str) -> Trajectory:
    if not isinstance(found, kind):
        raise NotATrajectory(f"{where}: a {family_of(found)}, expected {_words(kind)}")
    return found


def _list(value: object, where: str) -> list:
    if not isinstance(value, list):
        raise NotATrajectory(f"{where}: expected a list; found {value!r}")
    return value


def array(value: object, where: str, axes: int = AXES) -> np.ndarray:
    """Nested lists of finite numbers, of `axes` levels at most, of which all rows are equally long."""
    if not isinstance(value, list):
        return np.asarray(number(value, where))
    if not axes:
        raise NotATrajectory(f"{where}: lists within lists, more than {AXES} deep")
    parts = [array(item, f"{where}[{place}]", axes - 1) for place, item in enumerate(value)]
    for place, part in enumerate(parts):
        if part.shape != parts[0].shape:
            raise NotATrajectory(
                f"{where}: row {place} has shape {part.shape}, and row 0 {parts[0].shape}; all must be alike"
            )
    return np.array(parts, float)


READERS: dict[object, Reader] = {
    float: number,
    int: integer,
    str: partial(string, empty=True),
    bool: boolean,
    np.ndarray: array,
}


def _words(kind: Any) -> str:
    """A field's type for people."""
    known = {float: "a number", int: "a whole number", str: "a text", bool: "true or false"}
    if kind in known:
        return known[kind]
    if get_origin(kind) is tuple:
        return f"a list, each {_words(get_args(kind)[0])}"
    if isinstance(kind, type) and issubclass(kind, Trajectory):
        valid = [name for name, family in FAMILIES.items() if issubclass(family, kind)]
        return f"a trajectory of family {' or '.join(valid)}"
    return "a list of numbers" if kind is np.ndarray else re.sub(r"\s*\|\s*None", "", str(kind))
