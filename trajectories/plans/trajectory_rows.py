"""Dataclasses as tables of a file and back, by their annotations, for any family of trajectories.

A field of a family may be a number, a text, a boolean, an array of floats, a tuple of any of these, a
`Trajectory`, or a tuple of them. Integers belong in a tuple, not in an array.
"""

from collections.abc import Collection, Mapping
from dataclasses import MISSING, fields
from itertools import groupby
from typing import Any, get_type_hints

import numpy as np

from exidyn.identification.errors import RobotError
from exidyn.identification.result_file import number_or_array
from exidyn.identification.robot_files.toml_fields import block, check_keys
from exidyn.identification.schema import checked, shown

from ..errors import NotATrajectory, TrajectoryError, UnknownChoice
from ..families import FAMILIES
from ..trajectory import Trajectory

FAMILY = "family"
"""Key of the family's name."""
FEW = 5
"""Maximum number of parts of a trajectory that are named one by one."""


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


def _read_value(kind: type, value: Any) -> Any:
    """Trajectory from its table, or array of finite numbers, for `checked`.

    Raises:
        RobotError: A value is invalid for its key.
        NotATrajectory: The values form no valid trajectory.
    """
    if kind is np.ndarray:
        array = number_or_array(kind, value)
        if not np.all(np.isfinite(array)):
            raise NotATrajectory(f"expected finite numbers; found {shown(value)}")
        return array
    name = value.get(FAMILY) if isinstance(value, Mapping) else None
    if not isinstance(name, str) or name not in FAMILIES:
        reason = f"family {name!r}" if name is not None else "no key 'family'"
        raise NotATrajectory(f"{reason}; expected one of: {', '.join(sorted(FAMILIES))}")
    family: Any = FAMILIES[name]
    declared = [f.name for f in fields(family) if f.init]
    check_keys(value, (FAMILY, *declared), name)
    values = read_fields(family, value, declared)
    try:
        return family(**values)
    except TrajectoryError:
        raise
    except (ArithmeticError, IndexError, TypeError, ValueError) as error:
        raise NotATrajectory(f"these values form no valid {name}: {error}") from error


def read_fields(kind: type, table: Mapping[str, Any], names: Collection[str]) -> dict[str, Any]:
    """Some fields of a dataclass from a table; those with a default may be missing.

    Raises:
        RobotError: A value is invalid for its key.
        NotATrajectory: A key is missing.
    """
    hints, values = get_type_hints(kind, include_extras=True), {}
    for f in fields(kind):
        if f.name in table and f.name in names:
            values[f.name] = checked(table[f.name], hints[f.name], f.name, RobotError, _read_value)
        elif f.name in names and f.default is MISSING and f.default_factory is MISSING:
            raise NotATrajectory(f"key '{f.name}' is missing; was the file cut off?")
    return values


def _family_of(trajectory: Trajectory) -> str:
    for name, kind in FAMILIES.items():
        if kind is type(trajectory):
            return name
    raise UnknownChoice("family of trajectories", type(trajectory).__name__, FAMILIES)


def _values(trajectory: Any) -> dict[str, Any]:
    return {f.name: getattr(trajectory, f.name) for f in fields(trajectory) if f.init}


def _parts(value: object) -> tuple[Trajectory, ...]:
    """Trajectories that a field contains; empty if it contains something else."""
    if isinstance(value, Trajectory):
        return (value,)
    return value if isinstance(value, tuple) and value and isinstance(value[0], Trajectory) else ()
