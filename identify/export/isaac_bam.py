"""Isaac Lab on Newton: servos with BAM's motor and friction, as `BamActuatorCfg`.

Isaac Lab has M1, M2, M5 and M6. M5 with equal coefficients of motor and external torque is M3.
"""

from textwrap import indent

from exidyn.quoting import python_text

from .bam import FEATURES as BAM_FEATURES
from .bam import BamServo, bam_servos
from .portable import Portable
from .python_code import call, number, patterns, steps

FEATURES = (*BAM_FEATURES, "delay")
HEAD = '''"""Servos of an arm for Isaac Lab (Newton), by exidyn; SI units at the joints, on a supply of 1 V.

ArticulationCfg(..., actuators=ACTUATORS), with use_newton_actuators=True and the MJWarp solver.
"""

from isaaclab.actuators.actuator_bam_cfg import BamActuatorCfg, BamMotorCfg

ROBOT = {name}
PHYSICS_STEP = 0.005  # sim.dt [s]: put that of your simulation here
ACTUATORS = {{
{actuators}
}}
'''


def isaac_bam(portable: Portable) -> str:
    """Python for Isaac Lab's `BamActuatorCfg`: a servo per joint with friction and delay; no bodies."""
    entries = [
        f"{python_text(joint)}: {_actuator(portable, place, servo)},"
        for place, (joint, servo) in enumerate(zip(portable.robot.joints, bam_servos(portable), strict=True))
    ]
    return HEAD.format(name=python_text(portable.robot.name), actuators=indent("\n".join(entries), "    "))


def _actuator(portable: Portable, place: int, servo: BamServo) -> str:
    arguments = {
        "joint_names_expr": f"[{patterns([portable.robot.joints[place]])[0]}]",
        "motor": call("BamMotorCfg", _motor(servo)),
        "kp_fw": "1.0",
        "vin": "1.0",
        "armature": number(servo.armature),
    }
    if delay := portable.law.delay[place]:
        arguments |= {"min_delay": steps(delay), "max_delay": steps(delay)}
    return call("BamActuatorCfg", arguments)


def _motor(servo: BamServo) -> dict[str, str]:
    """Arguments of `BamMotorCfg`; a current limit of 0 is none."""
    model = "m5" if servo.load else "m2" if servo.stribeck else "m1"
    numbers = {
        "kt": servo.kt, "resistance": servo.resistance, "error_gain": servo.error_gain, "max_current": 0.0,
        "friction_base": servo.coulomb, "friction_viscous": servo.viscous,
    }  # fmt: skip
    if servo.stribeck:
        numbers |= {"friction_stribeck": servo.stribeck, "dtheta_stribeck": servo.fade}
        numbers |= {"alpha": servo.exponent}
    if servo.load:
        numbers |= {"load_friction_motor": servo.load, "load_friction_external": servo.load}
    return {"model": python_text(model)} | {name: number(value) for name, value in numbers.items()}
