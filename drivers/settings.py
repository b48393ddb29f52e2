"""Settings of a driver: a frozen dataclass whose fields state their meaning, read from a TOML table."""

from collections.abc import Mapping
from dataclasses import MISSING, Field, dataclass, field, fields
from textwrap import wrap
from typing import Any, get_args, get_origin, get_type_hints

import msgspec

from exidyn.quoting import double_quoted

from .errors import BadSettings, listed

FARTHEST = 1e9
"""Default limit of the magnitude of a number: radians, counts, baud and nanoseconds stay below it."""
WIDTH = 80
"""Width of a comment [columns], which every terminal can show."""
_NAMES = {int: "a whole number", float: "a number", str: "a text", bool: "true or false"}


@dataclass(frozen=True)
class About:
    """Meaning of a setting in one line, its unit, bounds of a number, and valid values."""

    text: str
    unit: str = ""
    low: float = -FARTHEST
    high: float = FARTHEST
    choices: tuple[Any, ...] = ()


def setting(default: Any, text: str, **about: Any) -> Any:
    """Declare a field of a driver's settings; `...` as default makes it required.

    `about` are fields of `About`. A field of type `tuple[T, ...]` has a value for each joint; a single value
    is then used for all joints.
    """
    metadata = {"about": About(text, **about)}
    return field(metadata=metadata) if default is ... else field(default=default, metadata=metadata)


def read_settings(cls: type[Any], table: Mapping[str, Any], joints: int, where: str) -> Any:
    """Read a driver's settings for n joints from a table, which messages call `where`.

    Raises BadSettings for an unknown name, an invalid value, or a missing one.
    """
    known, kinds = {f.name: f for f in fields(cls)}, get_type_hints(cls)
    unknown = next((name for name in table if name not in known), None)
    if unknown is not None:
        raise BadSettings(
            f"{where}: unknown setting '{unknown}'. Valid: {listed(known, unknown)}; see exidyn init --driver"
        )
    missing = [f"{n} ({_about(f).text})" for n, f in known.items() if f.default is MISSING and n not in table]
    if missing:
        raise BadSettings(f"{where}: missing {', '.join(missing)}")
    values = {}
    for name, f in known.items():
        value, kind, place = table.get(name, f.default), kinds[name], f"{where}: {name}"
        if _is_per_joint(kind):
            many = list(value) if isinstance(value, list | tuple) else [value] * joints
            if len(many) != joints:
                raise BadSettings(f"{place} has {len(many)} entries, the arm {joints} joints")
            checked = (
                _checked(_about(f), get_args(kind)[0], entry, f"{place}[{k}]") for k, entry in enumerate(many)
            )
            values[name] = tuple(checked)
        else:
            values[name] = _checked(_about(f), kind, value, place)
    return cls(**values)


def listed_joints(cls: type[Any], table: Mapping[str, Any]) -> int:
    """Length of the first setting that the table lists joint by joint; 0 if there is none."""
    lists = (table.get(name) for name, kind in get_type_hints(cls).items() if _is_per_joint(kind))
    return next((len(entries) for entries in lists if isinstance(entries, list | tuple)), 0)


def _about(f: Field[Any]) -> About:
    about: About = f.metadata["about"]
    return about


def _is_per_joint(kind: Any) -> bool:
    return get_origin(kind) is tuple


def _checked(about: About, kind: type[Any], value: Any, where: str) -> Any:
    try:
        value = msgspec.convert(value, kind)
    except msgspec.ValidationError:
        raise BadSettings(f"{where} is {value!r}; expected {_NAMES[kind]}: {about.text}") from None
    if kind in (int, float) and not about.low <= value <= about.high:
        unit = f" {about.unit}" if about.unit else ""
        raise BadSettings(f"{where} is {value:g}{unit}; valid are {about.low:g} to {about.high:g}")
    if about.choices and value not in about.choices:
        raise BadSettings(f"{where} is {value!r}. Valid: {', '.join(map(str, about.choices))}")
    return value


def template(cls: type[Any]) -> str:
    """TOML table of all settings with defaults and explanations; required settings are left empty."""
    lines, kinds = [], get_type_hints(cls)
    for f in sorted(fields(cls), key=lambda f: f.default is not MISSING):  # required settings come first
        about, required = _about(f), f.default is MISSING
        facts = [about.text]
        facts += [f"[{about.unit}]"] if about.unit else []
        facts += ["a value, or a list with one a joint"] if _is_per_joint(kinds[f.name]) else []
        facts += [f"one of {', '.join(map(str, about.choices))}"] if about.choices else []
        facts += ["required"] if required else []
        words = "; ".join(facts)
        lines += wrap(words, WIDTH, initial_indent="# ", subsequent_indent="# ", break_on_hyphens=False)
        lines.append(f"# {f.name} =" if required else f"{f.name} = {_toml(f.default)}")
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return double_quoted(value) if isinstance(value, str) else repr(value)
