"""Recorded currents that are not in proportion to the torque: saturated, clipped, or delayed."""

from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from ..errors import RobotError
from .measurement import Measurement, on_joints, require

GRID = 4000
"""Number of points of the curve from current to torque; linear interpolation is accurate to 1e-7."""
END = 0.999
"""Share of the ceiling at which the curve ends [-]; the current is hundreds of times as large there."""


@dataclass(frozen=True)
class DriveGainSaturation(Measurement):
    """Current in addition to that of a constant drive gain: `loss` times an excess that grows with torque.

    Attributes:
        joint: Name of the joint.
        loss: Relative increase of current per torque far above the knee; with a ceiling, the relative excess
            current at 0.71 of the ceiling [-].
        knee: Torque above which the gain decreases, for iron biased by magnets [N m].
        width: Torque beyond the knee at which the increase is three quarters of `loss` [N m].
        ceiling: Torque that no current exceeds, for iron without bias [N m].
    """

    joint: str
    loss: float
    knee: float | None = None
    width: float | None = None
    ceiling: float | None = None

    def recorded(self, robot: Robot, torque: np.ndarray) -> np.ndarray:
        shown, joint = np.array(torque), robot.index(self.joint)
        shown[..., joint] += np.sign(shown[..., joint]) * self.loss * self.excess(np.abs(shown[..., joint]))
        return shown

    def restored(self, robot: Robot, shown: np.ndarray) -> np.ndarray:
        torque, joint = np.array(shown), robot.index(self.joint)
        effort = shown[:, joint]
        most = float(np.max(np.abs(effort), initial=0.0))
        if self.ceiling is not None:
            most = min(most, END * self.ceiling)
        grid = np.linspace(0.0, most, GRID)
        torque[:, joint] = np.sign(effort) * np.interp(
            np.abs(effort), grid + self.loss * self.excess(grid), grid
        )
        return torque

    def excess(self, torque: np.ndarray) -> np.ndarray:
        """Excess at non-negative torques of any shape, for a loss of 1 [N m]."""
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


@dataclass(frozen=True)
class CurrentClipping(Measurement):
    """A sensor with a limited range; a fit leaves out clipped samples.

    Attributes:
        limit: Largest recorded effort in both directions [A; N m if torque is recorded].
        joints: Names of the joints whose sensors are clipped; None for all.
    """

    limit: float
    joints: tuple[str, ...] | None = None

    def current_limit(self, robot: Robot) -> np.ndarray:
        return on_joints(robot, self.joints, self.limit, np.inf)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        require("current_clipping", "limit", self.limit)


LONGEST = 1.0
"""Longest delay [s]: no controller acts on older currents."""


@dataclass(frozen=True)
class TimeDelay(Measurement):
    """A delay of currents or torques; several delays of one joint add up.

    Attributes:
        seconds: Delay of recorded efforts relative to positions; negative if they are earlier [s].
        joints: Names of the joints with delayed efforts; None for all.
    """

    seconds: float
    joints: tuple[str, ...] | None = None

    def delay(self, robot: Robot) -> np.ndarray:
        return on_joints(robot, self.joints, self.seconds, 0.0)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        if not abs(self.seconds) <= LONGEST:
            raise RobotError(
                f"time_delay seconds: {self.seconds:g} s exceeds {LONGEST:g} s; give the delay in seconds"
            )
