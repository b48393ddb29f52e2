"""The law of position servos, written to the actuators of an MJCF."""

from collections.abc import Collection, Sequence

import numpy as np

from ..arm.servo_law import ServoLaw
from ..errors import RobotError
from ..robot_files.mjcf import compile_mjcf
from ..robot_files.mjcf_drives import servo_law, servos
from .mjcf_changes import DIGITS, nearly_equal
from .mjcf_elements import Elements
from .xml_text import Edits, Tag, read_tags

GAINS = ("stiffness", "damping")


def with_servo_law(
    text: bytes, folder: str, where: str, joints: Sequence[str], law: ServoLaw, changed: Collection[str]
) -> bytes:
    """The text with the servos of a law; servos whose numbers are those of the law already stay as they are.

    Args:
        text: Text of the MJCF.
        folder: Folder of the files that it refers to.
        where: Name of the file in errors.
        joints: Joints of the law.
        law: Law of their servos.
        changed: Fields of the law that are written.

    Raises:
        RobotError: MuJoCo compiles another law, or it has no delays.
    """
    compiled = compile_mjcf(text.decode(), folder)
    if "delay" in changed and not hasattr(compiled, "actuator_delay"):
        raise RobotError(f"{where}: delays of actuators need MuJoCo 4.0 or later")
    old = servo_law(compiled, joints)
    if old is None:
        raise RobotError(f"{where} has no position servo for every joint")
    elements, edits = Elements(read_tags(text, where), compiled, where), Edits(text)
    for place, actuator in enumerate(servos(compiled, joints)):
        differing = {
            name for name in changed if not nearly_equal(getattr(law, name)[place], getattr(old, name)[place])
        }
        gear = float(compiled.actuator_gear[actuator, 0])
        timestep = float(compiled.opt.timestep)
        _write(elements.actuator(actuator), law, place, differing, gear, timestep, edits)
    new = edits.text()
    _require(servo_law(compile_mjcf(new.decode(), folder), joints), law, changed, joints, where)
    return new


def _write(
    tag: Tag, law: ServoLaw, place: int, differing: set[str], gear: float, timestep: float, edits: Edits
) -> None:
    if differing.intersection(GAINS):
        kp, kv = (f"{getattr(law, name)[place] / gear**2:.{DIGITS}g}" for name in GAINS)
        if tag.name == "position":
            edits.set(tag, kp=kp, kv=kv, dampratio=None)
        else:
            edits.set(tag, gainprm=kp, biasprm=f"0 -{kp} -{kv}")
    if "limit" in differing:
        limit = f"{law.limit[place] / abs(gear):.{DIGITS}g}"
        edits.set(tag, forcerange=f"-{limit} {limit}", forcelimited="true")
    if "delay" in differing:
        delay = float(law.delay[place])
        samples = int(np.ceil(delay / timestep)) + 1
        edits.set(tag, delay=f"{delay:.{DIGITS}g}", nsample=str(samples), interp="linear")


def _require(
    made: ServoLaw | None, law: ServoLaw, changed: Collection[str], joints: Sequence[str], where: str
) -> None:
    for name in changed:
        for place, joint in enumerate(joints):
            wanted = float(getattr(law, name)[place])
            if made is None or not nearly_equal(getattr(made, name)[place], wanted):
                raise RobotError(
                    f"{where}: MuJoCo compiles another {name} of the servo of joint '{joint}' than the "
                    f"{wanted:.4g} that was written. Remove what overrides it"
                )
