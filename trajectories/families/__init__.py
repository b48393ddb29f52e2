"""The list of motions that trajectory files know: one file a family, one line in this table."""

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
"""Name in a file -> class; what its dataclass holds is what the file holds."""
