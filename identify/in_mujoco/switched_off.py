"""Parts of a compiled MJCF that a simulation switches off: joints, drives, and friction of DC motors.

The identified model lacks joints that no recording contains: they are held rigidly, or led by a joint that is
recorded. A held joint gets a rotor of 1e15 kg m^2 in the compiled model, so no force moves it: the other
joints move as if it was welded, without the softness of a constraint. A joint that an equality couples to a
recorded joint stays free and follows it.

The number of a DC motor's states depends on which of its numbers are zero, so MuJoCo stops if a stiffness or
an integral gain becomes zero in a compiled model. Such numbers are kept above zero here.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..export.mjcf_gears import TWIST
from ..export.mjcf_patch import held_in
from ..robot_files.mjcf_dcmotors import SHORTED, dc_motors, is_dc_motor
from ..robot_files.mjcf_elements import (
    MOTOR_NUMBERS,
    actuators,
    drives_joint,
    enum_of,
    joint_equalities,
    joint_names,
)
from ..robot_files.mjcf_held import followed, held_positions

ROTOR = 1e15
"""Inertia of a held joint [kg m^2, kg]: a force of 1000 N moves it by less than 1e-8 m in 100 s."""


class Others(NamedTuple):
    """Joints of a simulation that a robot does not have."""

    # Address in `qpos` of each held joint -> its position, shape (1,), (4,) or (7,).
    held: Mapping[int, np.ndarray]
    # Equality, and addresses in `qpos` of the joint that follows and its leader.
    led: Sequence[tuple[int, int, int]]

    def place(self, model: Any, data: Any) -> None:
        """Set the positions of these joints, from those of the robot's joints."""
        for start, position in self.held.items():
            data.qpos[start : start + len(position)] = position
        for equality, follower, leader in self.led:
            data.qpos[follower] = followed(model, equality, float(data.qpos[leader]))


def hold_others(model: Any, robot: Robot, where: str) -> Others:
    """Hold all joints of a compiled MJCF that the robot does not have, except twists of its gears."""
    names = joint_names(model)
    twists = [TWIST.format(joint) for joint in robot.joints]
    moving = [name for name in names if name in robot.joints or name in twists]
    positions = held_positions(model, moving, held_in(model, robot), where)
    led = _led(model, positions)
    for _, follower, _ in led:
        del positions[follower]
    addresses = model.jnt_qposadr
    for joint, position in positions.items():
        start = int(model.jnt_dofadr[joint])
        model.dof_armature[start : start + max(len(position) - 1, 1)] = ROTOR
    return Others(
        {int(addresses[joint]): position for joint, position in positions.items()},
        [(e, int(addresses[follower]), int(addresses[leader])) for e, follower, leader in led],
    )


def _led(model: Any, positions: Mapping[int, np.ndarray]) -> list[tuple[int, int, int]]:
    """Equalities by which joints follow a joint that is not held, in the order from leader to follower."""
    led: list[tuple[int, int, int]] = []
    equalities = joint_equalities(model)
    for _ in equalities:
        for equality in equalities:
            _, follower, leader = equality
            moves = leader >= 0 and (leader not in positions or leader in (row[1] for row in led))
            if moves and follower in positions and equality not in led:
                led.append(equality)
    return led


def mount(model: Any, gravity: np.ndarray, original: np.ndarray | None = None) -> None:
    """Set the gravity (3,) [m/s^2] of a compiled MJCF, unless the file compensates or disables it.

    Gravity that a text has changed stays; `original` is the result of `weight` for the original file.
    """
    if original is not None and not np.array_equal(weight(model), original):
        return
    disabled = model.opt.disableflags & enum_of("mjtDisableBit", "mjDSBL_GRAVITY")
    if not disabled and not np.any(model.body_gravcomp):
        model.opt.gravity[:] = gravity


def weight(model: Any) -> np.ndarray:
    """Gravity of a compiled MJCF [m/s^2], and the largest share of it that is compensated [-], shape (4,)."""
    return np.append(model.opt.gravity, np.max(model.body_gravcomp))


OPEN = 1e30
"""Resistance of an open circuit [ohm]."""
RESISTANCE, PROPORTIONAL, INTEGRAL, DERIVATIVE = 0, 4, 5, 6
"""Places in `actuator_gainprm` of a DC motor."""
REMOVED = ("bristle_damping", "coulomb", "static", "amplitude")
"""Numbers of a DC motor that are zero while effects replace its friction and cogging."""


def silence(model: Any, joints: Sequence[int]) -> None:
    """Disable the drives of joints; friction, cogging and the brake of shorted motors stay."""
    for actuator in actuators(model):
        if not drives_joint(model, actuator) or model.actuator_trnid[actuator][0] not in joints:
            continue
        gain = model.actuator_gainprm[actuator]
        if not is_dc_motor(model, actuator):
            gain[:] = model.actuator_biasprm[actuator] = 0.0
        elif int(model.actuator_ctrlspec[actuator]) != SHORTED:  # no current flows
            gain[RESISTANCE], gain[PROPORTIONAL], gain[DERIVATIVE] = OPEN, 0.0, 0.0
            gain[INTEGRAL] = np.finfo(float).tiny if gain[INTEGRAL] > 0.0 else 0.0


class MotorFriction:
    """LuGre friction and cogging of the DC motors of joints, removed while effects replace them."""

    def __init__(self, model: Any, joints: Sequence[int]) -> None:
        self._model, self._motors = model, [motor.index for motor in dc_motors(model, joints)]
        tables = dict.fromkeys(MOTOR_NUMBERS[name].table for name in REMOVED)
        self._original = {table: getattr(model, table)[self._motors].copy() for table in tables}

    def remove(self) -> None:
        """Set friction and cogging to zero."""
        for number in (MOTOR_NUMBERS[name] for name in REMOVED):
            getattr(self._model, number.table)[self._motors, number.column] = 0.0

    def restore(self) -> None:
        """Restore the numbers of the file."""
        for table, rows in self._original.items():
            getattr(self._model, table)[self._motors] = rows
