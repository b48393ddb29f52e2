"""Candidates that are bodies, or gravity: payload, links, a base that is not level."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin

from ...effects import Payload, RigidBody
from ...model import Model
from ..candidate import Candidate
from ..driven import Driven
from .motors import on_motors

SIZE = 0.2
"""How far from its frame the mass of a body is expected to be [m]; evidence depends on its logarithm."""
LEANING = 0.02
"""How far a base that was set up level may lean [rad]: a degree."""
PARTS = ("M", "MX", "MY", "MZ", "XX", "XY", "XZ", "YY", "YZ", "ZZ")
UNITS = ("kg", *("kg m",) * 3, *("kg m^2",) * 6)
PROPORTION = (1.0, *(SIZE,) * 3, *(SIZE**2,) * 6)


def payloads(model: Model) -> Iterator[Candidate]:
    """A body on the flange in every run, that nobody told of."""
    body, robot = Payload("unknown"), model.robot
    names = [parameter.name for parameter in body.parameters(robot)]
    kept = [names.index(f"{part}unknown") for part in PARTS]

    def columns(run: Driven) -> np.ndarray:
        return on_motors(robot, body.regressor(robot, replace(run.motion, payload="unknown"))[:, :, kept])

    lower = (0.0, *(-np.inf,) * 9)
    yield Candidate("payload", (), columns, PARTS, UNITS, lower, smooth=True, proportion=PROPORTION)


def links(model: Model) -> Iterator[Candidate]:
    """One link that is heavier, lighter or elsewhere than its tolerance allows."""
    robot, body = model.robot, RigidBody()
    own = [parameter.name for parameter in body.parameters(robot)]

    @cache
    def regressor(run: Driven) -> np.ndarray:
        return body.regressor(robot, run.motion)

    for link in range(robot.dof):
        kept = [own.index(f"{part}{link + 1}") for part in PARTS]

        def columns(run: Driven, kept: list[int] = kept) -> np.ndarray:
            return on_motors(robot, regressor(run)[:, :, kept])

        names, lower = tuple(f"{part}{link + 1}" for part in PARTS), (-np.inf,) * 10
        yield Candidate(
            "link_inertia", (link,), columns, names, UNITS, lower, smooth=True, proportion=PROPORTION
        )


def tilts(model: Model) -> Iterator[Candidate]:
    """A base that leans: gravity has a part along its x and y axes."""
    robot = model.robot

    def columns(run: Driven) -> np.ndarray:
        sides = [_gravity(model, run, axis) for axis in (0, 1)]
        return np.stack([side @ robot.to_motors.T for side in sides], axis=2)

    names, lower = ("tilt_x", "tilt_y"), (-np.inf, -np.inf)
    believed = ((0.0, LEANING),) * 2
    yield Candidate("base_tilt", (), columns, names, ("rad", "rad"), lower, smooth=True, expected=believed)


def _gravity(model: Model, run: Driven, axis: int) -> np.ndarray:
    """Torque of gravity along an axis of the base, shape (t, n) [N m]; payloads included."""
    kinematics = run.bodies.copy()
    field = np.zeros(3)
    field[axis] = np.linalg.norm(model.robot.kinematics.gravity.linear)
    kinematics.gravity = pin.Motion(field, np.zeros(3))
    data = kinematics.createData()
    return np.array([pin.computeGeneralizedGravity(kinematics, data, q) for q in run.motion.position])
