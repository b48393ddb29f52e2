"""Write TOML: keys, values and blocks; a float is written so that it reads back as the same float."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def block(heading: str, table: Mapping[str, Any], tall: bool = False) -> str:
    """A heading such as [drive] or [[link]], and its keys below."""
    return f"{heading}\n{lines(table, tall)}" if table else heading


def lines(table: Mapping[str, Any], tall: bool = False) -> str:
    """One line a key; where they are `tall`, matrices take one a row."""
    return "\n".join(
        f"{_key(key)} = {_rows(value) if tall and np.ndim(value) == 2 else value_text(value)}"
        for key, value in table.items()
    )


def value_text(value: Any) -> str:
    """A TOML value; `repr` of a float reads back as the same float."""
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{_key(key)} = {value_text(item)}' for key, item in value.items())} }}"
    if isinstance(value, Sequence | np.ndarray):
        return f"[{', '.join(value_text(item) for item in value)}]"
    if isinstance(value, int | np.integer):
        return str(int(value))
    return repr(float(value))


def _rows(matrix: Sequence | np.ndarray) -> str:
    return "[\n" + "".join(f"  {value_text(row)},\n" for row in matrix) + "]"


def _key(key: str) -> str:
    plain = key.isascii() and key.replace("_", "").replace("-", "").isalnum()
    return key if plain else _string(key)


def _string(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in escaped) + '"'
