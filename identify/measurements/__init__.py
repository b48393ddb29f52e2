"""Effects between an arm and its recordings, with one line in the table per kind."""

from .gears import Backlash, Gear, JointElasticity
from .measurement import CurrentClipping, DriveGainSaturation, Measurement, TimeDelay

MEASUREMENTS: dict[str, type[Measurement]] = {
    "time_delay": TimeDelay,
    "joint_elasticity": JointElasticity,
    "backlash": Backlash,
    "drive_gain_saturation": DriveGainSaturation,
    "current_clipping": CurrentClipping,
}
"""Name in robot files and the diagnosis -> class."""

__all__ = ["MEASUREMENTS", "Gear", "Measurement", *sorted(kind.__name__ for kind in MEASUREMENTS.values())]


def measurement_name(measurement: Measurement) -> str:
    """Key of a measurement effect in `MEASUREMENTS`."""
    return next(name for name, kind in MEASUREMENTS.items() if kind is type(measurement))
