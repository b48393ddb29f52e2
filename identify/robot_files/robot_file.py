"""Read a robot: a robot.toml (docs/robot-toml.md), a bare URDF or MJCF, or a built-in robot by its name."""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from ..arm.newton_euler import joints_of
from ..arm.robot import FLANGE, Held, Limits, PositionServo, Robot
from ..errors import RobotError, RobotWarning
from ..file_names import looked_in
from ..model import Model
from . import toml_fields as toml
from .description import NAMED, is_description, read_kinematics
from .effect_rows import read_effects, read_measurements, read_priors
from .kinematics import Kinematics, link_kinematics, read_placement
from .mdh import mdh_kinematics, parse_mdh
from .robot_keys import KEYS
from .robot_text import FORMAT, RIGID_BODY, model_text, urdf_text
from .urdf import pinocchio_kinematics, read_choice, read_held

__all__ = ["builtin_names", "described_model", "model_text", "parse_model", "read_model", "urdf_text"]

DESCRIPTIONS = ("urdf", "mjcf")
"""Keys for the file that describes the arm; either accepts any kind of description."""
SOURCES = (*DESCRIPTIONS, "mdh", "link")
AROUND = ("obstacle", "region", "finding")
"""Rows that the model does not need: what stands around the arm, and what a diagnosis found."""
LIMIT_KEYS = tuple(f.name for f in fields(Limits))
BACKWARD_KEYS = ("velocity_lower", "acceleration_lower")
"""Limits of backward motion; by default the negative of the forward limits."""
USUAL_EFFECTS = ("rotor_inertia", "viscous_friction", "coulomb_friction", "current_offset")
"""Effects of nearly every geared arm, and so the default for a URDF or MDH table that names no effects."""
STRONGEST_GRAVITY = 30.0
"""Maximum gravity [m/s^2]: three times that of the Earth, and more than Jupiter's 24.8."""


def builtin_names() -> list[str]:
    """Names of the robots that come with exidyn."""
    files = resources.files(__package__).joinpath("robots").iterdir()
    return sorted(file.name.removesuffix(".toml") for file in files if file.name.endswith(".toml"))


def read_model(
    source: str | Path | pin.Model, joints: Sequence[str] | None = None, held: Held = MappingProxyType({})
) -> Model:
    """Model from a robot.toml, from a .urdf, .xacro or MJCF, or from the name of a built-in robot.

    Args:
        source: Path of the file, name of the robot, or a Pinocchio model, which then is the description.
        joints: Joints of a .urdf, .xacro or MJCF that move; the others are held. None: all except `held`.
        held: Joints of a .urdf, .xacro or MJCF that are held away from zero, and their positions [rad, m].

    Warns:
        RobotWarning: A link's mass or inertia is impossible, or a nominal value is below its minimum.

    Raises:
        RobotError: The robot or file does not exist, or is wrong.
    """
    if isinstance(source, pin.Model):
        return described_model(source.name, pinocchio_kinematics(source))
    if str(source) in builtin_names():
        return parse_model(
            resources.files(__package__).joinpath("robots", f"{source}.toml").read_text("utf-8")
        )
    path = Path(source)
    if not path.exists():
        raise RobotError(
            f"no robot or file called '{source}'{looked_in(path)}. Built-in robots: "
            f"{', '.join(builtin_names())}; or give the path of a robot.toml, or of a {NAMED}"
        )
    if is_description(path):
        kinematics = read_kinematics(path, joints, held)
        model, doubts = described_model(path.stem, kinematics), kinematics.doubts
    else:
        model, doubts = _parse(toml.read_text(path), path.parent, str(path))
        doubts = (*doubts, *_value_doubts(model, str(path)))
    for doubt in (*doubts, *(f"{path}: {doubt}" for doubt in model.robot.body_units.doubts)):
        warnings.warn(doubt, RobotWarning, stacklevel=2)
    return model


