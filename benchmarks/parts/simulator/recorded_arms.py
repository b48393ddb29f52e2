"""Real recordings, and the models that users have of these arms.

Where a log has torque or current, it drives the simulation. Logs of hobby servos and of legs hold commands
and positions, which the position servos of the file follow.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import mujoco

from exidyn.identification.in_mujoco.replay import POSITION, TORQUE
from parts.real.data import DE_LUCA

SERVO_GAIN = 0.53
"""Torque of the Feetech servo per volt, by known masses [N m/V]; see its KNOWN.md."""
PENDULUMS = ((535, 100), (741, 150), (969, 100), (1168, 150))
"""Mass [g] and length of the arm [mm]."""
ARM_MASS = {100: 0.036, 150: 0.050}
"""Mass of the arm by its length [kg]."""
PENDULUM = """<mujoco model="{name}">
  <compiler angle="radian"/>
  <!-- joint and servo: {origin} -->
  <default>
    <joint frictionloss="0.1" armature="{armature}"/>
    <position kp="50" dampratio="1"{limit}/>
  </default>
  <worldbody>
    <body name="pendulum">
      <inertial mass="{mass}" pos="0 0 {center}" diaginertia="{inertia} {inertia} 0.0002"/>
      <joint name="pivot" axis="0 1 0" range="-3.2 3.2"/>
      <site name="flange" pos="0 0 {length}"/>
    </body>
  </worldbody>
  <actuator><position name="pivot" joint="pivot"/></actuator>
</mujoco>
"""
FEETECH = {
    "name": "sts3215", "origin": "class so_arm100 of mujoco_menagerie's trs_so_arm100", "armature": 0.1,
    "limit": ' forcerange="-3.5 3.5"',
}  # fmt: skip
DYNAMIXEL = {
    "name": "xl330", "origin": "class dynamixel_2r of mujoco_menagerie's dynamixel_2r", "armature": 0.005,
    "limit": "",
}  # fmt: skip
SO101 = ("Rotation", "Pitch", "Elbow", "Wrist_Pitch", "Wrist_Roll", "Jaw")
GO2 = tuple(f"{leg}_{joint}" for leg in ("FL", "FR", "RL", "RR") for joint in ("hip", "thigh", "calf"))
GO2_LAW = (20.0, 1.5)
"""Stiffness and damping of the law of the publisher's controller [N m/rad, N m s/rad]."""


@dataclass(frozen=True)
class Recorded:
    """Recordings of an arm, and the file that a user has of it."""

    name: str  # Name of the arm
    folder: str  # Folder of its recordings
    fitted: tuple[str, ...]  # Runs that are fitted; "[a:b]" after a name is the part from a to b, in thirds
    held_out: tuple[str, ...]  # Runs by which exidyn decides
    judges: tuple[str, ...] = ()  # Runs that judge; by default those held out, where there are no others
    mjcf: str = ""  # File of the arm, below the folder of data; empty if `text` has it
    text: str = ""  # Text of the file
    commands: str = TORQUE  # What drives the simulation, `POSITION` or `TORQUE`
    gain: tuple[float, ...] = ()  # Drive gains; empty where torque was logged, or nothing [N m per unit]
    joints: tuple[str, ...] = ()  # Names of the joints that move; empty for all
    columns: Mapping[str, Any] = field(default_factory=dict)  # Options of the import


def pendulum(mass: float, length: float, arm: float, servo: Mapping[str, Any]) -> str:
    """A point mass [kg] on an arm of a length [m] and a mass [kg], with the joint and servo of a class."""
    total = mass + arm
    center = (mass + 0.5 * arm) * length / total
    inertia = mass * length**2 + arm * length**2 / 3.0 - total * center**2
    return PENDULUM.format(**servo, mass=total, center=-center, inertia=max(inertia, 1e-4), length=-length)


def with_servos(text: str, stiffness: float, damping: float) -> str:
    """A file with the position servos of a controller in place of its motors, of the same limits."""
    spec = mujoco.MjSpec.from_string(text)
    for motor in spec.actuators:
        limits = list(motor.ctrlrange)
        motor.set_to_position(kp=stiffness, kv=damping)
        motor.ctrllimited, motor.forcelimited, motor.forcerange = False, True, limits
    spec.compile()
    return str(spec.to_xml())


def by_joint(position: Sequence[str]) -> dict[str, Any]:
    """Options of the import of a log whose columns are q_NAME and cmd_NAME, without effort."""
    columns = {
        "position": [f"q_{name}" for name in position],
        "command": [f"cmd_{name}" for name in position],
    }
    return {"effort": "command", "columns": columns}


def _feetech(mass: int, length: int) -> Recorded:
    """The Feetech servo with a known mass on a known arm."""
    run = f"m{mass}_l{length}_{{}}_kp{{}}".format
    return Recorded(
        f"STS3215, {mass} g at {length} mm", "kscale_sts3215",
        (run("sin_sin", 16), run("sin_time_square", 16), run("up_and_down", 16)), (run("sin_sin", 24),),
        text=pendulum(1e-3 * mass, 1e-3 * length, ARM_MASS[length], FEETECH), gain=(SERVO_GAIN,),
    )  # fmt: skip


SERVOS = tuple(_feetech(*size) for size in PENDULUMS)
XL330 = Recorded(
    "XL330", "bam_xl330", ("kp200_sin_sin",), ("kp200_sin_time_square",), ("kp200_up_and_down",),
    text=pendulum(0.49, 0.1, 0.0, DYNAMIXEL), commands=POSITION, columns={"effort": "command"},
)  # fmt: skip
ARMS = (
    XL330,
    Recorded(
        "SO-101", "sage_so101", ("multisine",), ("large_amplitude",), ("figure_eight",),
        mjcf="sage_so101/so101.xml", commands=POSITION, columns=by_joint(SO101),
    ),
    Recorded(
        "Go2 legs", "go2_legs", ("legs[0:1]",), ("legs[1:2]",), ("legs[2:3]",), mjcf="go2_legs/go2.xml",
        commands=POSITION, joints=tuple(f"{name}_joint" for name in GO2), columns=by_joint(GO2),
    ),
    Recorded(
        "UR10e", "ur10e_mamedov", ("id_ur-20_02_10-30sec_12harm",), ("id_ur-20_02_12-50sec_12harm",),
        ("id_ur-20_02_05-20sec_12harm",), mjcf="mjcf/ur10e.xml", gain=tuple(DE_LUCA),
    ),
    Recorded(
        "Panda", "panda_gaz", ("traj1[0:2]",), ("traj1[2:3]",), mjcf="mjcf/panda_nohand.xml",
    ),
)  # fmt: skip
