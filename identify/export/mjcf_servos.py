"""Position servos of an MJCF: identified gains, unchanged damping, and servos in place of a controller.

In logs without current, the position error takes its place, and a drive gain is the kp of a servo. The
damping of the servo is then part of the identified viscous friction, so its own damping becomes zero. Other
servos keep their damping, which MuJoCo derives from the inertia if the file has a `dampratio`.

Policies of legged robots command positions, and a program computes the torque of the file's motors from
them: kp (command - position) - kd velocity. A simulation with the same law needs servos. They replace the
motors during the simulation only: the motors are restored in the text that users get.
"""

from collections.abc import Collection, Iterator, Sequence
from typing import Any

import numpy as np

from ..arm.robot import Robot, ServoLaw
from ..errors import RobotError
from ..robot_files.mjcf import compile_mjcf
from ..robot_files.mjcf_dcmotors import is_dc_motor
from ..robot_files.mjcf_drives import is_motor, motors, servo_law, servos
from ..robot_files.mjcf_elements import actuators, name_of
from ..text_table import NORMAL_95
from .changes import DIGITS, SAME, Change, nearly_equal, number_words
from .mjcf_changes import File
from .portable import Portable
from .xml_text import Edits, Elements, Tag, actuator_tags, element_end, read_tags


def servo_changes(file: File, portable: Portable, edits: Edits) -> Iterator[Change]:
    """Write the stiffness of all servos, if the drives of robot and file are servos; yields the changes."""
    robot = portable.robot
    for place, (actuator, stiffness) in enumerate(written_servos(file.compiled, robot).items()):
        where = f"actuator '{name_of(file.compiled, 'actuator', actuator)}'"
        old, damping = _gains(file.compiled, actuator)
        new = stiffness / float(file.compiled.actuator_gear[actuator][0]) ** 2
        if nearly_equal(old, new) and not damping:
            continue
        _set_gains(edits, file.elements.tag("actuator", actuator), new, 0.0)
        half = NORMAL_95 * float(robot.drive_gain_tolerance[place]) * new
        yield Change(where, "kp", robot.unit(place, "N m/rad"), old, new, half)
        if damping:
            unit = robot.unit(place, "N m s/rad")
            yield Change(where, "kv", unit, damping, 0.0, np.inf, "now in damping")


def written_servos(compiled: Any, robot: Robot) -> dict[int, float]:
    """Servos whose gains are written -> stiffness at the joint [N m/rad].

    They are those of all joints, if the drives of the robot are servos.
    """
    if robot.servo is None:
        return {}
    stiffness = (np.abs(robot.drive_gain) * robot.servo.gain).tolist()
    return dict(zip(servos(compiled, robot.joints), stiffness, strict=False))


def keep_damping(file: File, new: Any, written: Collection[int], edits: Edits) -> Iterator[Change]:
    """Write the original damping of servos if the changes have altered it; yields the changes."""
    old = file.compiled
    for actuator in actuators(old):
        original, altered = (_gains(model, actuator)[1] for model in (old, new))
        tag = file.elements.find("actuator", actuator)
        if tag is None or tag.name not in ("position", "intvelocity", "general"):
            continue  # in an included file, or without a position gain
        if actuator not in written and not nearly_equal(original, altered):
            if tag.name == "general":  # MuJoCo takes a positive third number for a dampratio
                offset, stiffness = old.actuator_biasprm[actuator][:2]
                edits.set(tag, biasprm=f"{offset:.{DIGITS}g} {stiffness:.{DIGITS}g} {-original:.{DIGITS}g}")
            else:
                edits.set(tag, dampratio=None, kv=f"{original:.{DIGITS}g}")
            where = f"servo '{name_of(old, 'actuator', actuator)}', instead of dampratio"
            yield Change(where, "kv", "N m s/rad", altered, original, 0.0)


def altered_damping(old: Any, new: Any, written: Collection[int]) -> list[str]:
    """Sentences about servos of included files, whose damping MuJoCo computes from the new inertia."""
    unwritten = [a for a in actuators(old) if a not in written and not is_dc_motor(old, a)]
    pairs = [(a, _gains(old, a)[1], _gains(new, a)[1]) for a in unwritten]
    return [
        f"dampratio of servo '{name_of(old, 'actuator', actuator)}' in an included file gives it kv "
        f"{after:.4g} instead of {before:.4g}; write kv there"
        for actuator, before, after in pairs
        if not nearly_equal(before, after)
    ]