def described_model(name: str, kinematics: Kinematics) -> Model:
    """Model from a description alone: a robot and its effects."""
    limits = kinematics.limits or Limits.none(kinematics.model.nv)
    robot = Robot(
        name,
        kinematics.model,
        limits,
        flange=kinematics.flange,
        flange_name=kinematics.flange_name,
        coupling=kinematics.coupling,
        held=kinematics.held,
        gear_ratio=kinematics.gear_ratio,
        inertias_stated=False,
    )
    return Model(robot, *read_effects(_effect_rows({}, kinematics, robot), robot))


def parse_model(text: str, folder: Path | None = None) -> Model:
    """Model from the text of a robot.toml.

    Args:
        text: Text of the file.
        folder: Folder of the files that it names; by default the current folder.

    Raises:
        RobotError: The text is wrong; the message names the key, its value and what is valid.
    """
    return _parse(text, folder, "robot file")[0]


def _parse(text: str, folder: Path | None, where: str) -> tuple[Model, tuple[str, ...]]:
    """Model, and doubts about its geometry and bodies."""
    table = toml.parse_toml(text, where)
    toml.check_keys(table, KEYS[""], where)
    if table.get("format", FORMAT) != FORMAT:
        raise RobotError(f"{where}: format {table['format']!r}; this version reads format {FORMAT}")
    kinematics = _kinematics(table, folder or Path(), where)
    robot = _robot(table, kinematics)
    effects, stated = read_effects(_effect_rows(table, kinematics, robot), robot)
    stated |= read_priors(table.get("prior", {}), Model(robot, effects).names)
    measurements = read_measurements(toml.rows(table, "measurement"), robot)
    return Model(robot, effects, stated, measurements=measurements), kinematics.doubts


def _kinematics(table: Mapping[str, Any], folder: Path, where: str) -> Kinematics:
    sources = [key for key in SOURCES if key in table]
    if len(sources) != 1:
        raise RobotError(f"{where}: give exactly one of {', '.join(SOURCES)}; found {sources or 'none'}")
    name = toml.string(table.get("name", "robot"), "name")
    source, value = sources[0], table[sources[0]]
    chosen = [key for key in ("joints", "held") if key in table]
    copied = source == "link" and chosen == ["held"]  # of the description from which the rows were made
    if chosen and source not in DESCRIPTIONS and not copied:
        raise RobotError(
            f"{where}: {chosen[0]} selects joints of a urdf or mjcf; all rows of {source} are used"
        )
    if source == "link":
        kinematics = link_kinematics(toml.tables(value, "link"), name)
        return replace(kinematics, held=read_held(table.get("held", {}), where))
    if source == "mdh" and not isinstance(value, str):
        return mdh_kinematics(toml.tables(value, "mdh"), name)
    path = folder / toml.string(value, source)
    if source == "mdh":
        return parse_mdh(toml.read_text(path), name, str(path))
    moving, held = read_choice(table, where)
    return read_kinematics(path, moving, held)


def _robot(table: Mapping[str, Any], kinematics: Kinematics) -> Robot:
    model = kinematics.model
    model.name = toml.string(table.get("name", model.name), "name")
    if "gravity" in table:
        model.gravity = pin.Motion(_gravity(table["gravity"]), np.zeros(3))
    known: dict[str, Any] = {"coupling": kinematics.coupling, "gear_ratio": kinematics.gear_ratio}
    known["flange"], known["flange_name"] = _flange(table, kinematics)
    known |= _drive(table.get("drive", {}), model.nv)
    known["inertias_stated"] = "inertial_tolerance" in table
    if known["inertias_stated"]:
        known["inertial_tolerance"] = toml.number(table["inertial_tolerance"], "inertial_tolerance", 0.0)
    revolute = np.array([joint.revolute for joint in joints_of(model)])
    limits = _limits(table.get("limits", {}), kinematics.limits or Limits.none(model.nv), revolute)
    return Robot(model.name, model, limits, held=kinematics.held, **known)


