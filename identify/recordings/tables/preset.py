"""Presets: names, units and signs of the columns of one kind of log, as TOML files."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from msgspec import Meta, Struct, defstruct

from ...errors import RobotError, WrongShape
from ...robot_files.toml_fields import parse_toml, read_text
from ...schema import Name, Number, Size, checked
from ...schema import check as check_field
from ..recording import EFFORT, SIGNALS
from .columns import Columns, Names

BESIDE = "preset.toml"
"""File name of a preset beside its log."""


Numbers = Number | Annotated[list[Number], Meta(min_length=1)]
"""One number for all joints, or one per joint."""


class Reading(Struct, frozen=True, forbid_unknown_fields=True):
    """Names of a signal's columns, and the meaning of their numbers.

    A value is sign * (number - zero) * scale, in the unit. Fields are one for all joints, or one per joint.
    """

    column: Name | Annotated[list[Name], Meta(min_length=1)] = ""  # by default those of usual names
    unit: str | Annotated[list[str], Meta(min_length=1)] = ""
    sign: Numbers = 1.0
    scale: Numbers = 1.0
    zero: Numbers = 0.0

    def __post_init__(self) -> None:
        expected = "1 or -1, or one of them for each joint"
        check_field(set(_each(self.sign)) <= {1.0, -1.0}, "sign", self.sign, expected)
        check_field(0.0 not in _each(self.scale), "scale", self.scale, "numbers other than 0")

    @property
    def plain(self) -> bool:
        """Whether it states only columns."""
        return self == Reading(self.column)

    def numbers(self, values: np.ndarray, where: str) -> np.ndarray:
        """Values in the unit from the numbers of a log, shape (t, n)."""
        n = values.shape[1]
        for key in ("sign", "scale", "zero"):
            if len(stated := _each(getattr(self, key))) not in (1, n):
                raise WrongShape(f"{where}: {len(stated)} values of {key} for {n} joints")
        sign, scale, zero = (np.array(_each(value)) for value in (self.sign, self.scale, self.zero))
        return np.asarray(sign * scale * (values - zero))


def _each(value: float | list[float]) -> list[float]:
    return value if isinstance(value, list) else [value]


_FILE: Any = defstruct(
    "Preset",
    [
        ("rate", Size, 0.0),
        ("still", dict[str, tuple[Number, Number]], {}),
        *((name, Reading | None, None) for name in ("time", "effort", *SIGNALS)),
    ],
    forbid_unknown_fields=True,
)


@dataclass(frozen=True)
class Preset:
    """Preset for a kind of log."""

    name: str = ""  # name of the preset, or its path
    signals: Mapping[str, Reading] = field(default_factory=dict)  # signal, "effort" or "time" -> its reading
    rate: float = 0.0  # sampling rate of logs without time [Hz]; 0 if there is a time column
    # Column of the position of a joint that the model holds -> range within which it stays.
    still: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def usual(self, signals: Iterable[str]) -> list[str]:
        """Signals whose columns may have usual names; of efforts, only those that the preset states."""
        stated = [name for name in EFFORT if name in self.signals]
        return [name for name in signals if name not in EFFORT or not stated or name in stated]

    def of_log(self, columns: Columns, chosen: Mapping[str, Names], effort: str) -> "Preset":
        """Preset for a log: "effort" is replaced by the signal `effort`.

        A built-in preset also loses the signals that the log lacks, except time and positions. `chosen` are
        columns that were named for this log.
        """
        signals = {effort if name == "effort" else name: reading for name, reading in self.signals.items()}
        if self.name in preset_names():
            signals = {
                name: reading
                for name, reading in signals.items()
                if name in ("time", "position") or columns.has(name, chosen.get(name, reading.column))
            }
        return replace(self, signals=signals)


@cache
def preset_names() -> tuple[str, ...]:
    """Names of the built-in presets."""
    files = resources.files(__package__).joinpath("presets").iterdir()
    return tuple(sorted(file.name.removesuffix(".toml") for file in files if file.name.endswith(".toml")))


def read_preset(source: str | Path) -> Preset:
    """A preset from a file, or a built-in preset by its name."""
    if str(source) in preset_names():
        text = resources.files(__package__).joinpath("presets", f"{source}.toml").read_text("utf-8")
        return parse_preset(text, str(source))
    if not Path(source).is_file():
        raise RobotError(
            f"no preset or file called '{source}'. Presets: {', '.join(preset_names())}; or give the path "
            "of a TOML file"
        )
    return parse_preset(read_text(Path(source)), str(source))


def parse_preset(text: str, where: str) -> Preset:
    """A preset from its text; `where` is its name in messages."""
    table = parse_toml(text, where)
    if not isinstance(still := table.get("still", {}), dict):
        raise RobotError(f"{where}: [still] is {still!r}; expected a table of COLUMN = [LOWEST, HIGHEST]")
    file = checked(table, _FILE, where, RobotError)
    if file.rate and file.time:
        raise RobotError(f"{where}: rate is for logs without time; give it or [time], not both")
    signals = {name: reading for name in ("time", "effort", *SIGNALS) if (reading := getattr(file, name))}
    return Preset(where, signals, file.rate, file.still)


def preset_for(source: Path, columns: Columns) -> Preset:
    """Preset in a log's folder, else the built-in one that matches its time and first joint, else empty."""
    path = (source if source.is_dir() else source.parent) / BESIDE
    if path.is_file():
        return read_preset(path)
    for preset in map(read_preset, preset_names()):
        time, position = (preset.signals[name].column for name in ("time", "position"))
        if columns.has("time", time) and columns.has("position", position, 1):
            return preset
    return Preset()
