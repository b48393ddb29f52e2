"""A robot.toml with a comment above each key that gives its meaning and unit."""

import inspect
import re
import sys
import textwrap
from collections.abc import Iterator

from exidyn.quoting import hash_comment, one_line

from ..effects import Effect
from ..measurements import Measurement
from ..model import Model
from .robot_text import RIGID_BODY, model_text

Row = Effect | Measurement

WIDTH = 100
"""Maximum length of a comment line in characters."""
HEAD = (
    "Nominal model of one arm: its values before any identification. All values are in SI units and refer to "
    "the joint, behind the gear; lists have one number per joint, base to tip. All keys: docs/robot-toml.md."
)
TABLES = {
    "[limits]": "Limits of the arm; planned motions and runs stay within them.",
    "[drive]": "Conversion of motor currents to joint torques.",
    "[flange]": "Mounting frame of payloads, in the last link's frame.",
    "[[link]]": "A joint, and the body that it moves. The keys of the other links have the same meaning.",
    "[[measurement]]": "Effects of the measurement on recordings; fits remove them.",
    "[prior]": "Single parameters: value, or [value, standard deviation].",
}
KEYS = {
    ("", "format"): "version of this format",
    ("", "name"): "name of the robot",
    ("", "gravity"): "in the base frame [m/s^2]; turn it for an arm on a wall or ceiling",
    (
        "",
        "inertial_tolerance",
    ): "relative standard deviation of the links' masses and inertias",
    ("", "rigid_body"): "whether the links' inertia and gravity are in the model",
    ("[limits]", "position_lower"): "minimum position [rad; m for a prismatic joint]",
    ("[limits]", "position_upper"): "maximum position [rad; m]",
    ("[limits]", "velocity"): "maximum velocity [rad/s; m/s]",
    ("[limits]", "acceleration"): "maximum acceleration [rad/s^2; m/s^2]",
    ("[limits]", "jerk"): "maximum jerk [rad/s^3; m/s^3]",
    ("[limits]", "torque"): "maximum torque of the joint [N m; N]",
    ("[limits]", "velocity_lower"): "minimum velocity, negative [rad/s; m/s]",
    ("[limits]", "acceleration_lower"): "minimum acceleration, negative [rad/s^2; m/s^2]",
    ("[drive]", "gain"): "joint torque per unit of current, with its sign [N m/A; N/A]",
    ("[drive]", "gain_tolerance"): "relative standard deviation of the gains",
    (
        "[drive]",
        "gain_in_inertias",
    ): "whether inertias were identified from currents with these gains: their errors are then correlated",
    ("[drive]", "gear_ratio"): "turns of the motor per turn of the joint [-]",
    ("[drive]", "direct_drive"): "joints whose motor has no gear",
    ("[drive]", "passive"): "joints without a motor: their torque is zero",
    ("[drive]", "servo_gain"): (
        "gain of position servos, for logs without currents: position error [rad] times this replaces the "
        "current, and gain is torque per unit of that; 1 if gain is in N m/rad"
    ),
    ("[drive]", "servo_limit"): "position error at which a servo saturates [rad]; inf: not known",
    ("[drive]", "coupling"): "motor velocity over gear ratio = coupling x joint velocity; identity: none [-]",
    ("[flange]", "origin"): "position of the flange [m]",
    ("[flange]", "rotation"): "rotation matrix of the flange [-]",
    ("[[link]]", "joint"): "name of the joint",
    ("[[link]]", "link"): "name of the link that it moves",
    ("[[link]]", "parent"): 'joint whose link carries it; "": the base',
    ("[[link]]", "kind"): '"revolute": turns, "prismatic": slides',
    ("[[link]]", "axis"): "direction of the axis in the joint's frame [-]",
    ("[[link]]", "origin"): "position of the joint's frame in the frame of the parent's link [m]",
    ("[[link]]", "rotation"): "rotation matrix of the joint's frame in that frame [-]",
    ("[[link]]", "mass"): "mass of the link [kg]",
    ("[[link]]", "center_of_mass"): "center of mass in the joint's frame [m]",
    ("[[link]]", "inertia"): "XX, XY, XZ, YY, YZ, ZZ about the center of mass [kg m²]",
    ("[[effect]]", "name"): "name of the effect; valid names are in docs/robot-toml.md",
    ("[[measurement]]", "name"): "name of the measurement; valid names are in docs/robot-toml.md",
    ("[[effect]]", "joints"): "names of the joints it acts on; default: all",
    ("[[effect]]", "std"): "standard deviations of the values, in the same units",
}
"""Table and key -> its meaning and unit."""
ROWS = ("[[effect]]", "[[measurement]]")
"""Tables whose rows are effects or measurements, which have their own fields."""
FORMULA = re.compile(r"\s*:math:`[^`]*`,?")
ATTRIBUTE = re.compile(r"^(\w+): (.*(?:\n[ \t]+.*)*)", re.MULTILINE)