def _flange(table: Mapping[str, Any], kinematics: Kinematics) -> tuple[pin.SE3, str]:
    """Placement and name of the flange: as stated, that of a named link, or that of the description."""
    if "flange" not in table:
        return kinematics.flange, kinematics.flange_name
    stated, model = table["flange"], kinematics.model
    toml.check_keys(stated, KEYS["[flange]"], "[flange]")
    name = toml.string(stated.get("frame", FLANGE), "[flange] frame")
    if set(stated) != {"frame"}:
        return read_placement(stated, "[flange]"), name
    links = {f.name: f.placement for f in model.frames if f.parentJoint == model.njoints - 1}
    if name not in links:
        raise RobotError(f"[flange] frame: {name!r}; valid, moved by the last joint: {', '.join(links)}")
    return pin.SE3(links[name]), name


def _drive(table: Mapping[str, Any], n: int) -> dict[str, Any]:
    """Arguments of `Robot` that describe its drives."""
    toml.check_keys(table, KEYS["[drive]"], "[drive]")
    known: dict[str, Any] = {}
    if "gain_tolerance" in table:
        known["drive_gain_tolerance"] = toml.numbers(
            table["gain_tolerance"], n, "[drive] gain_tolerance", 0.0
        )
    for key, name in (("gain", "drive_gain"), ("gear_ratio", "gear_ratio")):
        if key not in table:
            continue
        known[name] = toml.numbers(table[key], n, f"[drive] {key}")
        if not np.all(known[name]):
            raise RobotError(f"[drive] {key}: {known[name].tolist()} has a zero; give 1 where it is unknown")
    if "gain_in_inertias" in table:
        known["inertias_by_gain"] = toml.boolean(table["gain_in_inertias"], "[drive] gain_in_inertias")
    for key in ("direct_drive", "passive"):
        if key in table:
            known[key] = tuple(toml.strings(table[key], f"[drive] {key}"))
    if (servo := _servo(table, n)) is not None:
        known["servo"] = servo
    if "coupling" in table:
        known["coupling"] = toml.matrix(table["coupling"], n, "[drive] coupling")
    return known


def _servo(table: Mapping[str, Any], n: int) -> PositionServo | None:
    """Position servos; None if `[drive]` has no `servo_gain`."""
    if "servo_gain" not in table:
        if "servo_limit" in table:
            raise RobotError("[drive] servo_limit: give servo_gain too; 1 where [drive] gain is in N m/rad")
        return None
    gain = toml.numbers(table["servo_gain"], n, "[drive] servo_gain", 0.0)
    limit = toml.numbers(table.get("servo_limit", np.inf), n, "[drive] servo_limit", 0.0, infinite=True)
    for key, values in (("servo_gain", gain), ("servo_limit", limit)):
        if not np.all(values > 0.0):
            raise RobotError(f"[drive] {key}: {values.tolist()} has a zero; expected numbers above 0")
    return PositionServo(gain, limit)


def _limits(table: Mapping[str, Any], described: Limits, revolute: np.ndarray) -> Limits:
    """Limits of the file, else those of its description; `revolute` (n,) marks the revolute joints."""
    toml.check_keys(table, KEYS["[limits]"], "[limits]")
    degrees = toml.boolean(table.get("degrees", False), "[limits] degrees")
    known = {key: getattr(described, key) for key in LIMIT_KEYS if key not in BACKWARD_KEYS}
    for key in LIMIT_KEYS:
        if key in table:
            low = 0.0 if key not in ("position_lower", "position_upper", *BACKWARD_KEYS) else -np.inf
            known[key] = toml.numbers(table[key], len(revolute), f"[limits] {key}", low, infinite=True)
            if key in BACKWARD_KEYS and np.any(known[key] > 0.0):
                raise RobotError(
                    f"[limits] {key}: {known[key].tolist()}; a limit of backward motion is negative"
                )
            if degrees and key != "torque":
                known[key] = np.where(revolute, np.radians(known[key]), known[key])
    for joint, (lower, upper) in enumerate(
        zip(known["position_lower"], known["position_upper"], strict=True)
    ):
        if lower >= upper:
            raise RobotError(
                f"[limits]: joint {joint + 1}: position_lower {lower:g} is not below position_upper {upper:g}"
            )
    return Limits(**known)


