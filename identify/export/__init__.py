"""Export: a model for the simulators that people use, and what each format cannot represent."""

from collections.abc import Callable
from typing import NamedTuple

from .left_out import FEATURES, left_out
from .mjcf import FEATURES as OF_MJCF
from .mjcf import mjcf
from .portable import Portable
from .texts import json, toml, urdf


class Format(NamedTuple):
    """How a model is written.

    Attributes:
        text: The file's content.
        features: What the format can represent, of the keys of `left_out.FEATURES`.
        ending: Of the file's name.
    """

    text: Callable[[Portable], str]
    features: tuple[str, ...]
    ending: str

    def leaves_out(self, portable: Portable) -> list[str]:
        """What it cannot represent, a sentence each."""
        return left_out(portable, self.features)


FORMATS: dict[str, Format] = {
    "urdf": Format(urdf, ("damping", "dry"), ".urdf"),
    "mjcf": Format(mjcf, OF_MJCF, ".xml"),
    "json": Format(json, tuple(FEATURES), ".json"),
    "toml": Format(toml, tuple(FEATURES), ".toml"),
}
"""Name -> how; the first line of each function's docstring states what is in the file."""

__all__ = ["FORMATS", "Format", "Portable"]
