"""Read values from a parsed TOML table, and write TOML.

A wrong value is a `RobotError`, which names the key, the value and what is valid.
"""

import re
import tomllib
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.quoting import double_quoted

from ..errors import RobotError, UnknownKey
from ..file_names import read_failure
from ..schema import LARGEST

WHOLE = 2**63
"""Whole numbers of TOML are below this, and at least its negative."""
DEEPEST = 30
"""Maximum depth of a dotted key. Valid files need three; with thousands the parser takes minutes."""
DOTTED = re.compile(rf"(?<![\w-])(?:[\w-]++[ \t]*+\.[ \t]*+){{{DEEPEST}}}")


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Table of a TOML text."""
    if DOTTED.search(text):
        raise RobotError(f"{where}: not valid TOML: a key of more than {DEEPEST} tables")
    try:
        table = tomllib.loads(text)
    except RecursionError:
        raise RobotError(f"{where}: not valid TOML: lists or tables nested too deeply") from None
    except ValueError as error:  # not a TOMLDecodeError for numbers with thousands of digits
        raise RobotError(f"{where}: not TOML: {error}") from error
    _check_whole_numbers(table, where)
    return table


def _check_whole_numbers(value: object, where: str) -> None:
    """Refuse whole numbers of more than 64 bits, which Python's parser accepts but floats cannot hold."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            _check_whole_numbers(item, f"{where}: {key}")
    elif isinstance(value, list):
        for place, item in enumerate(value):
            _check_whole_numbers(item, f"{where}[{place}]")
    elif isinstance(value, int) and not -WHOLE <= value < WHOLE:
        raise RobotError(f"{where}: a whole number of more than 64 bits; expected -2^63 to 2^63 - 1")


def read_text(path: Path) -> str:
    """Text of a file."""
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise RobotError(f"{path}: not a text file (UTF-8); give a robot.toml or a .urdf") from error
    except OSError as error:
        raise RobotError(f"{path}: cannot be read: {read_failure(path, error)}") from error


def check_keys(table: object, valid: Collection[str], where: str) -> None:
    """Refuse what is not a table, and a table with unknown keys, by an `UnknownKey`."""
    if not isinstance(table, Mapping):
        raise RobotError(f"{where}: expected a table with keys {', '.join(valid)}; found {table!r}")
    for key in table:
        if key not in valid:
            raise UnknownKey(key, where, list(valid))


def string(value: object, where: str) -> str:
    """A text that is not empty."""
    if not isinstance(value, str) or not value:
        raise RobotError(f"{where}: expected a text in quotes; found {value!r}")
    if "\0" in value:
        raise RobotError(f"{where}: {value!r} has a character of code 0, which names and paths cannot have")
    return value


def strings(value: object, where: str) -> list[str]:
    """A list of at least one text, without repetition."""
    if not isinstance(value, list) or not value or len({str(item) for item in value}) < len(value):
        raise RobotError(f"{where}: expected a list of different texts; found {value!r}")
    return [string(item, f"{where}[{place}]") for place, item in enumerate(value)]


def boolean(value: object, where: str) -> bool:
    """True or false."""
    if not isinstance(value, bool):
        raise RobotError(f"{where}: expected true or false; found {value!r}")
    return value


def number(value: object, where: str, low: float = -np.inf, infinite: bool = False) -> float:
    """A number of at least `low`, finite unless `infinite` is allowed."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise RobotError(f"{where}: expected a number; found {value!r}")
    if np.isnan(value) or (np.isinf(value) and not infinite):
        raise RobotError(f"{where}: expected a {'' if infinite else 'finite '}number; found {value}")
    if value < low:
        raise RobotError(f"{where}: {value} is less than {low:g}")
    if LARGEST < abs(value) < np.inf:
        raise RobotError(f"{where}: {value} is too large; the magnitude is at most {LARGEST:g}")
    return float(value)


def numbers(
    value: object, count: int, where: str, low: float = -np.inf, infinite: bool = False
) -> np.ndarray:
    """A list of `count` numbers, or a single number for all of them, shape (count,)."""
    if not isinstance(value, list | tuple):
        return np.full(count, number(value, where, low, infinite))
    if len(value) != count:
        raise RobotError(f"{where}: {len(value)} values, expected {count}")
    checked = [number(item, f"{where}[{place}]", low, infinite) for place, item in enumerate(value)]
    return np.array(checked, float)


def matrix(value: object, count: int, where: str) -> np.ndarray:
    """A list of `count` rows of `count` numbers, shape (count, count)."""
    if not isinstance(value, list | tuple) or len(value) != count:
        raise RobotError(f"{where}: expected {count} rows of {count} numbers; found {value!r}")
    return np.array([numbers(row, count, f"{where}[{place}]") for place, row in enumerate(value)])


def tables(value: object, where: str) -> list[Mapping[str, Any]]:
    """A list of at least one table, from rows `[[where]]`."""
    if not isinstance(value, list) or not value or not all(isinstance(row, Mapping) for row in value):
        raise RobotError(f"{where}: expected rows headed [[{where}]]; found {value!r}")
    return value


def rows(table: Mapping[str, Any], key: str) -> list[Mapping[str, Any]]:
    """Rows `[[key]]` of a table; none if it lacks the key or states an empty list."""
    return tables(table[key], key) if table.get(key, []) != [] else []


def block(heading: str, table: Mapping[str, Any], tall: bool = False) -> str:
    """A heading such as [drive] or [[link]], followed by its keys."""
    return f"{heading}\n{lines(table, tall)}" if table else heading


def lines(table: Mapping[str, Any], tall: bool = False) -> str:
    """One line per key; with `tall`, matrices take one line per row."""
    texts = []
    for key, value in table.items():
        text = _value_text(value)
        if tall and np.ndim(value) == 2:
            text = "[\n" + "".join(f"  {_value_text(row)},\n" for row in value) + "]"
        texts.append(f"{_key(key)} = {text}")
    return "\n".join(texts)


def _value_text(value: Any) -> str:
    """A TOML value; `repr` of a float reads back as the same float."""
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, str):
        return double_quoted(value)
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{_key(key)} = {_value_text(item)}' for key, item in value.items())} }}"
    if isinstance(value, Sequence | np.ndarray):
        return f"[{', '.join(_value_text(item) for item in value)}]"
    if isinstance(value, int | np.integer):
        return str(int(value))
    return repr(float(value))


def _key(key: str) -> str:
    plain = key.isascii() and key.replace("_", "").replace("-", "").isalnum()
    return key if plain else double_quoted(key)
