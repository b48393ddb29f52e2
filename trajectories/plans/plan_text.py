"""A plan as TOML that people can read, and back, every float to its last digit.

The tables that a plan must have stand last, behind the coefficients, so that a file that was cut off
anywhere lacks one and cannot pass for a shorter motion. The checksum in the second line shows that any other
line was changed: a digit that a disk, a copy or an editor changed leaves a motion that is as well formed.
"""

import hashlib
import re
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import partial
from typing import Any

from exidyn.identify.arm.robot import Limits
from exidyn.identify.errors import RobotError
from exidyn.identify.robot_files.toml_fields import (
    boolean,
    check_keys,
    integer,
    number,
    numbers,
    parse_toml,
    string,
)
from exidyn.identify.robot_files.toml_text import block, lines

from ..errors import NotATrajectory
from .plan import Plan
from .trajectory_rows import needed, read_trajectory, trajectory_blocks

FORMAT = 1
"""Goes up when a reader of the former version would misunderstand a file."""
KIND = "trajectory"
HEAD = (
    "robot", "robot_hash", "model_hash", "joints", "units", "criterion", "reached", "seed", "tick",
    "payload_pair", "assumed",
)  # fmt: skip
"""Fields of a plan that stand at the top of its file."""
TABLES = ("details", "trajectory", "margins", "limits")
KEYS = ("checksum", "format", "kind", *HEAD, *TABLES)
UNITS = ("rad", "m")
CHECKSUM = re.compile(r'^checksum = "([^"\n]*)"\r?\n', re.MULTILINE)
REMARK = "# A motion planned by exidyn, in SI units; 'exidyn show' plots it."


def plan_text(plan: Plan) -> str:
    """The text of a trajectory file."""
    head = {"format": FORMAT, "kind": KIND} | {name: getattr(plan, name) for name in HEAD}
    parts = [
        f"{REMARK}\n{lines(head)}",
        block("[details]", plan.details),
        *trajectory_blocks(plan.trajectory, "trajectory"),
        block("[margins]", plan.margins),
        block("[limits]", {f.name: getattr(plan.limits, f.name) for f in fields(Limits)}),
    ]
    return _sealed("\n\n".join(parts) + "\n")


def parse_plan(text: str, where: str = "trajectory file") -> Plan:
    """Plan from the text of a trajectory file; `where` it comes from is named in errors.

    Raises:
        NotATrajectory: It is none; the message names the key, what was found and what is valid.
    """
    try:
        table = parse_toml(text, where)
    except RobotError as error:
        raise NotATrajectory(f"{error}; was the file cut off?") from error
    try:
        plan = _plan(table)
        _require_unchanged(text)
        return plan
    except (NotATrajectory, RobotError) as error:
        raise NotATrajectory(f"{where}: {error}") from error


def _plan(table: Mapping[str, Any]) -> Plan:
    _check_kind(table)
    check_keys(table, KEYS, "top level")
    wanted = {*TABLES, *(f.name for f in fields(Plan) if needed(f))}
    for key in KEYS:
        if key not in table and key in wanted:
            raise NotATrajectory(f"'{key}' is missing; was the file cut off?")
    joints = _strings(table["joints"], "joints")
    given = {key: read(table[key], key) for key, read in READERS.items() if key in table}
    return Plan(
        trajectory=read_trajectory(table["trajectory"], "[trajectory]"),
        joints=joints,
        limits=_limits(table["limits"], len(joints)),
        **given,
    )


def _sealed(text: str) -> str:
    """The text with its checksum in the second line."""
    first, rest = text.split("\n", 1)
    return f'{first}\nchecksum = "{_checksum(text)}"\n{rest}'


def _require_unchanged(text: str) -> None:
    """Compare a text with its checksum; one without was written by hand and passes.

    Raises:
        NotATrajectory: It is another text than was sealed.
    """
    found = CHECKSUM.search(text)
    if found and found[1] != _checksum(text[: found.start()] + text[found.end() :]):
        raise NotATrajectory(
            f"the file has changed since exidyn wrote it: its checksum is not {found[1]} any more. Plan the "
            "motion again, or, if the change is meant, remove the line that begins with 'checksum'"
        )


def _checksum(text: str) -> str:
    """Of the lines, however they end."""
    return hashlib.sha256("\n".join(text.splitlines()).encode()).hexdigest()[:16]


def _check_kind(table: Mapping[str, Any]) -> None:
    if table.get("kind") != KIND:
        found = f"kind = {table['kind']!r}" if "kind" in table else "no key 'kind'"
        raise NotATrajectory(f"not a trajectory file: {found}, expected kind = '{KIND}'")
    version = table.get("format")
    if version != FORMAT:
        hint = "; update exidyn" if isinstance(version, int) and version > FORMAT else ""
        raise NotATrajectory(f"format {version!r}; this version reads format {FORMAT}{hint}")


def _limits(table: object, joints: int) -> Limits:
    names = [f.name for f in fields(Limits)]
    check_keys(table, names, "[limits]")
    assert isinstance(table, Mapping)
    for name in names:
        if name not in table:
            raise NotATrajectory(f"[limits]: key '{name}' is missing; was the file cut off?")
    return Limits(**{name: numbers(table[name], joints, f"[limits] {name}", infinite=True) for name in names})


def _strings(value: object, where: str) -> tuple[str, ...]:
    if not isinstance(value, list):
        raise NotATrajectory(f"{where}: expected a list of texts; found {value!r}")
    return tuple(string(item, f"{where}[{place}]") for place, item in enumerate(value))


def _units(value: object, where: str) -> tuple[str, ...]:
    found = _strings(value, where)
    for unit in found:
        if unit not in UNITS:
            raise NotATrajectory(f"{where}: '{unit}' is none of {', '.join(UNITS)}")
    return found


def _any_number(value: object, where: str) -> float:
    """A number, infinity or NaN; a whole number stays one."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise NotATrajectory(f"{where}: expected a number; found {value!r}")
    return value


def _margins(value: object, where: str) -> dict[str, float]:
    return {key: number(item, f"[{where}] {key}", 0.0) for key, item in _table(value, where).items()}


def _details(value: object, where: str) -> dict[str, float | str]:
    """Whatever was noted: texts, and numbers that may be NaN where something is not known."""
    return {
        key: item if isinstance(item, str) else _any_number(item, f"[{where}] {key}")
        for key, item in _table(value, where).items()
    }


def _table(value: object, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise NotATrajectory(f"{where}: expected a table [{where}]; found {value!r}")
    return value


READERS: dict[str, Callable[[object, str], Any]] = {
    "units": _units,
    "robot": string,
    "robot_hash": string,
    "model_hash": string,
    "criterion": partial(string, empty=True),
    "reached": lambda value, where: float(_any_number(value, where)),
    "seed": integer,
    "tick": number,
    "payload_pair": boolean,
    "assumed": _strings,
    "margins": _margins,
    "details": _details,
}
"""Key -> how it is read, of those keys that need nothing else to be known."""
