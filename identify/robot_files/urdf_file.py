"""Files that hold a URDF, or the xacro macros that make one."""

from pathlib import Path

from ..errors import BrokenTree
from ..notebook import optional
from .toml_fields import read_text

XACRO = ".xacro"
ENDINGS = (".urdf", XACRO)


def read_urdf(path: Path) -> str:
    """Text of a URDF; macros are expanded, with the defaults of their arguments, by the package xacro.

    Raises:
        RobotError: The file cannot be read.
        BrokenTree: The macros cannot be expanded.
        MissingPackage: xacro is not installed.
    """
    text = read_text(path)
    if path.suffix.lower() != XACRO:
        return text
    xacro = optional("xacro", f"{path.name}, a file of macros,", "xacro")
    try:
        return xacro.process_file(str(path)).toxml()
    except Exception as error:  # its expressions are Python's, and raise whatever that does
        raise BrokenTree(
            f"{path}: xacro: {error}. Where it needs arguments or ROS packages, expand it where these are: "
            f"xacro {path.name} NAME:=VALUE > arm.urdf"
        ) from error
