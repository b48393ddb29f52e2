"""The controller and its settings, from a file and from the command line."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from exidyn.drivers.errors import BadSettings
from exidyn.identification.errors import RobotError
from exidyn.identification.robot_files.toml_fields import parse_toml

from .command import Option

CONTROLLER = (
    Option("--driver DRIVER", "default: the driver of the controller file, or mock"),
    Option("--controller FILE", "driver and settings (.toml), as 'exidyn init --driver DRIVER' prints", Path),
    Option("--set NAME=VALUE", "one setting, overrides the file; may be repeated", str, [], repeated=True),
)
KEYS = {"driver": (str, 'a text, such as driver = "mock"'), "settings": (dict, "a table, [settings]")}
"""Key of a controller file -> its type, and a description of the type."""


def read_controller(
    path: Path | None, name: str | None, assignments: Sequence[str]
) -> tuple[str, dict[str, Any]]:
    """Name and settings of a driver.

    Args:
        path: Controller file, or None.
        name: Driver of the command line, or None; without a name in the file either, it is the mock.
        assignments: "name=value" texts of the command line, which override the file.

    Raises:
        BadSettings: If the file is not a controller file, or an assignment is not of the form name=value.
    """
    table = _file(path) if path else {}
    file_driver = table.get("driver", "")
    if name and file_driver and name != file_driver:
        raise BadSettings(f"--driver {name}, but {path} is for {file_driver}. Omit one of them")
    settings = dict(table.get("settings", {}))
    for text in assignments:
        key, equals, value = text.partition("=")
        if not equals:
            raise BadSettings(f"--set {text}: expected NAME=VALUE, such as --set cycle=0.004")
        settings[key.strip()] = _value(value.strip())
    return name or file_driver or "mock", settings


def _file(path: Path) -> Mapping[str, Any]:
    try:
        table = parse_toml(path.read_text(encoding="utf-8"), "not a controller file")
    except (UnicodeDecodeError, RobotError) as error:
        raise BadSettings(f"{path}: {error}") from error
    unknown = [key for key in table if key not in KEYS]
    if unknown:
        raise BadSettings(
            f"{path}: unknown key '{unknown[0]}'. Valid: {', '.join(KEYS)}; all settings of a driver are "
            "below [settings]"
        )
    for key, (kind, form) in KEYS.items():
        if not isinstance(table.get(key, kind()), kind):
            raise BadSettings(f"{path}: {key} is {table[key]!r}; expected {form}")
    return table


def _value(text: str) -> Any:
    """The TOML value of a text, or the text itself if it is not a TOML value."""
    try:
        return parse_toml(f"value = {text}", "--set")["value"]
    except RobotError:
        return text
