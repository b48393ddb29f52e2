"""A simulated arm with its drives: what any model does when commanded, and what its sensors measure."""

from .drive_control import DriveControl
from .plant import Integration, Measured, Plant
from .sensors import Sensors
from .thermal import Thermal
from .transmission import Transmission
from .typical import typical_plant

__all__ = [
    "DriveControl", "Integration", "Measured", "Plant", "Sensors", "Thermal", "Transmission", "typical_plant",
]  # fmt: skip
