"""Forces in an MJCF: joint torques as `[[effect]]` rows, limits of joints, and actuators of several joints.

The values are initial values of a fit without a prior: many are chosen only to keep a simulation stable.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arm.robot import Limits, ServoLaw
from ..errors import RobotError
from . import mjcf_dcmotors
from .mjcf_dcmotors import is_dc_motor
from .mjcf_elements import HOLD, actuators, disabled, enum_of, input_of, joint_actuators, joint_name, name_of


def torque_limits(model: Any, joints: Sequence[int]) -> np.ndarray:
    """Maximum torque of each joint's actuators in both directions, shape (n,) [N m]; inf: not stated."""
    limits = np.full(len(joints), np.inf)
    for place, joint in enumerate(joints):
        strengths = [
            _strength(model, actuator) for actuator, driven in joint_actuators(model) if driven == joint
        ]
        if strengths:
            limits[place] = sum(strengths)
        limits[place] = min(limits[place], _joint_limit(model, joint))
    return np.where(limits > 0.0, limits, np.inf)


def _joint_limit(model: Any, joint: int) -> float:
    """Limit of the torque of all actuators of a joint [N m]; infinite if there is none."""
    return _symmetric_limit(model.jnt_actfrcrange[joint]) if model.jnt_actfrclimited[joint] else np.inf


def _strength(model: Any, actuator: int) -> float:
    """Maximum torque of an actuator behind its gear: its force range, or the range of a motor's input."""
    gear = abs(float(model.actuator_gear[actuator][0]))
    strongest = np.inf
    if model.actuator_forcelimited[actuator]:
        strongest = _symmetric_limit(model.actuator_forcerange[actuator])
    if is_dc_motor(model, actuator):
        strongest = min(strongest, mjcf_dcmotors.stall_torque(model, actuator))
    if is_motor(model, actuator) and model.actuator_ctrllimited[input_of(model, actuator)]:
        gain = abs(float(model.actuator_gainprm[actuator][0]))
        strongest = min(
            strongest, gain * _symmetric_limit(model.actuator_ctrlrange[input_of(model, actuator)])
        )
    return gear * strongest


def is_motor(model: Any, actuator: int) -> bool:
    """Whether an actuator's force is its control times a constant."""
    plain = model.actuator_biastype[actuator] == enum_of("mjtBias", "mjBIAS_NONE")
    return bool(plain and model.actuator_gaintype[actuator] == enum_of("mjtGain", "mjGAIN_FIXED"))


def motors(model: Any, joint: str) -> list[int]:
    """Indices of the actuators of a joint."""
    return [actuator for actuator, driven in joint_actuators(model) if joint_name(model, driven) == joint]


def _symmetric_limit(ends: np.ndarray) -> float:
    """Largest magnitude that a range allows in both directions."""
    return float(min(abs(ends[0]), abs(ends[1])))


def motor_coupling(model: Any, joints: Sequence[int], where: str) -> np.ndarray:
    """Coupling of motors and joints by fixed tendons, shape (n, n) [-]; empty if there are no such tendons.

    The motor of a tendon belongs to the only joint along the tendon that has no actuator of its own.
    """
    driven = {joint for _, joint in joint_actuators(model)}
    coupling = np.eye(len(joints))
    for actuator in actuators(model):
        if model.actuator_trntype[actuator] != enum_of("mjtTrn", "mjTRN_TENDON"):
            continue
        tendon = int(model.actuator_trnid[actuator][0])
        along = {joint: turn for joint, turn in _along(model, tendon).items() if joint in joints}
        free = [joint for joint in along if joint not in driven]
        if not along:
            continue
        if len(free) != 1:
            names = ", ".join(joint_name(model, joint) for joint in along)
            raise RobotError(
                f"{where}: actuator '{name_of(model, 'actuator', actuator)}' pulls tendon "
                f"'{name_of(model, 'tendon', tendon)}' of {names}; all but one of these need actuators of "
                f"their own. {HOLD}"
            )
        driven.add(free[0])
        place = list(joints).index(free[0])
        for joint, turn in along.items():
            coupling[place, list(joints).index(joint)] = turn / along[free[0]]
    return coupling if np.any(coupling != np.eye(len(joints))) else np.empty(0)


def _along(model: Any, tendon: int) -> dict[int, float]:
    """Joints of a fixed tendon and its change of length per motion of each; empty for a spatial tendon."""
    start = int(model.tendon_adr[tendon])
    wraps = range(start, start + int(model.tendon_num[tendon]))
    kind = enum_of("mjtWrap", "mjWRAP_JOINT")
    return {
        int(model.wrap_objid[wrap]): float(model.wrap_prm[wrap])
        for wrap in wraps
        if model.wrap_type[wrap] == kind and model.wrap_prm[wrap]
    }


