"""Errors of the libraries that read other people's formats."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ...errors import ExidynError, NotAFile


@contextmanager
def refused_as(source: Path, form: str) -> Iterator[None]:
    """Whatever a library raises of a damaged file, as `NotAFile`; they raise many kinds of errors."""
    try:
        yield
    except ExidynError:
        raise
    except Exception as error:
        raise NotAFile(f"{source} cannot be read as {form}: {error}") from error
