"""robot.toml: everything, for exidyn itself."""

from ..robot_files.robot_text import model_text
from .portable import Portable
from .unsaid import WORDS as EVERY

WORDS = tuple(EVERY)


def toml(portable: Portable) -> str:
    """A robot file with the identified model in it, which every command takes."""
    return model_text(portable.model)