def servos(model: Any, joints: Sequence[str]) -> list[int]:
    """Index of the position servo of each joint; empty if some joint has none."""
    chosen, names = [], [joint_name(model, joint) for joint in range(model.njnt)]
    for name in joints:
        if name not in names:
            return []
        joint = names.index(name)
        candidates = [actuator for actuator in actuators(model) if _is_servo(model, actuator, joint)]
        chosen += candidates[:1]
    return chosen if len(chosen) == len(joints) else []


def servo_stiffness(model: Any, joints: Sequence[str]) -> np.ndarray | None:
    """Stiffness of each joint's position servo, shape (n,) [N m/rad]; None if some joint has no servo."""
    actuators = servos(model, joints)
    if not actuators:
        return None
    return np.asarray(model.actuator_gainprm[actuators, 0] * model.actuator_gear[actuators, 0] ** 2)


def servo_law(model: Any, joints: Sequence[str]) -> ServoLaw | None:
    """Law of the joints' position servos; None if some joint has none, or some servo filters its command.

    A servo behind a gear g pushes g times its force and measures g times the joint's position, so that its
    commands are g times those of the law. Torque limits are those in both directions.
    """
    actuators = servos(model, joints)
    if not actuators or np.any(model.actuator_dyntype[actuators] != enum_of("mjtDyn", "mjDYN_NONE")):
        return None
    gear = model.actuator_gear[actuators, 0]
    # MuJoCo has delays since 4.0.
    delay = np.asarray(getattr(model, "actuator_delay", np.zeros(model.nu)))[actuators]
    strengths = np.array([_strength(model, actuator) for actuator in actuators])
    limits = np.array([_joint_limit(model, joint) for joint in model.actuator_trnid[actuators, 0]])
    return ServoLaw.of(
        model.actuator_gainprm[actuators, 0] * gear**2,
        (0.0 - model.actuator_biasprm[actuators, 2]) * gear**2,
        np.minimum(strengths, limits),
        delay,
    )


def _is_servo(model: Any, actuator: int, joint: int) -> bool:
    if is_dc_motor(model, actuator):  # its first numbers are resistance and cogging
        return False
    gain, bias = model.actuator_gainprm[actuator][0], model.actuator_biasprm[actuator][1]
    of_joint = model.actuator_trntype[actuator] == enum_of("mjtTrn", "mjTRN_JOINT")
    return of_joint and int(model.actuator_trnid[actuator][0]) == joint and gain > 0.0 and bias == -gain


def effect_rows(model: Any, joints: Sequence[int]) -> tuple[Mapping[str, Any], ...]:
    """Rotor inertia, friction, springs and offsets of the moving joints, with the values of the file."""
    dofs = model.jnt_dofadr[list(joints)]
    of_drive = {name: _of_actuators(model, joints, name) for name in ("armature", "damping")}
    damps, springs = (not disabled(model, flag) for flag in ("DAMPER", "SPRING"))
    motors = mjcf_dcmotors.dc_motors(model, joints)
    viscous, dry = mjcf_dcmotors.friction_of_motors(motors, joints)
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
    rows += mjcf_dcmotors.stribeck_friction(motors, joints, names)
    rows += mjcf_dcmotors.ripples(motors, joints, names)
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
    stiffness = model.jnt_stiffness[joints]
    offset = -stiffness * model.qpos_spring[model.jnt_qposadr[joints]]
    values = np.stack([stiffness, offset], axis=1).ravel() + 0.0
    names = [joint_name(model, joint) for joint in joints]
    return {"name": "joint_spring", "joints": names, "values": values.tolist()}


def _of_actuators(model: Any, joints: Sequence[int], name: str) -> np.ndarray:
    """Armature or damping that actuators add to their joints, by the gear squared, shape (n,)."""
    shares, per_actuator = np.zeros(len(joints)), getattr(model, f"actuator_{name}", None)
    if per_actuator is None:  # MuJoCo before 3.7 lacks it
        return shares
    for actuator, joint in joint_actuators(model):
        share = per_actuator[actuator] * model.actuator_gear[actuator][0] ** 2
        shares += share * (np.asarray(joints) == joint)
    return shares


def limits_of(model: Any, joints: Sequence[int], torque: np.ndarray) -> Limits:
    """Limits of position and torque (n,); MuJoCo has no limits of velocity."""
    limited = model.jnt_limited[list(joints)].astype(bool)
    lower, upper = model.jnt_range[list(joints)].T
    far = np.full(len(joints), np.inf)
    return Limits(np.where(limited, lower, -far), np.where(limited, upper, far), far, far, far, torque)
