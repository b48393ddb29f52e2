"""Text of a value as HTML for notebooks, and the import of optional packages."""

from html import escape
from importlib import import_module
from typing import Any

from .errors import MissingPackage


def counted(count: int, noun: str) -> str:
    """A number with its noun, such as "1 run" or "6 joints"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


class InNotebook:
    """Base of values that a notebook shows as text."""

    def _repr_html_(self) -> str:
        return f'<pre style="line-height: 1.35">{escape(repr(self))}</pre>'


def optional(package: str, purpose: str, extra: str = "notebook") -> Any:
    """An optional package, or a module of it, which an extra of exidyn installs.

    Raises:
        MissingPackage: It is not installed; the message names the extra.
    """
    try:
        return import_module(package)
    except ModuleNotFoundError as error:
        raise MissingPackage(
            f"{purpose} needs {package.partition('.')[0]}, which is not installed: "
            f'pip install ".[{extra}]" in the folder of exidyn'
        ) from error
