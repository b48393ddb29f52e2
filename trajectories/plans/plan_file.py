"""Trajectory files: a plan as TOML that people can read, and back, every float to its last digit.

The tables that a plan must have stand last, behind the coefficients, so that a file that was cut off
anywhere lacks one and cannot pass for a shorter motion. The checksum in the second line shows that any other
line was changed: a digit that a disk, a copy or an editor changed leaves a motion that is as well formed.
"""

import hashlib
import os
import re
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from exidyn.identification.arm.robot import Limits
from exidyn.identification.errors import RobotError
from exidyn.identification.robot_files.toml_fields import (
    block,
    check_keys,
    lines,
    number,
    numbers,
    parse_toml,
)

from ..errors import BadLimits, NotATrajectory
from ..limits.usable_limits import require_movable
from .plan import Plan
from .trajectory_rows import read_fields, read_trajectory, trajectory_blocks

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
MOST_COMMANDS = 1e8
"""Of one motion: a day at 1 ms, whose states of six joints take 20 gigabytes."""
CHECKSUM = re.compile(r'^checksum = "([^"\n]*)"\r?\n', re.MULTILINE)
REMARK = "# A motion planned by exidyn, in SI units; 'exidyn show' plots it."


def write_plan(plan: Plan, path: Path | str) -> None:
    """Write a trajectory file; it appears under its name only when it is complete."""
    part = Path(path).with_name(Path(path).name + ".part")
    part.write_text(plan_text(plan), encoding="utf-8")
    os.replace(part, path)


def read_plan(path: Path | str) -> Plan:
    """Plan from a trajectory file.

    Raises:
        NotATrajectory: Missing, cut off, of a later version, or wrong; the message names the place.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise NotATrajectory(
            f"{path}: not a text file (UTF-8); expected a trajectory file (.toml)"
        ) from error
    except OSError as error:
        raise NotATrajectory(f"{path}: cannot be read: {error.strerror}") from error
    return parse_plan(text, str(path))


def plan_text(plan: Plan) -> str:
    """The text of a trajectory file, its checksum in the second line; none where the plan was edited.

    A checksum would make a motion that a person edited pass for one that exidyn planned.
    """
    head = {"format": FORMAT, "kind": KIND} | {name: getattr(plan, name) for name in HEAD}
    parts = [
        lines(head),
        block("[details]", plan.details),
        *trajectory_blocks(plan.trajectory, "trajectory"),
        block("[margins]", plan.margins),
        block("[limits]", vars(plan.limits)),
    ]
    text = "\n\n".join(parts) + "\n"
    if plan.edited:
        return f"{REMARK}\n{text}"
    checksum = _checksum(f"{REMARK}\n{text}")
    return f'{REMARK}\nchecksum = "{checksum}"\n{text}'


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
        _require_number_of_commands(plan)
        return replace(plan, edited=not _unchanged(text))
    except (NotATrajectory, RobotError) as error:
        raise NotATrajectory(f"{where}: {error}") from error


def _plan(table: Mapping[str, Any]) -> Plan:
    _check_kind(table)
    check_keys(table, KEYS, "top level")
    for key in TABLES:
        if not isinstance(table.get(key), Mapping):
            found = f"expected a table [{key}]; found {table[key]!r}" if key in table else "is missing"
            raise NotATrajectory(f"'{key}' {found}; was the file cut off?")
    given = read_fields(Plan, table, [name for name in HEAD if name != "reached"], "")
    if "reached" in table:
        given["reached"] = float(_any_number(table["reached"], "reached"))
    for unit in given["units"]:
        if unit not in UNITS:
            raise NotATrajectory(f"units: '{unit}' is none of {', '.join(UNITS)}")
    return Plan(
        trajectory=read_trajectory(table["trajectory"], "[trajectory]"),
        limits=_limits(table["limits"], len(given["joints"])),
        margins={key: number(value, f"[margins] {key}", 0.0) for key, value in table["margins"].items()},
        details={
            key: value if isinstance(value, str) else _any_number(value, f"[details] {key}")
            for key, value in table["details"].items()
        },
        **given,
    )


def _limits(table: Mapping[str, Any], joints: int) -> Limits:
    names = [f.name for f in fields(Limits)]
    check_keys(table, names, "[limits]")
    for name in names:
        if name not in table:
            raise NotATrajectory(f"[limits]: key '{name}' is missing; was the file cut off?")
    limits = Limits(
        **{name: numbers(table[name], joints, f"[limits] {name}", infinite=True) for name in names}
    )
    try:
        require_movable(limits)
    except BadLimits as error:
        raise NotATrajectory(f"[limits]: {error}") from error
    return limits


def _require_number_of_commands(plan: Plan) -> None:
    """Raise where a period or tick makes a motion of more commands than any memory holds."""
    count = plan.trajectory.duration / plan.tick
    if not count <= MOST_COMMANDS:
        raise NotATrajectory(
            f"{plan.trajectory.duration:g} s with a command every {plan.tick:g} s are {count:.3g} commands, "
            f"more than {MOST_COMMANDS:g}; was a duration or 'tick' edited?"
        )


def _any_number(value: object, where: str) -> float:
    """A number, infinity or NaN where something is not known; a whole number stays one."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise NotATrajectory(f"{where}: expected a number; found {value!r}")
    return value


def _check_kind(table: Mapping[str, Any]) -> None:
    if table.get("kind") != KIND:
        found = f"kind = {table['kind']!r}" if "kind" in table else "no key 'kind'"
        raise NotATrajectory(f"not a trajectory file: {found}, expected kind = '{KIND}'")
    version = table.get("format")
    if version != FORMAT:
        hint = "; update exidyn" if isinstance(version, int) and version > FORMAT else ""
        raise NotATrajectory(f"format {version!r}; this version reads format {FORMAT}{hint}")


def _unchanged(text: str) -> bool:
    """Whether a text has its checksum; one without any was written or edited by hand.

    Raises:
        NotATrajectory: It is another text than was written.
    """
    found = CHECKSUM.search(text)
    if found is None:
        return False
    if found[1] != _checksum(text[: found.start()] + text[found.end() :]):
        raise NotATrajectory(
            f"the file has changed since exidyn wrote it: its checksum is not {found[1]} any more. Plan the "
            "motion again, or, if the change is meant, remove the line that begins with 'checksum'"
        )
    return True


def _checksum(text: str) -> str:
    """Of the lines, however they end."""
    return hashlib.sha256("\n".join(text.splitlines()).encode()).hexdigest()[:16]
