"""Tangent: how much torque the links take when one of them is a little elsewhere, along a motion."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from .motion import Motion

RATE = 125.0
"""Samples a second at which it is taken [Hz]: nine a period of the fastest motion, a spline's error of
1e-3."""


class Tangent(NamedTuple):
    """Derivatives of the links' torque at every sample, each (n, t, n): by which joint, of which joint."""

    position: np.ndarray  # [N m/rad]
    velocity: np.ndarray  # [N m s/rad]
    acceleration: np.ndarray  # the inertia [kg m^2]

    def torque(self, joint: int, twist: np.ndarray, rate: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Torque of all links, shape (t, n) [N m], when one leads by a twist (t,) with its derivatives."""
        parts = zip(self, (twist, rate, second), strict=True)
        return sum((by[joint] * one[:, None] for by, one in parts), np.zeros(self.position.shape[1:]))

    def own(self, joint: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What one link's own motion takes of its own joint: stiffness, damping, inertia, each (t,)."""
        stiffness, damping, inertia = (np.ascontiguousarray(by[joint, :, joint]) for by in self)
        return stiffness, damping, inertia


def tangent(kinematics: pin.Model, motion: Motion) -> Tangent:
    """Along a motion, of the bodies of a Pinocchio model."""
    rows = knots(motion)
    data, n = kinematics.createData(), kinematics.nv
    slopes = np.empty((len(rows), 3, n, n))
    for place, row in enumerate(rows):
        state = motion.position[row], motion.velocity[row], motion.acceleration[row]
        slopes[place] = pin.computeRNEADerivatives(kinematics, data, *state)
    every = over_knots(motion, slopes)
    return Tangent(*np.ascontiguousarray(np.moveaxis(every, (1, 3), (0, 1))))


def knots(motion: Motion) -> np.ndarray:
    """Samples of a motion between which derivatives are interpolated, shape (k,)."""
    spacing = float(np.median(np.diff(motion.time)))
    rows = np.arange(0, len(motion) - 1, max(1, int(1.0 / (RATE * spacing))))
    return np.append(rows, len(motion) - 1)


def over_knots(motion: Motion, values: np.ndarray) -> np.ndarray:
    """What is known at the knots (k, ...) at every sample, shape (t, ...)."""
    from scipy.interpolate import CubicSpline  # large, and readers of files have little memory

    return np.asarray(CubicSpline(knots(motion), values)(np.arange(len(motion))))
