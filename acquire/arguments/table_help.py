"""Help about a table of functions: each name, and what its docstring says first."""

from collections.abc import Mapping
from typing import Any


def table_help(title: str, table: Mapping[str, Any]) -> str:
    """A title, and a line each with name and first line of the docstring."""
    width = max(map(len, table))
    lines = [
        f"  {name:<{width}}  {(function.__doc__ or '').partition(chr(10))[0]}"
        for name, function in table.items()
    ]
    return "\n".join([f"{title}:", *lines])
