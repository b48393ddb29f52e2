"""A simulated arm with its drives: the response of any model to commands, as its sensors measure it."""

from .drives import DriveControl
from .gears import Thermal, Transmission
from .plant import Integration, Measured, Plant
from .sensors import Sensors
from .typical import typical_plant

__all__ = [
    "DriveControl", "Integration", "Measured", "Plant", "Sensors", "Thermal", "Transmission", "typical_plant",
]  # fmt: skip
