"""Joint torques in an MJCF as `[[effect]]` rows, and the limits of joints.

The values are initial values of a fit without a prior: many are chosen only to keep a simulation stable.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arm.robot import Limits
from .mjcf_dcmotors import dc_motors, friction_of_motors, ripples, stribeck_friction
from .mjcf_names import disabled, joint_actuators, joint_name


def effect_rows(model: Any, joints: Sequence[int]) -> tuple[Mapping[str, Any], ...]:
    """Rotor inertia, friction, springs and offsets of the moving joints, with the values of the file."""
    dofs = model.jnt_dofadr[list(joints)]
    of_drive = {name: _of_actuators(model, joints, name) for name in ("armature", "damping")}
    damps, springs = (not disabled(model, flag) for flag in ("DAMPER", "SPRING"))
    motors = dc_motors(model, joints)
    viscous, dry = friction_of_motors(motors, joints)
    loses = not (disabled(model, "FRICTIONLOSS") or disabled(model, "CONSTRAINT"))
    terms = {
        "rotor_inertia": model.dof_armature[dofs] + of_drive["armature"],
        "viscous_friction": damps * (model.dof_damping[dofs] + of_drive["damping"]) + viscous,
        "coulomb_friction": loses * model.dof_frictionloss[dofs] + dry,
    }
    rows: list[Mapping[str, Any]] = [
        {"name": name, **({"values": values.tolist()} if np.any(values) else {})}
        for name, values in terms.items()
    ]
    names = [joint_name(model, joint) for joint in joints]
    rows += [*stribeck_friction(motors, joints, names), *ripples(motors, joints, names)]
    stiff = [joint for joint in joints if springs and model.jnt_stiffness[joint]]
    if stiff:
        rows.append(_springs(model, stiff))
    others = [joint_name(model, joint) for joint in joints if joint not in stiff]
    if others:
        everywhere = {} if len(others) == len(joints) else {"joints": others}
        rows.append({"name": "current_offset", **everywhere})
    return tuple(rows)


def _springs(model: Any, joints: Sequence[int]) -> Mapping[str, Any]:
    """Joint springs: stiffness [N m/rad] and torque at position zero [N m], joint by joint."""
    values = [
        value
        for joint in joints
        for stiffness in (float(model.jnt_stiffness[joint]),)
        for value in (stiffness, -stiffness * float(model.qpos_spring[model.jnt_qposadr[joint]]))
    ]
    return {
        "name": "joint_spring",
        "joints": [joint_name(model, joint) for joint in joints],
        "values": [value + 0.0 for value in values],
    }


def _of_actuators(model: Any, joints: Sequence[int], name: str) -> np.ndarray:
    """Armature or damping that actuators add to their joints, by the gear squared, shape (n,)."""
    shares, per_actuator = np.zeros(len(joints)), getattr(model, f"actuator_{name}", None)
    if per_actuator is None:  # MuJoCo before 3.7 lacks it
        return shares
    for actuator, joint in joint_actuators(model):
        if joint in joints:
            shares[list(joints).index(joint)] += (
                per_actuator[actuator] * model.actuator_gear[actuator][0] ** 2
            )
    return shares


def limits_of(model: Any, joints: Sequence[int], torque: np.ndarray) -> Limits:
    """Limits of position and torque (n,); MuJoCo has no limits of velocity."""
    limited = model.jnt_limited[list(joints)].astype(bool)
    lower, upper = model.jnt_range[list(joints)].T
    unlimited = np.full(len(joints), np.inf)
    return Limits(
        np.where(limited, lower, -unlimited),
        np.where(limited, upper, unlimited),
        unlimited,
        unlimited,
        unlimited,
        torque,
    )
