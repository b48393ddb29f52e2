"""A drive whose torque per current falls at high torque, as iron saturates."""

from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from ..errors import RobotError
from .measurement import Measurement, require

GRID = 4000
"""Points of the curve by which currents are turned into torque; between them it is straight to 1e-7."""
END = 0.999
"""Share of a ceiling up to which that curve goes [-]: the current is hundreds of times as large there."""


@dataclass(frozen=True)
class DriveGainSaturation(Measurement):
    """Current beyond what a constant drive gain takes, `loss` times an excess that grows with torque.

    Attributes:
        joint: Name of the joint.
        loss: Current that every further newton metre takes in the end, over that of a constant gain, less 1;
            below a ceiling, the excess of current at 0.71 of the ceiling [-].
        knee: Torque from which on the drive loses, where magnets bias the iron [N m].
        width: Torque beyond the knee at which three quarters of that loss are there [N m].
        ceiling: Torque that no current exceeds, where nothing biases the iron [N m].
    """

    joint: str
    loss: float
    knee: float | None = None
    width: float | None = None
    ceiling: float | None = None

    def recorded(self, robot: Robot, torque: np.ndarray) -> np.ndarray:
        shown, joint = np.array(torque), robot.index(self.joint)
        shown[..., joint] += np.sign(shown[..., joint]) * self.loss * self._excess(np.abs(shown[..., joint]))
        return shown

    def restored(self, robot: Robot, shown: np.ndarray) -> np.ndarray:
        torque, joint = np.array(shown), robot.index(self.joint)
        own = shown[:, joint]
        most = float(np.max(np.abs(own), initial=0.0))
        if self.ceiling is not None:
            most = min(most, END * self.ceiling)
        grid = np.linspace(0.0, most, GRID)
        torque[:, joint] = np.sign(own) * np.interp(np.abs(own), grid + self.loss * self._excess(grid), grid)
        return torque

    def _excess(self, torque: np.ndarray) -> np.ndarray:
        """What is lost at torques of no less than zero for a loss of 1, any shape [N m]."""
        if self.ceiling is not None:
            square = np.minimum(torque / self.ceiling, END) ** 2
            return torque * square / (1.0 - square)
        assert self.knee is not None
        assert self.width is not None
        beyond = np.maximum(torque - self.knee, 0.0)
        return beyond**2 / (beyond + self.width)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        robot.index(self.joint)
        require("drive_gain_saturation", "loss", self.loss, above=False)
        if (self.ceiling is None) == (self.knee is None) or (self.knee is None) != (self.width is None):
            raise RobotError("drive_gain_saturation: give either knee and width, or a ceiling")
        for name in ("width", "ceiling"):
            if (value := getattr(self, name)) is not None:
                require("drive_gain_saturation", name, value)
