"""Presets: what the columns of one kind of log are called, their units and signs, as a TOML file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

from ....errors import RobotError
from ....robot_files.toml_fields import check_keys, number, numbers, parse_toml, read_text, string
from ...recording import SIGNALS
from .columns import Columns, Names

BESIDE = "preset.toml"
"""Name under which a log's own preset is found beside it."""


class Reading(NamedTuple):
    """How one signal is read: what its columns are called, their unit and their sign, one of each a joint."""

    column: Names
    unit: Names = ""
    sign: Sequence[float] = (1.0,)


@dataclass(frozen=True)
class Preset:
    """How a kind of log is read.

    Attributes:
        name: Of the preset, or its path.
        signals: Signal, "effort" or "time" -> how it is read.
        rate: Samples a second, of logs without time; 0 with a column of time [Hz].
        still: Column of the position of a joint that the model holds -> between what it stays.
    """

    name: str = ""
    signals: Mapping[str, Reading] = field(default_factory=dict)
    rate: float = 0.0
    still: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def naming(self, effort: str) -> "Preset":
        """The same where "effort" is that signal, torque or current."""
        return replace(
            self, signals={effort if name == "effort" else name: one for name, one in self.signals.items()}
        )

    @property
    def columns(self) -> dict[str, Names]:
        """Names of the columns by signal."""
        return {name: one.column for name, one in self.signals.items()}

    def without_missing(self, columns: Columns) -> "Preset":
        """The same without the signals that a log lacks; time and positions are always needed."""
        kept = {n: one for n, one in self.signals.items() if n in ("time", "position") or columns.has(n)}
        return replace(self, signals=kept)


def preset_names() -> list[str]:
    """Names of the presets that come with exidyn."""
    files = resources.files(__package__).joinpath("presets").iterdir()
    return sorted(file.name.removesuffix(".toml") for file in files if file.name.endswith(".toml"))


def read_preset(source: str | Path) -> Preset:
    """A preset from a file, or by the name of one that comes with exidyn.

    Raises:
        RobotError: There is no such preset or file, or it is wrong; the message names the valid keys.
    """
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
    """A preset from its text; `where` is what errors call it.

    Raises:
        RobotError: The text is wrong; the message names the key, what was found and what is valid.
    """
    table = parse_toml(text, where)
    check_keys(table, ("rate", "time", "effort", "still", *SIGNALS), where)
    if "rate" in table and "time" in table:
        raise RobotError(f"{where}: rate is for logs without time; give it or [time], not both")
    rate = number(table.pop("rate", 0.0), f"{where}: rate", 0.0)
    still = _ranges(table.pop("still", {}), f"{where}: [still]")
    signals = {name: _reading(keys, f"{where}: [{name}]") for name, keys in table.items()}
    return Preset(where, signals, rate, still)


def _ranges(table: Any, where: str) -> dict[str, tuple[float, float]]:
    if not isinstance(table, dict):
        raise RobotError(f"{where} is {table!r}; expected a table of COLUMN = [LOWEST, HIGHEST]")
    found = {column: numbers(value, 2, f"{where} {column}").tolist() for column, value in table.items()}
    return {column: (low, high) for column, (low, high) in found.items()}


def _reading(table: Any, where: str) -> Reading:
    check_keys(table, Reading._fields, where)
    if "column" not in table:
        raise RobotError(f"{where}: key 'column' is missing; it names a column, or one a joint")
    given = table.get("sign", 1.0)
    signs = [number(one, f"{where} sign") for one in (given if isinstance(given, list) else [given])]
    if not signs or not set(signs) <= {1.0, -1.0}:
        raise RobotError(f"{where} sign: {given}; expected 1 or -1, or one of them for each joint")
    column, unit = (_texts(table.get(key, ""), f"{where} {key}", key == "unit") for key in ("column", "unit"))
    return Reading(column, unit, signs)


def _texts(value: Any, where: str, empty: bool) -> Names:
    """A text, or one a joint."""
    if isinstance(value, list):
        if not value:
            raise RobotError(f"{where}: an empty list; expected a text, or one for each joint")
        return [string(one, where) for one in value]
    return string(value, where, empty)


def preset_beside(source: Path) -> Preset | None:
    """The preset in a log's folder, if there is one.

    Raises:
        RobotError: It is wrong.
    """
    path = (source if source.is_dir() else source.parent) / BESIDE
    return read_preset(path) if path.is_file() else None


def preset_like(look: Callable[..., Columns]) -> Preset:
    """The preset that comes with exidyn and has a table's time and first joint; else that of usual names.

    Args:
        look: Looks up columns of the table, as `Columns` does behind its first arguments.
    """
    for name in preset_names():
        preset = read_preset(name)
        columns = look(preset=preset.columns)
        if columns.has("time") and columns.has("position", 1):
            return preset
    return Preset()
