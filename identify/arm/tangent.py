"""`Tangent`: derivatives of the links' torque with respect to small deviations from a motion."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from .motion import Motion

RATE = 125.0
"""Sampling rate of the derivatives [Hz]: nine samples per period of the fastest motion give an interpolation
error of 1e-3."""


class Tangent(NamedTuple):
    """Derivatives of the links' torque, each (n, t, n): moved joint, sample, joint of the torque."""

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
