"""Position servos in place of an MJCF's motors, for arms that a controller outside of the file drives.

Policies of legged robots command positions, and a program computes the torque of the file's motors from
them: kp (command - position) - kd velocity. A simulation with the same law needs servos. They replace the
motors during the simulation only: the motors are restored in the text that users get.
"""

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from ..arm.robot import ServoLaw
from ..errors import RobotError
from ..robot_files.mjcf import compile_mjcf
from ..robot_files.mjcf_drives import is_motor, motors, servo_law, servos
from ..robot_files.mjcf_names import name_of
from .mjcf_changes import DIGITS, nearly_equal, number_words
from .xml_text import Edits, Elements, Tag, actuator_tags, element_end, read_tags


def with_controller(
    text: bytes, folder: str, where: str, joints: Sequence[str], kp: np.ndarray, kd: np.ndarray
) -> bytes:
    """The text of an MJCF with position servos in place of the motors of some joints.

    `folder` is that of the files that it refers to, and `where` its name in errors. The controller has a
    torque `kp` per position error (n,) [N m/rad], and `kd` against the velocity (n,) [N m s/rad].
    """
    compiled, root = compile_mjcf(text.decode(), folder), read_tags(text, where)
    elements = Elements(root, compiled, where)
    chosen = [_motor_of(compiled, joint, where) for joint in joints]
    tags = [elements.actuator(actuator) for actuator in chosen]
    text = _renamed(text, tags)
    edits, elements = Edits(text), Elements(read_tags(text, where), compiled, where)
    for actuator, *gains in zip(chosen, kp, kd, strict=True):
        edits.set(elements.actuator(actuator), **_servo(compiled, actuator, *map(float, gains)))
    return edits.text()


def with_motors(text: bytes, original: bytes, where: str) -> bytes:
    """A text that was made from one with servos, with the actuators of the original."""
    new, old = (actuator_tags(read_tags(each, where)) for each in (text, original))
    for tag, before in reversed(list(zip(new, old, strict=True))):
        end = element_end(text, tag)
        text = text[: tag.start] + original[before.start : element_end(original, before)] + text[end:]
    return text


def _motor_of(compiled: Any, joint: str, where: str) -> int:
    """Index of the motor of a joint."""
    candidates = motors(compiled, joint)
    if len(candidates) != 1 or not is_motor(compiled, candidates[0]):
        others = ", ".join(f"'{name_of(compiled, 'actuator', actuator)}'" for actuator in candidates)
        raise RobotError(
            f"{where}: a controller (--kp, --kd) needs exactly one motor at joint '{joint}'; the file has "
            f"{others or 'no actuator'}. Position servos of the file have their own kp and kv"
        )
    return candidates[0]


def _servo(compiled: Any, actuator: int, kp: float, kd: float) -> dict[str, str]:
    """Attributes of a <general> that is a servo with the torque limits of a motor."""
    gear, gain = (float(table[actuator][0]) for table in (compiled.actuator_gear, compiled.actuator_gainprm))
    low, high = -np.inf, np.inf
    if compiled.actuator_forcelimited[actuator]:
        low, high = compiled.actuator_forcerange[actuator]
    if compiled.actuator_ctrllimited[actuator]:
        ends = np.sort(gain * compiled.actuator_ctrlrange[actuator])
        low, high = max(low, ends[0]), min(high, ends[1])
    limit = {"forcelimited": "true", "forcerange": number_words([low, high])} if np.isfinite(high) else {}
    kp, kd = kp / gear**2, kd / gear**2
    return {
        "ctrllimited": "false", "gaintype": "fixed", "gainprm": number_words([kp]),
        "biastype": "affine", "biasprm": number_words([0.0, -kp, -kd]), **limit,
    }  # fmt: skip


def _renamed(text: bytes, tags: Sequence[Tag]) -> bytes:
    """The text with these elements called <general>, which has all attributes of a motor."""
    for tag in sorted(tags, key=lambda tag: tag.start, reverse=True):
        end, old = element_end(text, tag), tag.name.encode()
        element = b"<general" + text[tag.start + 1 + len(old) : end].replace(b"</" + old, b"</general")
        text = text[: tag.start] + element + text[end:]
    return text


GAINS = ("stiffness", "damping")


def with_servo_law(
    text: bytes, folder: str, where: str, joints: Sequence[str], law: ServoLaw, changed: Collection[str]
) -> bytes:
    """The text with the servos of a law; servos that have its numbers already stay as they are."""
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