def commented_text(model: Model) -> str:
    """Text of `model_text` with a comment above each key; reading it gives the same model."""
    effects = [effect for effect in model.effects if not effect.of_links or _stated(effect, model)]
    rows: list[Row] = [*effects, *model.measurements]
    return "\n".join([*_comment(HEAD), "", *_lines(model_text(model), model, iter(rows))]) + "\n"


def _stated(effect: Effect, model: Model) -> bool:
    """Whether the rigid body has a row, which a file needs only for its parameters."""
    return f'name = "{RIGID_BODY}"' in model_text(model)


def _lines(text: str, model: Model, effects: Iterator[Row]) -> Iterator[str]:
    """Lines of a robot.toml, with comment lines between them."""
    table, seen, effect = "", set(), None
    for line in text.splitlines():
        if line.startswith("["):
            table = line
            effect = next(effects) if table in ROWS else None
            yield from _comment("" if table in seen else TABLES.get(table, ""))
            yield from _comment(_title(effect) if effect else "")
            explained = table in seen and effect is None
            seen.add(table)
        elif line and (effect or table == "" or not explained):
            yield from _comment(_of_key(table, line.partition(" = ")[0], effect, model))
        yield line


def _of_key(table: str, key: str, effect: Row | None, model: Model) -> str:
    """Meaning of a key of a table."""
    if isinstance(effect, Effect) and key == "values":
        return _parameters(effect, model)
    described = _attributes(effect).get(key, "") if effect is not None else ""
    text = KEYS.get((table, key), "") or described
    return text[:1].upper() + text[1:]


def _title(effect: Row) -> str:
    """First line of the docstring of an effect's module."""
    return (
        (sys.modules[type(effect).__module__].__doc__ or "")
        .partition("\n")[0]
        .replace(" (the paper's section V.B)", "")
    )


def _parameters(effect: Effect, model: Model) -> str:
    """Names and units of an effect's parameters."""
    units: dict[str, list[str]] = {}
    for parameter in effect.parameters(model.robot):
        units.setdefault(parameter.unit, []).append(parameter.name)
    return "Nominal values of " + "; ".join(f"{', '.join(names)} [{unit}]" for unit, names in units.items())


def _attributes(effect: Row) -> dict[str, str]:
    """Descriptions of an effect's fields, from its docstring up to the first full stop or semicolon."""
    descriptions: dict[str, str] = {}
    for kind in reversed(type(effect).__mro__):
        text = inspect.cleandoc(kind.__doc__ or "").partition("Attributes:\n")[2]
        for name, words in ATTRIBUTE.findall(textwrap.dedent(text)):
            plain = FORMULA.sub("", " ".join(words.split()))
            descriptions[name] = re.split(r"[;.](?:\s|$)", plain)[0]
    return descriptions


def _comment(text: str) -> list[str]:
    lines = textwrap.wrap(one_line(text), WIDTH - len(hash_comment("")), break_long_words=False)
    return [hash_comment(line) for line in lines]
