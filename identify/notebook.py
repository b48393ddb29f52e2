"""What a notebook shows of a value: its text in HTML, and optional packages that it may lack."""

from html import escape
from importlib import import_module
from typing import Any

from .errors import MissingPackage


def counted(count: int, what: str) -> str:
    """A number with its noun, such as "1 run" or "6 joints"."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


class InNotebook:
    """A value whose text is what a notebook shows."""

    def _repr_html_(self) -> str:
        return f'<pre style="line-height: 1.35">{escape(repr(self))}</pre>'


def optional(package: str, purpose: str, extra: str = "notebook") -> Any:
    """A package, or a module of it, that an extra of exidyn brings.

    Raises:
        MissingPackage: It is not installed; names the extra.
    """
    try:
        return import_module(package)
    except ModuleNotFoundError as error:
        raise MissingPackage(
            f"{purpose} needs {package.partition('.')[0]}, which is not installed: "
            f'pip install ".[{extra}]" in the folder of exidyn'
        ) from error
