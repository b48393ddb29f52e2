"""A simulated arm with its drives: what any model does when commanded, and what its sensors measure."""

from .drives import DriveControl
from .gears import Thermal, Transmission
from .plant import Integration, Measured, Plant
from .sensors import Sensors
from .typical import typical_plant

__all__ = [
    "DriveControl", "Integration", "Measured", "Plant", "Sensors", "Thermal", "Transmission", "typical_plant",
]  # fmt: skip
