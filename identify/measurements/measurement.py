"""`Measurement`: an effect between an arm and its recordings that is not a torque of rigid joints.

Its numbers are fields, not linear parameters: a diagnosis finds them, or a robot file states them. A fit
removes the effect from recordings, and a simulation adds it; both use the same object.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arm.robot import Robot
from ..errors import RobotError


@dataclass(frozen=True)
class Measurement:
    """Effect between an arm and its recordings; a subclass overrides the methods that it changes."""

    def delay(self, robot: Robot) -> np.ndarray:
        """Delay of each joint's recorded effort relative to its position, shape (n,) [s]."""
        return np.zeros(robot.dof)

    def current_limit(self, robot: Robot) -> np.ndarray:
        """Largest recorded effort of each joint, shape (n,) [A; N m if torque is recorded]."""
        return np.full(robot.dof, np.inf)

    def recorded(self, robot: Robot, torque: np.ndarray) -> np.ndarray:
        """Drive gains times recorded currents at motor torques (..., n), same shape [N m]."""
        return torque

    def restored(self, robot: Robot, shown: np.ndarray) -> np.ndarray:
        """Motor torques from drive gains times recorded currents (t, n), same shape [N m]."""
        return shown

    def check(self, robot: Robot) -> None:
        """Check numbers and joints.

        Raises:
            UnknownJoint: The robot has no such joint.
            RobotError: A number is outside its range.
        """
        self.delay(robot)
        self.current_limit(robot)


def require(effect: str, name: str, value: float, above: bool = True) -> None:
    """Raise `RobotError` unless a number of an effect is above 0, or at least 0 if `above` is false."""
    if not (value > 0.0 if above else value >= 0.0):
        raise RobotError(f"{effect} {name}: {value:g} is not {'above' if above else 'at least'} 0")


def on_joints(robot: Robot, joints: Sequence[str] | None, value: float, elsewhere: float) -> np.ndarray:
    """Array with `value` for the named joints (None for all) and `elsewhere` for the others, shape (n,)."""
    values = np.full(robot.dof, value if joints is None else elsewhere)
    for joint in joints or ():
        values[robot.index(joint)] = value
    return values


GRID = 4000
"""Number of points of the curve from current to torque; linear interpolation is accurate to 1e-7."""
END = 0.999
"""Share of the ceiling at which the curve ends [-]; the current is hundreds of times as large there."""


@dataclass(frozen=True)
class DriveGainSaturation(Measurement):
    """Current in addition to that of a constant drive gain: `loss` times an excess that grows with torque."""

    joint: str  # name of the joint
    # Relative increase of current per torque far above the knee; with a ceiling, the relative excess current
    # at 0.71 of the ceiling [-].
    loss: float
    knee: float | None = None  # torque above which the gain decreases, for iron biased by magnets [N m]
    width: float | None = None  # torque beyond the knee where the increase is three quarters of `loss` [N m]
    ceiling: float | None = None  # torque that no current exceeds, for iron without bias [N m]

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
    """A sensor with a limited range; a fit leaves out clipped samples."""

    limit: float  # largest recorded effort in both directions [A; N m if torque is recorded]
    joints: tuple[str, ...] | None = None  # names of the joints whose sensors are clipped; None for all

    def current_limit(self, robot: Robot) -> np.ndarray:
        return on_joints(robot, self.joints, self.limit, np.inf)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        require("current_clipping", "limit", self.limit)


LONGEST = 1.0
"""Longest delay [s]: no controller acts on older currents."""


@dataclass(frozen=True)
class TimeDelay(Measurement):
    """A delay of currents or torques; several delays of one joint add up."""

    seconds: float  # delay of recorded efforts relative to positions; negative if they are earlier [s]
    joints: tuple[str, ...] | None = None  # names of the joints with delayed efforts; None for all

    def delay(self, robot: Robot) -> np.ndarray:
        return on_joints(robot, self.joints, self.seconds, 0.0)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        if not abs(self.seconds) <= LONGEST:
            raise RobotError(
                f"time_delay seconds: {self.seconds:g} s exceeds {LONGEST:g} s; give the delay in seconds"
            )
