"""Forms in which controllers and simulators take a payload: one function each, `Body` to text.

All refer to the flange frame of the arm's description, which has to be that of the controller: the frame in
which the controller expects loads, with the same origin and axes.
"""

from collections.abc import Callable

from ..body import Body
from .abb import abb
from .franka import franka
from .kuka import kuka
from .mjcf import mjcf
from .universal_robots import universal_robots
from .urdf import urdf

FORMATS: dict[str, Callable[[Body], str]] = {
    "ur": universal_robots,
    "franka": franka,
    "kuka": kuka,
    "abb": abb,
    "urdf": urdf,
    "mjcf": mjcf,
}
"""Name -> function; the first line of its docstring states what it writes."""

__all__ = ["FORMATS"]
