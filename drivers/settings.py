"""Settings of a driver: a frozen dataclass whose fields state their meaning, read from a TOML table."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from textwrap import wrap
from typing import Any

from .errors import BadSettings, listed

FARTHEST = 1e9
"""Size of a number where no closer limit is given: radians, counts, baud and nanoseconds stay below it."""
WIDTH = 80
"""Columns of a comment: what every terminal shows."""


@dataclass(frozen=True)
class About:
    """What a setting means.

    Attributes:
        text: In a line.
        unit: Of the number, if it has one.
        low: Smallest valid number.
        high: Largest valid number.
        choices: Valid values.
        per_joint: Whether there is one for each joint; a single value is then taken for all.
    """

    text: str
    unit: str = ""
    low: float = -FARTHEST
    high: float = FARTHEST
    choices: tuple[Any, ...] = ()
    per_joint: bool = False


def setting(default: Any, text: str, **about: Any) -> Any:
    """Declare a field of a driver's settings; `...` as default makes it required. `about` as in `About`.

    The type of the value is the type of the default, or for a required one that of `kind`.
    """
    kind = about.pop("kind", type(default))
    metadata = {"about": About(text, **about), "kind": kind}
    return field(metadata=metadata) if default is ... else field(default=default, metadata=metadata)


def joint_setting(default: Any, text: str, **about: Any) -> Any:
    """As `setting`, one for each joint."""
    return setting(default, text, per_joint=True, **about)


def read_settings(cls: type[Any], table: Mapping[str, Any], joints: int, where: str) -> Any:
    """An instance of a driver's settings.

    Args:
        cls: The driver's `Settings`.
        table: Name -> value.
        joints: Number of joints n; settings that are `per_joint` become tuples of that length.
        where: What to call the table in messages.

    Raises:
        BadSettings: An unknown name, a value that cannot be, or one that is missing.
    """
    known = {f.name: f for f in fields(cls)}
    unknown = [name for name in table if name not in known]
    if unknown:
        raise BadSettings(
            f"{where}: unknown setting '{unknown[0]}'. Valid: {listed(known, unknown[0])}; see exidyn drivers"
        )
    missing = [n for n, f in known.items() if f.default is MISSING and n not in table]
    if missing:
        texts = ", ".join(f"{name} ({known[name].metadata['about'].text})" for name in missing)
        raise BadSettings(f"{where}: missing {texts}")
    values = {n: table[n] if n in table else f.default for n, f in known.items()}
    return cls(**{n: _value(known[n].metadata, v, joints, f"{where}: {n}") for n, v in values.items()})


def listed_joints(cls: type[Any], table: Mapping[str, Any]) -> int:
    """Length of the first setting that is given as a list with one entry a joint; 0 if none is."""
    lists = (table.get(f.name) for f in fields(cls) if f.metadata["about"].per_joint)
    return next((len(one) for one in lists if isinstance(one, list | tuple)), 0)


def _value(metadata: Mapping[str, Any], value: Any, joints: int, where: str) -> Any:
    about: About = metadata["about"]
    if not about.per_joint:
        return _one(metadata, value, where)
    many = list(value) if isinstance(value, list | tuple) else [value] * joints
    if len(many) != joints:
        raise BadSettings(f"{where} has {len(many)} entries, the arm {joints} joints")
    return tuple(_one(metadata, one, f"{where}[{place}]") for place, one in enumerate(many))


def _one(metadata: Mapping[str, Any], value: Any, where: str) -> Any:
    about, kind = metadata["about"], metadata["kind"]
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if not isinstance(value, kind) or (kind is not bool and isinstance(value, bool)):
        raise BadSettings(f"{where} is {value!r}; expected {_NAMES[kind]}: {about.text}")
    if kind in (int, float) and not about.low <= value <= about.high:
        unit = f" {about.unit}" if about.unit else ""
        raise BadSettings(f"{where} is {value:g}{unit}; valid are {about.low:g} to {about.high:g}")
    if about.choices and value not in about.choices:
        raise BadSettings(f"{where} is {value!r}. Valid: {', '.join(map(str, about.choices))}")
    return value


_NAMES = {int: "a whole number", float: "a number", str: "a text", bool: "true or false"}


def template(cls: type[Any]) -> str:
    """The settings as a TOML table with their defaults, each explained; required ones are left empty."""
    lines = []
    for f in fields(cls):
        about: About = f.metadata["about"]
        facts = [
            about.text,
            f"[{about.unit}]" if about.unit else "",
            "a value, or a list with one a joint" * about.per_joint,
        ]
        facts += [f"one of {', '.join(map(str, about.choices))}"] if about.choices else []
        required = f.default is MISSING
        words = "; ".join(filter(None, [*facts, "required" * required]))
        lines += wrap(words, WIDTH, initial_indent="# ", subsequent_indent="# ", break_on_hyphens=False)
        lines.append(f"# {f.name} =" if required else f"{f.name} = {_toml(f.default)}")
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else repr(value)
