"""Table of the trajectory families that a file can contain; each family has its own module."""

from ..trajectory import Trajectory
from .chirp import Chirp
from .fourier import Fourier
from .phases import Phases
from .sequence import Sequence

FAMILIES: dict[str, type[Trajectory]] = {
    "chirp": Chirp,
    "fourier": Fourier,
    "phases": Phases,
    "sequence": Sequence,
}
"""Class by its name in a file; the fields of the dataclass are the keys in the file."""
