"""Axes: recorded quantities that a residual, or the torque of a finding, may depend on."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...arm.robot import SLIDING
from .evidence import Trace


class Axis(NamedTuple):
    """A recorded quantity on which a residual, or the torque of a finding, may depend."""

    label: str  # name, with the unit for revolute joints
    # function that gives the values for a trace and a joint, shape (r,)
    values: Callable[[Trace, int], np.ndarray]
    braking: bool = False  # whether torque counts as positive against the motion, as friction does
    size: bool = False  # whether the quantity is a magnitude, which is never negative
    of_motor: bool = False  # whether it is a motor angle, which is in radians for any joint

    def title(self, revolute: bool) -> str:
        """The label with the unit for a revolute or prismatic joint."""
        return f"{self.words} [{self.unit(revolute)}]"

    @property
    def words(self) -> str:
        """The label without its unit."""
        return self.label.partition(" [")[0]

    def unit(self, revolute: bool) -> str:
        """Unit for a revolute or prismatic joint."""
        turning = self.label.partition(" [")[2].removesuffix("]")
        return turning if revolute or self.of_motor else SLIDING.get(turning, turning)


AXES: dict[str, Axis] = {
    "velocity": Axis("velocity [rad/s]", lambda trace, j: trace.velocity[:, j]),
    "speed": Axis("speed [rad/s]", lambda trace, j: np.abs(trace.velocity[:, j]), True, True),
    "position": Axis("position [rad]", lambda trace, j: trace.position[:, j]),
    "where it brakes": Axis("position [rad]", lambda trace, j: trace.position[:, j], True),
    "load": Axis("nominal load [N m]", lambda trace, j: trace.load[:, j]),
    "size of the load": Axis("size of the load [N m]", lambda trace, j: np.abs(trace.load[:, j]), True, True),
    "torque": Axis("torque [N m]", lambda trace, j: trace.measured[:, j]),
    "acceleration": Axis("acceleration [rad/s²]", lambda trace, j: trace.acceleration[:, j]),
    "temperature": Axis("temperature [°C]", lambda trace, j: trace.temperature[:, j], True),
    "time": Axis("time [s]", lambda trace, j: trace.time),
    "motor angle": Axis(
        "angle of the motor [rad]", lambda trace, j: trace.motor_angle[:, j] % (2 * np.pi), of_motor=True
    ),
}
"""Axes by name."""
