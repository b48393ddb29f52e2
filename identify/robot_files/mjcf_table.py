"""Numbers of an MJCF: the table by which they are read, written, checked and compared.

A joint has four terms of a model. A DC motor has numbers of its shaft, before the gear.
"""

from typing import Any, NamedTuple

import numpy as np


class Number(NamedTuple):
    """A number, in a file and in the compiled model."""

    attribute: str  # attribute in the file
    unit: str  # SI unit, of a revolute joint
    table: str  # table of the compiled model, with one row per joint, degree of freedom or actuator
    column: int = 0  # column of the table

    def read(self, model: Any, row: int) -> float:
        """The number in a row of a compiled model."""
        return float(np.atleast_1d(getattr(model, self.table)[row])[self.column])


JOINT_TERMS = {
    "armature": Number("armature", "kg m^2", "dof_armature"),
    "damping": Number("damping", "N m s/rad", "dof_damping"),
    "dry": Number("frictionloss", "N m", "dof_frictionloss"),
    "stiffness": Number("stiffness", "N m/rad", "jnt_stiffness"),
}
"""Field of `JointTerms` -> number of a joint."""
MOTOR_NUMBERS = {
    "constant": Number("motorconst", "N m/A", "actuator_gainprm", 1),
    "resistance": Number("resistance", "ohm", "actuator_gainprm", 0),
    "armature": Number("armature", "kg m^2", "actuator_armature"),
    "damping": Number("damping", "N m s/rad", "actuator_damping"),
    "stiffness": Number("lugre", "N m/rad", "actuator_dynprm", 5),
    "bristle_damping": Number("lugre", "N m s/rad", "actuator_dynprm", 6),
    "coulomb": Number("lugre", "N m", "actuator_biasprm", 3),
    "static": Number("lugre", "N m", "actuator_biasprm", 4),
    "stribeck": Number("lugre", "rad/s", "actuator_biasprm", 5),
    "amplitude": Number("cogging", "N m", "actuator_biasprm", 0),
    "poles": Number("cogging", "1", "actuator_biasprm", 1),
    "phase": Number("cogging", "rad", "actuator_biasprm", 2),
}
"""Field of `DcMotor` -> number of a `dcmotor` (MuJoCo, doc/dcmotor/dcmotor.tex, table 9). Numbers of one
attribute are in its order."""


def attribute_numbers(attribute: str) -> list[str]:
    """Fields of `DcMotor` that an attribute of a `dcmotor` holds, in its order."""
    return [name for name, number in MOTOR_NUMBERS.items() if number.attribute == attribute]
