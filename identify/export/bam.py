r"""BAM (github.com/Rhoban/bam): servos with friction models M1 to M4, for `bam.mujoco.load_config`.

BAM's motor has a torque constant and a resistance, and a firmware that sets a share of the supply voltage V
in proportion to the position error. From the law of a servo follow :math:`k_t = d V / L` and
:math:`R = d V^2 / L^2` with the damping d and the torque L at standstill. The file is for a supply of 1 V and
a firmware gain of 1: only their products with the numbers of the file count.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from exidyn.quoting import json_text

from ..effects import LoadDependentFriction, StribeckFriction
from ..effects.effect import JointEffect
from ..errors import RobotError
from .portable import Portable

FEATURES = ("armature", "damping", "dry", "stribeck_friction", "load_dependent_friction", "servos", "law")
ACTUATOR = "xl330"
"""Name of an actuator of BAM whose firmware controls the voltage and has no other constants."""
LEAST_EMF = 1e-6
"""Smallest damping by the motor's back-EMF, as a share of its torque [s/rad]; BAM divides by it."""

NOTES = (
    "saturation of a moving servo: the supply limits the voltage, so that the torque falls below its limit "
    "by the damping",
)


@dataclass(frozen=True)
class BamServo:
    """Parameters of one joint in the terms of BAM, for a supply of 1 V and a firmware gain of 1.

    Attributes:
        kt: Torque constant [N m/A].
        resistance: Resistance of the winding [Ohm].
        error_gain: Share of the supply per position error [1/rad].
        armature: Inertia of rotor and gear [kg m^2].
        coulomb: Dry friction [N m].
        viscous: Viscous friction in addition to the back-EMF [N m s/rad].
        stribeck: Dry friction at rest in addition to `coulomb` [N m].
        fade: Velocity over which it fades [rad/s].
        exponent: Exponent with which it fades [-].
        load: Friction per difference of external and motor torque, which is twice the load [-].
    """

    kt: float
    resistance: float
    error_gain: float
    armature: float
    coulomb: float
    viscous: float
    stribeck: float
    fade: float
    exponent: float
    load: float

    @property
    def model(self) -> str:
        """The simplest of BAM's models with these terms."""
        return {(0, 0): "m1", (1, 0): "m2", (0, 1): "m3", (1, 1): "m4"}[bool(self.stribeck), bool(self.load)]

    def parameters(self) -> dict[str, Any]:
        """Content of BAM's parameter file."""
        values: dict[str, Any] = {"kt": self.kt, "R": self.resistance, "armature": self.armature}
        values |= {"q_offset": 0.0, "friction_base": self.coulomb, "friction_viscous": self.viscous}
        if self.stribeck:
            values |= {"friction_stribeck": self.stribeck, "dtheta_stribeck": self.fade}
            values["alpha"] = self.exponent
        if self.load:
            values["load_friction_base"] = self.load
        if self.stribeck and self.load:
            values["load_friction_stribeck"] = 0.0
        return values | {"model": self.model, "actuator": ACTUATOR}


def bam(portable: Portable) -> str:
    """JSON for BAM's `load_config(..., kp=1, vin=1)`: a servo per joint with friction M1 to M4; no bodies."""
    table = {
        joint: {"dofs": [joint], "error_gain": servo.error_gain, "max_pwm": 1.0, "model": servo.parameters()}
        for joint, servo in zip(portable.robot.joints, bam_servos(portable), strict=True)
    }
    return json_text(table) + "\n"


def bam_servos(portable: Portable) -> list[BamServo]:
    """Servos of all joints in the terms of BAM; raises `RobotError` without servos or a torque limit."""
    law, limit = portable.servos, portable.torque_limit
    if law is None:
        raise RobotError(
            "BAM has position servos: export an MJCF with position actuators, or state [drive] servo_gain"
        )
    for joint, torque in zip(portable.robot.joints, limit, strict=True):
        if not np.isfinite(torque):
            raise RobotError(f"BAM needs the torque limit of joint {joint}: state [limits] torque")
    passive = np.maximum(portable.joints.damping, 0.0)
    # A law without damping of its own has that of the motor in the viscous friction.
    emf = np.where(law.damping > 0.0, law.damping, passive)
    viscous = np.where(law.damping > 0.0, passive, 0.0)
    emf = np.maximum(emf, LEAST_EMF * limit)
    stribeck, fade, exponent = _largest(portable, StribeckFriction, "fade", "exponent")
    load, *_ = _largest(portable, LoadDependentFriction)
    columns = (
        emf / limit, emf / limit**2, law.stiffness / limit, np.maximum(portable.joints.armature, 0.0),
        np.maximum(portable.joints.dry, 0.0), viscous, stribeck, fade, exponent,
        load / 2.0,
    )  # fmt: skip
    return [BamServo(*map(float, row)) for row in zip(*columns, strict=True)]


def bam_notes(portable: Portable) -> list[str]:
    """Sentences on the parts of the model that BAM's formulas approximate."""
    notes = list(NOTES)
    loads = [effect for effect, _ in portable.others if isinstance(effect, LoadDependentFriction)]
    if loads:
        notes.append(
            "load_dependent_friction away from balance, where external and motor torque differ in size"
        )
    notes += [
        f"preload {effect.preload:.4g} N m of load_dependent_friction" for effect in loads if effect.preload
    ]
    return notes


def _largest(portable: Portable, kind: type[JointEffect], *numbers: str) -> np.ndarray:
    """Sum of an effect's values on each joint, and numbers of its last row there, each of shape (n,)."""
    total, *shapes = table = np.zeros((1 + len(numbers), portable.robot.dof))
    for effect, values in portable.others:
        if isinstance(effect, kind):
            columns = effect.columns(portable.robot)
            total[columns] += np.maximum(values, 0.0)
            for shape, number in zip(shapes, numbers, strict=True):
                shape[columns] = getattr(effect, number)
    return table
