"""A robot.toml in which a comment above each key says what it is, and its unit."""

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
"""Characters of a line of comment, at most."""
HEAD = (
    "Nominal values of one arm: what is known before anything is measured. Everything is in SI units and "
    "at the joint, behind the gear; lists have one number a joint, base to tip. All keys: docs/robot-toml.md."
)
TABLES = {
    "[limits]": "What the arm may do; planned motions and runs stay within.",
    "[drive]": "What turns motor currents into joint torques.",
    "[flange]": "Where payloads hang, seen from the last link's frame.",
    "[[link]]": "A joint, and the body that it moves. The keys of the other links mean the same.",
    "[[measurement]]": "What lies between the arm and its recordings; fits take it out of them.",
    "[prior]": "Single parameters: value, or [value, standard deviation].",
}
KEYS = {
    ("", "format"): "version of this format",
    ("", "name"): "what people call the robot",
    ("", "gravity"): "in the base frame [m/s^2]; turn it for an arm on a wall or ceiling",
    (
        "",
        "inertial_tolerance",
    ): "how far masses and inertias of links may be off: standard deviation, as a share",
    ("", "rigid_body"): "whether the links' inertia and gravity are in the model",
    ("[limits]", "position_lower"): "least position [rad; m where a joint slides]",
    ("[limits]", "position_upper"): "greatest position [rad; m]",
    ("[limits]", "velocity"): "greatest velocity [rad/s; m/s]",
    ("[limits]", "acceleration"): "greatest acceleration [rad/s^2; m/s^2]",
    ("[limits]", "jerk"): "greatest change of acceleration [rad/s^3; m/s^3]",
    ("[limits]", "torque"): "greatest torque of the joint [N m; N]",
    ("[limits]", "velocity_lower"): "the same backward, negative [rad/s; m/s]",
    ("[limits]", "acceleration_lower"): "the same backward, negative [rad/s^2; m/s^2]",
    ("[drive]", "gain"): "joint torque per unit of current, with its sign [N m/A; N/A]",
    ("[drive]", "gain_tolerance"): "how far gains may be off: standard deviation, as a share",
    (
        "[drive]",
        "gain_in_inertias",
    ): "whether inertias were identified from currents with these gains: both are then wrong together",
    ("[drive]", "gear_ratio"): "turns of the motor per turn of the joint [-]",
    ("[drive]", "direct_drive"): "joints whose motor has no gear",
    ("[drive]", "passive"): "joints without a motor: their torque is zero",
    ("[drive]", "servo_gain"): (
        "of position servos, where a log has no current: their error [rad] times this stands for it, and "
        "gain is torque per unit of that; 1 where gain is in N m/rad"
    ),
    ("[drive]", "servo_limit"): "the same at which a servo gives all it can [rad]; inf: not known",
    ("[drive]", "coupling"): "motor velocity over gear ratio = coupling x joint velocity; identity: none [-]",
    ("[flange]", "origin"): "its place [m]",
    ("[flange]", "rotation"): "its axes, as a matrix [-]",
    ("[[link]]", "joint"): "name of the joint",
    ("[[link]]", "link"): "name of the link that it moves",
    ("[[link]]", "parent"): 'joint whose link carries it; "": the base',
    ("[[link]]", "kind"): '"revolute": turns, "prismatic": slides',
    ("[[link]]", "axis"): "direction of the axis in the joint's frame [-]",
    ("[[link]]", "origin"): "place of the joint's frame in the frame of the parent's link [m]",
    ("[[link]]", "rotation"): "axes of the joint's frame there, as a matrix [-]",
    ("[[link]]", "mass"): "mass of the link [kg]",
    ("[[link]]", "center_of_mass"): "its place in the joint's frame [m]",
    ("[[link]]", "inertia"): "XX, XY, XZ, YY, YZ, ZZ about the centre of mass [kg m^2]",
    ("[[effect]]", "name"): "which effect; valid names are in docs/robot-toml.md",
    ("[[measurement]]", "name"): "which one; valid names are in docs/robot-toml.md",
    ("[[effect]]", "joints"): "names of the joints it acts on; left out: all",
    ("[[effect]]", "std"): "how far each may be off: standard deviation, in the same units",
}
"""Table and key -> what it is, and its unit."""
ROWS = ("[[effect]]", "[[measurement]]")
"""Tables whose rows are objects with fields of their own."""
FORMULA = re.compile(r"\s*:math:`[^`]*`,?")
ATTRIBUTE = re.compile(r"^(\w+): (.*(?:\n[ \t]+.*)*)", re.MULTILINE)


def commented_text(model: Model) -> str:
    """What `model_text` writes, with a comment above each key; it reads back to the same model."""
    effects = [effect for effect in model.effects if not effect.of_links or _stated(effect, model)]
    rows: list[Row] = [*effects, *model.measurements]
    return "\n".join([*_comment(HEAD), "", *_lines(model_text(model), model, iter(rows))]) + "\n"


def _stated(effect: Effect, model: Model) -> bool:
    """Whether the rigid body has a row of its own, which a file needs only for its parameters."""
    return f'name = "{RIGID_BODY}"' in model_text(model)


def _lines(text: str, model: Model, effects: Iterator[Row]) -> Iterator[str]:
    """The lines of a robot.toml, and those of comment between them."""
    table, seen, effect = "", set(), None
    for line in text.splitlines():
        if line.startswith("["):
            table = line
            effect = next(effects) if table in ROWS else None
            yield from _comment("" if table in seen else TABLES.get(table, ""))
            yield from _comment(_what(effect) if effect else "")
            explained = table in seen and effect is None
            seen.add(table)
        elif line and (effect or table == "" or not explained):
            yield from _comment(_of_key(table, line.partition(" = ")[0], effect, model))
        yield line


def _of_key(table: str, key: str, effect: Row | None, model: Model) -> str:
    """What a key of a table is."""
    if isinstance(effect, Effect) and key == "values":
        return _parameters(effect, model)
    own = _attributes(effect).get(key, "") if effect is not None else ""
    text = KEYS.get((table, key), "") or own
    return text[:1].upper() + text[1:]


def _what(effect: Row) -> str:
    """First line on an effect, from the file that has it."""
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
    """What an effect's docstring says of its fields: up to the first full stop or semicolon."""
    found: dict[str, str] = {}
    for one in reversed(type(effect).__mro__):
        text = inspect.cleandoc(one.__doc__ or "").partition("Attributes:\n")[2]
        for name, words in ATTRIBUTE.findall(textwrap.dedent(text)):
            plain = FORMULA.sub("", " ".join(words.split()))
            found[name] = re.split(r"[;.](?:\s|$)", plain)[0]
    return found


def _comment(text: str) -> list[str]:
    lines = textwrap.wrap(one_line(text), WIDTH - len(hash_comment("")), break_long_words=False)
    return [hash_comment(line) for line in lines]
