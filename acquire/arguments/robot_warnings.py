"""Warnings about a robot's description, as a line of a command."""

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from exidyn.identify.errors import RobotWarning

from .common import complaint


@contextmanager
def warnings_as_lines() -> Iterator[None]:
    """Inside, a `RobotWarning` is a line on standard error, once a text."""
    with warnings.catch_warnings():
        as_before = warnings.showwarning

        def show(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if issubclass(category, RobotWarning):
                print(complaint(f"exidyn: warning: {message}"), file=sys.stderr)
            else:
                as_before(message, category, filename, lineno, file, line)

        warnings.showwarning = show
        yield
