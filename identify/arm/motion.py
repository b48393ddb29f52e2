"""`Motion` of the joints, the input of every effect; time derivatives; torque of small deviations from it."""

from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..errors import WrongShape


@dataclass(frozen=True)
class Motion:
    """Joint motion on one time axis."""

    time: np.ndarray  # time, shape (t,) [s]
    position: np.ndarray  # joint position, shape (t, n) [rad], or [m] for prismatic joints
    velocity: np.ndarray  # joint velocity, shape (t, n) [rad/s]
    acceleration: np.ndarray  # joint acceleration, shape (t, n) [rad/s^2]
    load: np.ndarray  # nominal torque that the gear transmits to the link, shape (t, n) [N m]
    temperature: np.ndarray  # temperature, shape (t, n) [degC]; NaN if not measured
    payload: str = ""  # name of the payload in this run; empty for none

    def __post_init__(self) -> None:
        shape = (*self.time.shape, *self.position.shape[1:])
        for name in ("position", "velocity", "acceleration", "load", "temperature"):
            actual = getattr(self, name).shape
            if actual != shape or len(shape) != 2:
                raise WrongShape(f"motion: {name} has shape {actual}, expected {shape} (samples, joints)")

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, rows: slice) -> "Motion":
        arrays = {f.name: getattr(self, f.name)[rows] for f in fields(self) if f.name != "payload"}
        return replace(self, **arrays)

    @classmethod
    def of(
        cls,
        time: np.ndarray,
        position: np.ndarray,
        velocity: np.ndarray,
        acceleration: np.ndarray,
        load: np.ndarray | None = None,
        temperature: np.ndarray | None = None,
        payload: str = "",
    ) -> "Motion":
        """Create a motion; load defaults to zero, and temperature to unknown."""
        load = np.zeros_like(position) if load is None else load
        temperature = np.full_like(position, np.nan) if temperature is None else temperature
        return cls(time, position, velocity, acceleration, load, temperature, payload)


# Central differences of sixth order (paper, section III). At a twelfth of the sampling rate, such as 8 Hz in
# a 100 Hz recording, three-point differences are 4 % too small; these are 1e-4 too small.
FIRST = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60.0
SECOND = np.array([2, -27, 270, -490, 270, -27, 2]) / 180.0


def differentiate(values: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """First and second time derivative, shape (t, n); three samples at each end are invalid."""
    padded = np.pad(values, ((3, 3), (0, 0)), mode="reflect", reflect_type="odd")
    return _correlated(padded, FIRST * rate), _correlated(padded, SECOND * rate**2)


def _correlated(padded: np.ndarray, taps: np.ndarray) -> np.ndarray:
    """Sums of successive rows times taps (k,), shape (t - k + 1, n)."""
    count = len(padded) - len(taps) + 1
    return np.asarray(sum(tap * padded[place : place + count] for place, tap in enumerate(taps)))


RATE = 125.0
"""Sampling rate of the derivatives of torque [Hz]: nine samples per period of the fastest motion give an
interpolation error of 1e-3."""


class Tangent(NamedTuple):
    """Derivatives of the links' torque with respect to small deviations from a motion.

    Each has the shape (n, t, n): moved joint, sample, joint of the torque.
    """

    position: np.ndarray  # [N m/rad]
    velocity: np.ndarray  # [N m s/rad]
    acceleration: np.ndarray  # the inertia [kg m^2]

    def torque(self, joint: int, twist: np.ndarray, rate: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Change of all torques, shape (t, n) [N m], for a twist (t,) of one joint and its derivatives."""
        torque = self.position[joint] * twist[:, None]
        torque += self.velocity[joint] * rate[:, None]
        torque += self.acceleration[joint] * second[:, None]
        return torque

    def own(self, joint: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Stiffness, damping and inertia of one link about its own joint, each (t,)."""
        stiffness, damping, inertia = (np.ascontiguousarray(by[joint, :, joint]) for by in self)
        return stiffness, damping, inertia


def tangent(kinematics: pin.Model, motion: Motion) -> Tangent:
    """Tangent of the bodies of a Pinocchio model along a motion."""
    rows = knots(motion)
    data, n = kinematics.createData(), kinematics.nv
    slopes = np.empty((len(rows), 3, n, n))
    for place, row in enumerate(rows):
        state = motion.position[row], motion.velocity[row], motion.acceleration[row]
        slopes[place] = pin.computeRNEADerivatives(kinematics, data, *state)
    at_samples = over_knots(motion, slopes)
    return Tangent(*np.ascontiguousarray(np.moveaxis(at_samples, (1, 3), (0, 1))))


def knots(motion: Motion) -> np.ndarray:
    """Indices of the samples between which derivatives are interpolated, shape (k,)."""
    spacing = float(np.median(np.diff(motion.time)))
    rows = np.arange(0, len(motion) - 1, max(1, int(1.0 / (RATE * spacing))))
    return np.append(rows, len(motion) - 1)


def over_knots(motion: Motion, values: np.ndarray) -> np.ndarray:
    """Values (k, ...) at the knots, interpolated to all samples, shape (t, ...)."""
    from scipy.interpolate import CubicSpline  # large, and readers of files have little memory

    return np.asarray(CubicSpline(knots(motion), values)(np.arange(len(motion))))
