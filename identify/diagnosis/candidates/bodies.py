"""Candidates that are bodies, or gravity: payload, links, a base that is not level."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin

from ...effects import Payload, RigidBody
from ...effects.rigid_body import inertial_beliefs
from ...model import Model
from ..candidate import Candidate
from ..driven import Driven
from .motors import on_motors

SIZE = 0.2
"""How far from its frame the mass of a body is expected to be [m]; evidence depends on its logarithm."""
LEANING = 0.02
"""How far a base that was set up level may lean [rad]: a degree."""
LIGHTEST = 1e-3
"""Mass by which any link may be off [kg]."""
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
    yield Candidate(
        "payload",
        (),
        columns,
        PARTS,
        UNITS,
        lower,
        smooth=True,
        proportion=PROPORTION,
        led=1,
        cancels=True,
    )


def links(model: Model) -> Iterator[Candidate]:
    """One link that is heavier, lighter or elsewhere than its tolerance allows."""
    if not any(isinstance(effect, RigidBody) for effect in model.effects):
        return
    robot, body = model.robot, RigidBody()
    own = [parameter.name for parameter in body.parameters(robot)]
    believed = dict(zip(model.names, model.believed_values, strict=True))

    @cache
    def regressor(run: Driven) -> np.ndarray:
        return body.regressor(robot, run.motion)

    for link in range(robot.dof):
        kept = [own.index(f"{part}{link + 1}") for part in PARTS]

        def columns(run: Driven, kept: list[int] = kept) -> np.ndarray:
            return on_motors(robot, regressor(run)[:, :, kept])

        # A link may be lighter, but by no more than it weighs.
        weight = max(float(believed[f"M{link + 1}"]), 0.0)
        names, lower = tuple(f"{part}{link + 1}" for part in PARTS), (-weight, *(-np.inf,) * 9)
        yield Candidate(
            "link_inertia", (link,), columns, names, UNITS, lower, smooth=True, proportion=PROPORTION, led=1,
            expected=_as_heavy(robot.kinematics.inertias[link + 1]),
        )  # fmt: skip


def _as_heavy(body: pin.Inertia) -> tuple[tuple[float, float], ...]:
    """How far a link's parameters may be off: about as much as it has, and never less than a gram's worth."""
    believed = inertial_beliefs(body, 1.0)
    least = LIGHTEST * np.array(PROPORTION)
    return tuple((0.0, max(believed[part].std, float(own))) for part, own in zip(PARTS, least, strict=True))


def tilts(model: Model) -> Iterator[Candidate]:
    """A base that leans: gravity has a part along its x and y axes."""

    def columns(run: Driven) -> np.ndarray:
        return gravity_columns(model, run, (0, 1))

    names, lower = ("tilt_x", "tilt_y"), (-np.inf, -np.inf)
    believed = ((0.0, LEANING),) * 2
    yield Candidate("base_tilt", (), columns, names, ("rad", "rad"), lower, smooth=True, expected=believed)


def gravity_columns(model: Model, run: Driven, axes: Sequence[int]) -> np.ndarray:
    """Torque of the motors by gravity along some axes of the base, shape (t, n, a) [N m]."""
    return on_motors(model.robot, np.stack([_gravity(model, run, axis) for axis in axes], axis=2))


def _gravity(model: Model, run: Driven, axis: int) -> np.ndarray:
    """Torque of gravity along an axis of the base, shape (t, n) [N m]; payloads included."""
    kinematics = run.bodies.copy()
    field = np.zeros(3)
    field[axis] = np.linalg.norm(model.robot.kinematics.gravity.linear)
    kinematics.gravity = pin.Motion(field, np.zeros(3))
    data = kinematics.createData()
    return np.array([pin.computeGeneralizedGravity(kinematics, data, q) for q in run.motion.position])
