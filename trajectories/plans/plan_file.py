"""Trajectory files: plans as human-readable TOML, and back, with every float exact.

The required tables are at the end, after the coefficients, so that a truncated file lacks one and cannot be
mistaken for a shorter motion. The checksum in the second line reveals a change of any other line: a digit
that a disk, a copy or an editor has changed would leave a well-formed motion.

Trajectories of any family are written and read by the annotations of their fields: numbers, texts, booleans,
arrays of floats, tuples of any of these, a `Trajectory`, or a tuple of them. Integers belong in a tuple.
"""

import hashlib
import re
from collections.abc import Collection, Mapping
from dataclasses import MISSING, fields, replace
from itertools import groupby
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.errors import RobotError
from exidyn.identification.file_names import other_format, read_failure, write_whole
from exidyn.identification.result_file import number_or_array
from exidyn.identification.robot_files.toml_fields import (
    block,
    check_keys,
    lines,
    numbers,
    parse_toml,
)  # fmt: skip
from exidyn.identification.schema import checked, shown

from ..errors import BadLimits, NotATrajectory, TrajectoryError, UnknownChoice
from ..families import FAMILIES
from ..limits.usable_limits import require_movable
from ..trajectory import Trajectory
from .plan import Plan

FORMAT = 1
"""Version of the format; increased when a reader of the previous version would misunderstand a file."""
KIND = "trajectory"
TABLES = ("details", "trajectory", "margins", "limits")
"""Fields of a plan that are tables of its file."""
HEAD = tuple(f.name for f in fields(Plan) if f.name not in (*TABLES, "edited"))
"""Fields of a plan at the top of its file."""
KEYS = ("checksum", "format", "kind", *HEAD, *TABLES)
MOST_COMMANDS = 1e8
"""Maximum number of commands of a motion: a day at 1 ms, whose states take 20 gigabytes for six joints."""
CHECKSUM = re.compile(r'^checksum = "([^"\n]*)"\r?\n', re.MULTILINE)
REMARK = "# A motion planned by exidyn, in SI units; 'exidyn excite --show' plots it."


def write_plan(plan: Plan, path: Path | str) -> Path:
    """Write a trajectory file; it gets its name only when it is complete. Returns its path."""
    return write_whole(path, plan_text(plan))


def read_plan(path: Path | str) -> Plan:
    """Plan from a trajectory file; raises `NotATrajectory` if it is missing, truncated, too new or wrong."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        reason = "not a text file (UTF-8); expected a trajectory file (.toml)"
        raise NotATrajectory(f"{path}: {reason}") from error
    except OSError as error:
        raise NotATrajectory(f"{path}: cannot be read: {read_failure(path, error)}") from error
    return parse_plan(text, str(path))


def plan_text(plan: Plan) -> str:
    """The text of a trajectory file, with its checksum in the second line unless the plan was edited.

    A checksum would make an edited motion look like one that exidyn planned.
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
    """Plan from the text of a trajectory file; errors name its source, `where`.

    Raises:
        NotATrajectory: The text is no trajectory file; the message names the key, its value and what is
            valid.
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
            reason = f"expected a table [{key}]; found {table[key]!r}" if key in table else "is missing"
            raise NotATrajectory(f"'{key}' {reason}; was the file cut off?")
    values = read_fields(Plan, table, (*HEAD, "trajectory", "margins", "details"))
    return Plan(limits=_limits(table["limits"], len(values["joints"])), **values)


def _limits(table: Mapping[str, Any], joints: int) -> Limits:
    names = [f.name for f in fields(Limits)]
    check_keys(table, names, "[limits]")
    for name in names:
        if name not in table:
            raise NotATrajectory(f"[limits]: key '{name}' is missing; was the file cut off?")
    values = {name: numbers(table[name], joints, f"[limits] {name}", infinite=True) for name in names}
    limits = Limits(**values)
    try:
        require_movable(limits)
    except BadLimits as error:
        raise NotATrajectory(f"[limits]: {error}") from error
    return limits


def _require_number_of_commands(plan: Plan) -> None:
    """Raise if duration and sampling period give more commands than memory can hold."""
    count = plan.trajectory.duration / plan.tick
    if not count <= MOST_COMMANDS:
        raise NotATrajectory(
            f"{plan.trajectory.duration:g} s with a command every {plan.tick:g} s are {count:.3g} commands, "
            f"more than {MOST_COMMANDS:g}; was a duration or 'tick' edited?"
        )


def _check_kind(table: Mapping[str, Any]) -> None:
    if table.get("kind") != KIND:
        reason = f"kind = {table['kind']!r}" if "kind" in table else "no key 'kind'"
        raise NotATrajectory(f"not a trajectory file: {reason}, expected kind = '{KIND}'")
    version = table.get("format")
    if version != FORMAT:
        raise NotATrajectory(other_format(version, FORMAT, "excite ROBOT"))


def _unchanged(text: str) -> bool:
    """Whether a text has a checksum; raises `NotATrajectory` if that is the checksum of another text."""
    match = CHECKSUM.search(text)
    if match is None:
        return False
    if match[1] != _checksum(text[: match.start()] + text[match.end() :]):
        raise NotATrajectory(
            f"the file has changed since exidyn wrote it: its checksum is no longer {match[1]}. Plan the "
            "motion again, or, if the change is intended, remove the line that begins with 'checksum'"
        )
    return True


def _checksum(text: str) -> str:
    """Checksum of the lines, regardless of their line endings."""
    return hashlib.sha256("\n".join(text.splitlines()).encode()).hexdigest()[:16]


FAMILY = "family"
"""Key of the family's name."""
FEW = 5
"""Maximum number of parts of a trajectory that are named one by one."""