def require_servos(compiled: Any, robot: Robot, where: str) -> None:
    """Raise `RobotError` unless the servos compiled from the new text have the intended gains."""
    for actuator, wanted in written_servos(compiled, robot).items():
        kp, damping = _gains(compiled, actuator)
        made = kp * float(compiled.actuator_gear[actuator][0]) ** 2
        if abs(made - wanted) > SAME * wanted or damping:
            raise RobotError(
                f"{where}: actuator '{name_of(compiled, 'actuator', actuator)}' has kp {made:.4g} and kv "
                f"{damping:.4g} in MuJoCo, not {wanted:.4g} and 0 as in its element"
            )


def _gains(compiled: Any, actuator: int) -> tuple[float, float]:
    """The kp and kv of a servo."""
    return float(compiled.actuator_gainprm[actuator][0]), -float(compiled.actuator_biasprm[actuator][2]) + 0.0


def _set_gains(edits: Edits, tag: Tag, kp: float, kv: float) -> None:
    """Write the gains of a servo, at its actuator."""
    stiffness = f"{kp:.{DIGITS}g}"
    if tag.name == "position":
        edits.set(tag, kp=stiffness, kv=f"{kv:.{DIGITS}g}", dampratio=None)
    else:
        edits.set(tag, gainprm=stiffness, biasprm=f"0 -{stiffness} {0.0 - kv:.{DIGITS}g}")


def with_servo_law(
    text: bytes, folder: str, where: str, joints: Sequence[str], law: ServoLaw, changed: Collection[str]
) -> bytes:
    """The text with the servos of a law; servos that have its numbers already stay as they are.

    `changed` are fields of the law. Raises `RobotError` if the file has no servo for every joint, or compiles
    to other numbers.
    """
    compiled = compile_mjcf(text.decode(), folder)
    if "delay" in changed and not hasattr(compiled, "actuator_delay"):
        raise RobotError(f"{where}: delays of actuators need MuJoCo 4.0 or later")
    old = servo_law(compiled, joints)
    if old is None:
        raise RobotError(f"{where} has no position servo for every joint")
    elements, edits = Elements(read_tags(text, where), compiled, where), Edits(text)
    for place, actuator in enumerate(servos(compiled, joints)):
        tag, gear = elements.tag("actuator", actuator), float(compiled.actuator_gear[actuator, 0])
        new = {name: float(getattr(law, name)[place]) for name in changed}
        differing = [name for name in changed if not nearly_equal(new[name], getattr(old, name)[place])]
        if {"stiffness", "damping"}.intersection(differing):
            _set_gains(edits, tag, law.stiffness[place] / gear**2, law.damping[place] / gear**2)
        if "limit" in differing:
            limit = f"{new['limit'] / abs(gear):.{DIGITS}g}"
            edits.set(tag, forcerange=f"-{limit} {limit}", forcelimited="true")
        if "delay" in differing:
            samples = int(np.ceil(new["delay"] / float(compiled.opt.timestep))) + 1
            edits.set(tag, delay=f"{new['delay']:.{DIGITS}g}", nsample=str(samples), interp="linear")
    made = servo_law(compile_mjcf(edits.text().decode(), folder), joints)
    for name in changed:
        for place, joint in enumerate(joints):
            wanted = float(getattr(law, name)[place])
            if made is None or not nearly_equal(getattr(made, name)[place], wanted):
                raise RobotError(
                    f"{where}: MuJoCo compiles another {name} of the servo of joint '{joint}' than the "
                    f"{wanted:.4g} that was written. Remove what overrides it"
                )
    return edits.text()


def with_controller(
    text: bytes, folder: str, where: str, joints: Sequence[str], kp: np.ndarray, kd: np.ndarray
) -> bytes:
    """The text of an MJCF with position servos in place of the motors of some joints.

    `folder` is that of the files that it refers to, and `where` its name in errors. The controller has a
    torque `kp` per position error (n,) [N m/rad], and `kd` against the velocity (n,) [N m s/rad].
    """
    compiled, root = compile_mjcf(text.decode(), folder), read_tags(text, where)
    chosen = [_motor_of(compiled, joint, where) for joint in joints]
    text = _renamed(text, [Elements(root, compiled, where).tag("actuator", actuator) for actuator in chosen])
    edits, elements = Edits(text), Elements(read_tags(text, where), compiled, where)
    for actuator, *gains in zip(chosen, kp, kd, strict=True):
        edits.set(elements.tag("actuator", actuator), **_servo(compiled, actuator, *map(float, gains)))
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


def _renamed(text: bytes, tags: Sequence[Tag]) -> bytes:
    """The text with these elements called <general>, which has all attributes of a motor."""
    for tag in sorted(tags, key=lambda tag: tag.start, reverse=True):
        end, old = element_end(text, tag), tag.name.encode()
        element = b"<general" + text[tag.start + 1 + len(old) : end].replace(b"</" + old, b"</general")
        text = text[: tag.start] + element + text[end:]
    return text


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
