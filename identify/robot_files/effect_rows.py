"""Rows `[[effect]]`, `[[measurement]]` and `[[finding]]` of a robot file; their keys are fields of types."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, Field, fields
from typing import Any, TypeVar, get_type_hints

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict

from ..arm.robot import Robot
from ..effects import EFFECTS, Effect, Prior, load_installed
from ..errors import ExidynError, RobotError, UnknownJoint, listed
from ..measurements import MEASUREMENTS, Measurement
from ..schema import Name, Probability, checked
from .toml_fields import block, boolean, check_keys, number, numbers, string

EFFECT_KEYS = ("name", "values", "tolerance", "std")
"""Keys of an effect's row that are not fields of the effect."""
FIELD_KEYS = {"name": "label"}
"""Field of an effect -> its key, if a key with the name of the field already has another meaning."""
JOINT_FIELDS = ("joint", "other", "joints")
"""Fields that hold joint names."""
Kind = TypeVar("Kind", Effect, Measurement)
FINDING = "finding"
"""Rows that a diagnosis writes: what it found, and whether the model holds it."""
SCALARS: dict[object, Callable[[object, str], Any]] = {
    float: number,
    str: string,
    bool: boolean,
    float | None: number,
}


def key_of(field: "Field[Any]") -> str:
    """Key of a field of an effect in its row."""
    return FIELD_KEYS.get(field.name, field.name)


def read_effects(
    rows: Iterable[Mapping[str, Any]], robot: Robot
) -> tuple[tuple[Effect, ...], dict[str, Prior]]:
    """Effects of the rows, and the priors in the rows."""
    load_installed()
    effects: list[Effect] = []
    stated: dict[str, Prior] = {}
    for row in rows:
        effect, names = _effect(row, robot)
        effects.append(effect)
        stated |= _priors(row, names)
    return tuple(effects), stated


def read_priors(table: Mapping[str, Any], names: Sequence[str]) -> dict[str, Prior]:
    """Priors of the table `[prior]`: parameter = value, or [value, standard deviation]."""
    check_keys(table, names, "[prior]")
    priors = {}
    for name, entry in table.items():
        pair = entry if isinstance(entry, list) else [entry, np.inf]
        value, std = numbers(pair, 2, f"[prior] {name}", infinite=True)
        number(float(std), f"[prior] {name} standard deviation", 0.0, infinite=True)
        priors[name] = Prior(float(value), float(std))
    return priors


def read_measurements(rows: Iterable[Mapping[str, Any]], robot: Robot) -> tuple[Measurement, ...]:
    """Measurements of the rows."""
    return tuple(_made(row, "measurement", MEASUREMENTS, ("name",), robot) for row in rows)


def _effect(row: Mapping[str, Any], robot: Robot) -> tuple[Effect, list[str]]:
    """Effect of a row, and the names of its parameters."""
    effect = _made(row, "effect", EFFECTS, EFFECT_KEYS, robot)
    try:
        return effect, [parameter.name for parameter in effect.parameters(robot)]
    except ExidynError:
        raise
    except (TypeError, ValueError, LookupError) as error:
        raise RobotError(f"effect {row['name']}: {error}") from error


def _made(
    row: Mapping[str, Any], table: str, kinds: Mapping[str, type[Kind]], more: Sequence[str], robot: Robot
) -> Kind:
    """Object of the kind that a row names, with the row's fields; `more` are keys that are not fields."""
    name = string(row.get("name"), f"[[{table}]] name")
    if name not in kinds:
        raise RobotError(
            f"[[{table}]]: there is no {table} '{name}'. {table.capitalize()}s: "
            f"{listed(sorted(kinds), name)} (docs/effects.md)"
        )
    kind, where = kinds[name], f"{table} {name}"
    known: dict[str, Field[Any]] = {key_of(f): f for f in fields(kind)}
    check_keys(row, (*more, *known), where)
    absent = [
        key
        for key, f in known.items()
        if key not in row and f.default is MISSING and f.default_factory is MISSING
    ]
    if absent:
        raise RobotError(f"{where}: needs {', '.join(absent)}")
    _refuse_numbers(row, robot, where)
    hints = get_type_hints(kind)
    arguments = {
        f.name: _field_value(row[key], hints[f.name], f"{where} {key}")
        for key, f in known.items()
        if key in row
    }
    try:
        return kind(**arguments)
    except ExidynError:
        raise
    except (TypeError, ValueError, LookupError) as error:
        raise RobotError(f"{where}: {arguments}: {error}") from error


def _refuse_numbers(row: Mapping[str, Any], robot: Robot, where: str) -> None:
    """Refuse joint numbers, which leave open whether the first joint is 0 or 1."""
    for key in JOINT_FIELDS:
        entry = row.get(key)
        for joint in entry if isinstance(entry, list) else [entry]:
            if isinstance(joint, int | float):
                raise UnknownJoint(joint, f"{where} {key}:", robot.joints)


def _field_value(value: object, hint: object, where: str) -> Any:
    """Value of a field; lists become tuples, so that effects are hashable."""
    read = SCALARS.get(hint)
    if read is not None:
        return read(value, where)
    if "tuple" in str(hint) and not isinstance(value, list):
        raise RobotError(f"{where}: expected a list; found {value!r}")
    return _tuples(value)


def _tuples(value: Any) -> Any:
    return tuple(_tuples(item) for item in value) if isinstance(value, list) else value


def _priors(row: Mapping[str, Any], names: Sequence[str]) -> dict[str, Prior]:
    """Prior of each parameter; its std is `std`, else `tolerance` times |value|, else infinite."""
    where = f"effect {row['name']}"
    if "values" not in row:
        if "std" in row or "tolerance" in row:
            raise RobotError(f"{where}: a tolerance or std needs values ({', '.join(names)})")
        return {}
    if "std" in row and "tolerance" in row:
        raise RobotError(f"{where}: tolerance and std state the same; give one of them")
    values = numbers(row["values"], len(names), f"{where} values ({', '.join(names)})")
    std = np.full(len(names), np.inf)
    if "tolerance" in row:
        std = numbers(row["tolerance"], len(names), f"{where} tolerance", 0.0) * np.abs(values)
    if "std" in row:
        std = numbers(row["std"], len(names), f"{where} std", 0.0, infinite=True)
    return {n: Prior(float(v), float(s)) for n, v, s in zip(names, values, std, strict=True)}


class FindingRow(Struct, frozen=True, forbid_unknown_fields=True):
    """One finding."""

    effect: Name  # name in the vocabulary
    joints: tuple[Name, ...]  # names of the joints on which it acts; empty for the whole arm
    probability: Probability  # probability that the missing physics is this effect
    in_model: bool  # whether the model of the file holds it


def findings_text(rows: Sequence[FindingRow]) -> str:
    """A table [[finding]] for each."""
    return "\n".join(block(f"[[{FINDING}]]", asdict(row)) + "\n" for row in rows)


def parse_findings(table: dict[str, Any]) -> list[FindingRow]:
    """The findings of a parsed robot.toml; none in a file that no diagnosis wrote."""
    return checked(table.get(FINDING, []), list[FindingRow], f"[[{FINDING}]]", RobotError)