def family_words(trajectory: Trajectory) -> str:
    """Names of a trajectory's family and of the families of its parts, with counts of repetitions."""
    inner = [_family_of(part) for value in _values(trajectory).values() for part in _parts(value)]
    rows = [(name, len(list(group))) for name, group in groupby(inner)]
    words = [name if count == 1 else f"{count} {name}" for name, count in rows]
    if len(words) > FEW:
        words = [f"{len(words)} parts"]
    return " of ".join(filter(None, [_family_of(trajectory), ", ".join(words)]))


def trajectory_blocks(trajectory: Trajectory, place: str, heading: str = "[{}]") -> list[str]:
    """TOML of a trajectory, then of its parts; raises `UnknownChoice` if it is of no family in the table."""
    flat: dict[str, Any] = {FAMILY: _family_of(trajectory)}
    inner: list[str] = []
    for name, value in _values(trajectory).items():
        for part in _parts(value):
            below = "[[{}]]" if isinstance(value, tuple) else "[{}]"
            inner += trajectory_blocks(part, f"{place}.{name}", below)
        if not _parts(value) and value is not None:
            flat[name] = value
    return [block(heading.format(place), flat, tall=True), *inner]


def _read_value(kind: type, value: Any) -> Any:
    """Trajectory from its table, or array of finite numbers, for `checked`.

    Raises:
        RobotError: A value is invalid for its key.
        NotATrajectory: The values form no valid trajectory.
    """
    if kind is np.ndarray:
        array = number_or_array(kind, value)
        if not np.all(np.isfinite(array)):
            raise NotATrajectory(f"expected finite numbers; found {shown(value)}")
        return array
    name = value.get(FAMILY) if isinstance(value, Mapping) else None
    if not isinstance(name, str) or name not in FAMILIES:
        reason = f"family {name!r}" if name is not None else "no key 'family'"
        raise NotATrajectory(f"{reason}; expected one of: {', '.join(sorted(FAMILIES))}")
    family: Any = FAMILIES[name]
    declared = [f.name for f in fields(family) if f.init]
    check_keys(value, (FAMILY, *declared), name)
    values = read_fields(family, value, declared)
    try:
        return family(**values)
    except TrajectoryError:
        raise
    except (ArithmeticError, IndexError, TypeError, ValueError) as error:
        raise NotATrajectory(f"these values form no valid {name}: {error}") from error


def read_fields(kind: type, table: Mapping[str, Any], names: Collection[str]) -> dict[str, Any]:
    """Some fields of a dataclass from a table; those with a default may be missing.

    Raises:
        RobotError: A value is invalid for its key.
        NotATrajectory: A key is missing.
    """
    hints, values = get_type_hints(kind, include_extras=True), {}
    for f in fields(kind):
        if f.name in table and f.name in names:
            values[f.name] = _read_field(hints[f.name], table[f.name], f.name)
        elif f.name in names and f.default is MISSING and f.default_factory is MISSING:
            raise NotATrajectory(f"key '{f.name}' is missing; was the file cut off?")
    return values


def _read_field(kind: Any, value: Any, name: str) -> Any:
    """The value of a field by its annotation; that of a mapping entry by entry, as errors name the key."""
    if get_origin(kind) is not Mapping:
        return checked(value, kind, name, RobotError, _read_value)
    entry_kind = get_args(kind)[1]
    return {key: checked(entry, entry_kind, f"[{name}] {key}", RobotError) for key, entry in value.items()}


def _family_of(trajectory: Trajectory) -> str:
    for name, kind in FAMILIES.items():
        if kind is type(trajectory):
            return name
    raise UnknownChoice("family of trajectories", type(trajectory).__name__, FAMILIES)


def _values(trajectory: Any) -> dict[str, Any]:
    return {f.name: getattr(trajectory, f.name) for f in fields(trajectory) if f.init}


def _parts(value: object) -> tuple[Trajectory, ...]:
    """Trajectories that a field contains; empty if it contains something else."""
    if isinstance(value, Trajectory):
        return (value,)
    return value if isinstance(value, tuple) and value and isinstance(value[0], Trajectory) else ()