def _effect_rows(table: Mapping[str, Any], kinematics: Kinematics, robot: Robot) -> list[Mapping[str, Any]]:
    """Rows of the file, preceded by implied rows: the rigid body, and rotors of an MDH table.

    A file with `[[link]]` rows states all its effects. A URDF or MDH table has only bodies and gets the usual
    effects, for which an MJCF may have values.
    """
    stated, rows = table.get("effect"), toml.rows(table, "effect")
    usual: tuple[str, ...] = USUAL_EFFECTS if stated is None and "link" not in table else ()
    named = [row.get("name") for row in rows]
    implied: list[Mapping[str, Any]] = []
    if RIGID_BODY not in named and toml.boolean(table.get("rigid_body", True), "rigid_body"):
        implied.append({"name": RIGID_BODY})
    if kinematics.rotor_inertia and "rotor_inertia" not in named:
        rotors = kinematics.rotor_inertia
        everywhere = {} if set(rotors) == set(robot.joints) else {"joints": list(rotors)}
        tolerance = robot.inertial_tolerance
        implied.append(
            {"name": "rotor_inertia", "values": list(rotors.values()), "tolerance": tolerance, **everywhere}
        )
        others = [joint for joint in robot.joints if joint not in rotors]
        usual = tuple(name for name in usual if name != "rotor_inertia")
        if others and stated is None:
            implied.append({"name": "rotor_inertia", "joints": others})
    described = None
    if usual and kinematics.effects is not None:
        described = [_per_motor_turn(row, kinematics, robot) for row in kinematics.effects]
    return implied + list(described or [{"name": name} for name in usual]) + rows


def _per_motor_turn(row: Mapping[str, Any], kinematics: Kinematics, robot: Robot) -> Mapping[str, Any]:
    """Row of a description, with waves per turn of the robot's motor if its gear ratio is another."""
    if "harmonic" not in row:
        return row
    place = robot.index(row["joints"][0])
    share = float(abs(kinematics.gear_ratio[place] / robot.gear_ratio[place]))
    cosine, sine = row["values"]
    sign = float(np.sign(kinematics.gear_ratio[place] * robot.gear_ratio[place]))
    return {**row, "harmonic": share * row["harmonic"], "values": [cosine, sign * sine]}


def _gravity(value: object) -> np.ndarray:
    """Gravity in the frame of the base, at most `STRONGEST_GRAVITY`, shape (3,) [m/s^2]."""
    if not isinstance(value, list | tuple):
        raise RobotError(
            f"gravity: expected a vector in the frame of the base, such as [0.0, 0.0, -9.81]; found {value!r}"
        )
    gravity = toml.numbers(value, 3, "gravity")
    if (size := float(np.linalg.norm(gravity))) > STRONGEST_GRAVITY:
        raise RobotError(
            f"gravity: {size:g} m/s^2; it is at most {STRONGEST_GRAVITY:g}. On the Earth it is 9.81"
        )
    return gravity


def _value_doubts(model: Model, where: str) -> Iterator[str]:
    """Warnings about nominal values below their physical minimum."""
    for effect in model.effects:
        friction = "friction" in type(effect).__name__.lower()
        why = "friction takes energy out of a motion" if friction else "no body or spring has less"
        for parameter in effect.parameters(model.robot):
            stated = model.stated.get(parameter.name)
            if stated is not None and stated.value < parameter.minimum:
                yield (
                    f"{where}: {parameter.name} = {stated.value:g} {parameter.unit}; it is at least "
                    f"{parameter.minimum:g}, as {why}"
                )
