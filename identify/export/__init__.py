"""Export: a model for the simulators that people use, and what each format has no words for."""

from collections.abc import Callable
from typing import NamedTuple

from . import json, mjcf, toml, urdf
from .portable import Portable
from .unsaid import unsaid


class Format(NamedTuple):
    """How a model is written.

    Attributes:
        text: The file's content.
        words: What the format can say, of the keys of `unsaid.WORDS`.
        ending: Of the file's name.
    """

    text: Callable[[Portable], str]
    words: tuple[str, ...]
    ending: str

    def leaves_out(self, portable: Portable) -> list[str]:
        """What it has no words for, a sentence each."""
        return unsaid(portable, self.words)


FORMATS: dict[str, Format] = {
    "urdf": Format(urdf.urdf, urdf.WORDS, ".urdf"),
    "mjcf": Format(mjcf.mjcf, mjcf.WORDS, ".xml"),
    "json": Format(json.json, json.WORDS, ".json"),
    "toml": Format(toml.toml, toml.WORDS, ".toml"),
}
"""Name -> how; the first line of each function's docstring says what is in the file."""

__all__ = ["FORMATS", "Format", "Portable"]
