"""As built: the arm that a nominal model describes, with other values, as any real one has."""

from dataclasses import replace
from zlib import crc32

import numpy as np

from ..arm.robot import Robot
from ..effects import Prior
from ..model import Model

USUAL = 0.1
"""Relative deviation of values without a stated tolerance: what data sheets of drive gains are off by."""
MOST = 0.1
"""Largest relative change: limits and monitors of the nominal arm still fit."""


def as_built(model: Model) -> Model:
    """The same effects with other values, drawn within the tolerances of the nominal ones.

    The same model always gives the same arm, whatever else is added to it: each value is drawn by its name.
    Masses change with all moments of their link, so that every body can exist.
    """
    stated = {
        name: Prior(prior.value * _factor(name, _share(prior)), prior.std)
        for name, prior in model.stated.items()
    }
    return replace(model, robot=_robot(model.robot), stated=stated)


def _robot(robot: Robot) -> Robot:
    tolerances = zip(robot.joints, robot.drive_gain_tolerance, strict=True)
    factors = [_factor(f"gain {joint}", tolerance) for joint, tolerance in tolerances]
    kinematics = robot.kinematics.copy()
    for link, joint in enumerate(robot.joints, start=1):
        body = kinematics.inertias[link]
        factor = _factor(f"link {joint}", robot.inertial_tolerance)
        body.mass, body.inertia = factor * body.mass, factor * body.inertia
        kinematics.inertias[link] = body
    return replace(robot, kinematics=kinematics, drive_gain=np.array(factors) * robot.drive_gain)


def _share(prior: Prior) -> float:
    """Relative deviation of a prior."""
    return prior.std / abs(prior.value) if prior.value and np.isfinite(prior.std) else USUAL


def _factor(name: str, tolerance: float) -> float:
    """One, less or more by up to the tolerance; the same for the same name."""
    drawn = np.random.default_rng(crc32(name.encode())).uniform(-1.0, 1.0)
    return 1.0 + drawn * min(tolerance, MOST)
