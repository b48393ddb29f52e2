"""Export of a model to simulator formats, with a list of what each format cannot represent."""

from collections.abc import Callable
from typing import NamedTuple

from .left_out import FEATURES, left_out
from .mjcf import FEATURES as OF_MJCF
from .mjcf import mjcf
from .portable import Portable
from .texts import IN_URDF, NOT_IN_TOML, json, toml, urdf


class Format(NamedTuple):
    """An export format."""

    text: Callable[[Portable], str]  # function that returns the content of the file
    features: tuple[str, ...]  # `FEATURES` that the format can represent
    ending: str  # extension of the file

    def leaves_out(self, portable: Portable) -> list[str]:
        """One sentence for each part of the model that the format cannot represent."""
        return left_out(portable, self.features)


OF_TOML = tuple(feature for feature in FEATURES if feature not in NOT_IN_TOML)

FORMATS: dict[str, Format] = {
    "urdf": Format(urdf, IN_URDF, ".urdf"),
    "mjcf": Format(mjcf, OF_MJCF, ".xml"),
    "json": Format(json, tuple(FEATURES), ".json"),
    "toml": Format(toml, OF_TOML, ".toml"),
}
"""Name -> format; the first line of each function's docstring states the content of the file."""

__all__ = ["FORMATS", "Format", "Portable"]
