"""Arms of two joints in a vertical plane, as stated and as they truly are."""

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.effects import (
    CoulombFriction,
    CurrentOffset,
    Effect,
    JointSpring,
    LoadDependentFriction,
    NonlinearViscousFriction,
    Prior,
    RigidBody,
    RotorInertia,
    ViscousFriction,
)
from exidyn.identification.model import Model
from exidyn.identification.simulation.plant import Transmission

GAIN = np.array([-40.0, 25.0])
USUAL = {"Fv1": 3.0, "Fv2": 1.5, "Fc1": 4.0, "Fc2": 2.0, "Off1": 0.0, "Off2": 0.0, "Ia1": 0.5, "Ia2": 0.2}
"""True friction, offsets and rotor inertia; SI units."""
GUESS = 0.2
"""Relative deviation of friction as it is stated [-]."""
KNOWN = 0.02
"""The same of masses and drive gains [-]."""
RIGID = Transmission(np.full(2, np.inf), np.zeros(2), np.zeros(2))


@dataclass(frozen=True)
class Concealed:
    """One effect that the nominal model does not have.

    Attributes:
        name: In the vocabulary.
        joint: From 0.
        effect: Of a model; None where it is of the gears.
        values: Of its parameters.
        gears: Between motors and links.
    """

    name: str
    joint: int
    effect: Effect | None = None
    values: tuple[tuple[str, float], ...] = ()
    gears: Transmission = RIGID


def _soft(joint: int, stiffness: float) -> Transmission:
    chosen = np.arange(2) == joint
    return Transmission(np.where(chosen, stiffness, np.inf), np.where(chosen, 1.0, 0.0), np.zeros(2))


def concealed(name: str, joint: int, size: float) -> Concealed:
    """An effect on a joint, so many times as strong as usual."""
    key, usual = joint + 1, USUAL[f"Fc{joint + 1}"]
    where = (("shoulder", "elbow")[joint],)
    drag = NonlinearViscousFriction(where, 0.4)
    made = {
        "joint_spring": Concealed(name, joint, JointSpring(where), ((f"Ks{key}", 6.0 * usual * size),)),
        "nonlinear_viscous_friction": Concealed(name, joint, drag, ((f"Fn{key}", 0.6 * usual * size),)),
        "load_dependent_friction": Concealed(
            name, joint, LoadDependentFriction(where), ((f"mu{key}", 0.15 * size),)
        ),
        "joint_elasticity": Concealed(name, joint, gears=_soft(joint, 2000.0 / size)),
    }  # fmt: skip
    return made[name]


EFFECTS = ("joint_spring", "nonlinear_viscous_friction", "load_dependent_friction", "joint_elasticity")
"""Some that one run identifies, and some that it may leave open, such as a gear's twist."""


def arm() -> Robot:
    """Its links and limits."""
    kinematics = pin.Model()
    for name, parent, x in (("shoulder", 0, 0.0), ("elbow", 1, 0.4)):
        offset = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        joint = kinematics.addJoint(parent, pin.JointModelRY(), offset, name)
        body = pin.Inertia(5.0 - x, np.array([0.2, 0.01, 0.03]), 0.05 * np.eye(3))
        kinematics.appendBodyToJoint(joint, body, pin.SE3.Identity())
    limits = Limits(*np.outer([-2.5, 2.5, 3.0, 12.0, 200.0, 200.0], np.ones(2)))
    return Robot(
        "two joints",
        kinematics,
        limits=limits,
        drive_gain=GAIN,
        gear_ratio=np.array([100.0, 80.0]),
        flange=pin.SE3(np.eye(3), np.array([0.3, 0.0, 0.0])),
        inertial_tolerance=KNOWN,
        drive_gain_tolerance=KNOWN,
    )


def nominal() -> Model:
    """As its makers state it."""
    stated = {
        name: Prior(0.95 * USUAL[name], GUESS * USUAL[name])
        for name in ("Fv1", "Fv2", "Fc1", "Fc2", "Ia1", "Ia2")
    }
    effects = (RigidBody(), RotorInertia(), ViscousFriction(), CoulombFriction(), CurrentOffset())
    return Model(arm(), effects, stated)


def truth(parts: tuple[Concealed, ...]) -> tuple[Model, Transmission]:
    """As it is."""
    model, gears, values = nominal(), RIGID, dict(USUAL)
    for part in parts:
        values |= dict(part.values)
        if part.effect is not None:
            model = model + part.effect
        gears = Transmission(
            np.minimum(gears.stiffness, part.gears.stiffness),
            gears.damping + part.gears.damping,
            gears.backlash,
        )
    stated = {
        name: Prior(values.get(name, value))
        for name, value in zip(model.names, model.nominal_values, strict=True)
    }
    return replace(model, stated=stated), gears
