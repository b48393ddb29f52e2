"""Elements of a compiled MJCF: their names, kinds and numbers.

Numbers are in one table, by which they are read, written, checked and compared. A joint has four terms of a
model; a DC motor has numbers of its shaft, before the gear.
"""

from typing import Any, NamedTuple

import numpy as np

from ..notebook import optional

HOLD = "Hold joints still in a robot.toml: mjcf = ..., joints = [joints that move]"


def enum_of(kind: str, name: str) -> int:
    """Value of an enumeration of MuJoCo, such as `enum_of("mjtJoint", "mjJNT_HINGE")`."""
    return int(getattr(getattr(optional("mujoco", "an MJCF", "mujoco"), kind), name))


def disabled(model: Any, flag: str) -> bool:
    """Whether the option `flag` switches off a kind of forces, such as "GRAVITY"."""
    return bool(model.opt.disableflags & enum_of("mjtDisableBit", f"mjDSBL_{flag}"))


def name_of(model: Any, kind: str, index: int) -> str:
    """Name of an element; if the file gives none, its kind and its number from 1."""
    mujoco = optional("mujoco", "an MJCF", "mujoco")
    named = mujoco.mj_id2name(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), index)
    return str(named or f"{kind}{index + 1}")


def actuators(model: Any) -> range:
    """Indices of the actuators; `model.nu` counts their inputs, of which servos can have several or none."""
    return range(len(model.actuator_trntype))


def input_of(model: Any, actuator: int) -> int:
    """Index of an actuator's first input in `ctrl` and `actuator_ctrlrange`."""
    addresses = getattr(model, "actuator_ctrladr", None)  # MuJoCo before 3.12 has one input per actuator
    return actuator if addresses is None else int(addresses[actuator])


def drives_joint(model: Any, actuator: int) -> bool:
    """Whether the transmission of an actuator is a joint, in either of its two frames."""
    kinds = (enum_of("mjtTrn", "mjTRN_JOINT"), enum_of("mjtTrn", "mjTRN_JOINTINPARENT"))
    return bool(model.actuator_trntype[actuator] in kinds)


def joint_actuators(model: Any) -> list[tuple[int, int]]:
    """Actuators whose transmission is a joint, and that joint."""
    return [
        (index, int(model.actuator_trnid[index][0]))
        for index in actuators(model)
        if drives_joint(model, index)
    ]


def joint_name(model: Any, joint: int) -> str:
    """Name of a joint."""
    return name_of(model, "joint", joint)


def joint_names(model: Any) -> list[str]:
    """Names of all joints."""
    return [joint_name(model, joint) for joint in range(model.njnt)]


def turns(model: Any, joint: int) -> bool:
    """Whether a joint is a hinge."""
    return bool(model.jnt_type[joint] == enum_of("mjtJoint", "mjJNT_HINGE"))


def single(model: Any, joint: int) -> bool:
    """Whether a joint has one degree of freedom."""
    return turns(model, joint) or bool(model.jnt_type[joint] == enum_of("mjtJoint", "mjJNT_SLIDE"))


def joint_equalities(model: Any) -> list[tuple[int, int, int]]:
    """Active equalities of joints: index, the joint that follows, and the joint that it follows or -1."""
    kind = enum_of("mjtEq", "mjEQ_JOINT")
    equalities = zip(model.eq_type, model.eq_active0, model.eq_obj1id, model.eq_obj2id, strict=True)
    return [
        (e, int(follower), int(leader))
        for e, (type_, active, follower, leader) in enumerate(equalities)
        if type_ == kind and active
    ]


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
