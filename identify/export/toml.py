"""robot.toml: everything, for exidyn itself."""

from ..robot_files.robot_text import model_text
from .left_out import FEATURES as EVERY
from .portable import Portable

FEATURES = tuple(EVERY)


def toml(portable: Portable) -> str:
    """A robot file with the identified model in it, which every command takes."""
    return model_text(portable.model)
