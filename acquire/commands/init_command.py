"""exidyn init: a log and a URDF or MJCF in; a robot.toml, what the columns are, and how sure that is out."""

import os
import shlex
import sys
from argparse import Namespace
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from exidyn.identification.errors import ExidynError, RecordingError, listed
from exidyn.identification.model import Model
from exidyn.identification.notebook import counted
from exidyn.identification.plausible.column_names import joints_named
from exidyn.identification.plausible.gains import GAIN_OF
from exidyn.identification.plausible.guess import DECIDED
from exidyn.identification.plausible.log_columns import log_columns
from exidyn.identification.plausible.proposal import Proposal, one_after_another, propose
from exidyn.identification.plausible.proposal_text import (
    NOTHING,
    as_json,
    preset_toml,
    proposal_text,
    robot_toml,
    still_joints,
    without_still,
)
from exidyn.identification.plausible.proposed_units import GRAVITY
from exidyn.identification.recordings.importers import IMPORTERS, import_source, kind_of, read_tables
from exidyn.identification.recordings.importers.ros2_bag import joints_of_bag
from exidyn.identification.recordings.importers.tables.columns import Columns, Names, own_time
from exidyn.identification.recordings.importers.tables.preset import BESIDE
from exidyn.identification.recordings.importers.tables.stamps import require_no_time
from exidyn.identification.recordings.importers.tables.table import Table
from exidyn.identification.recordings.optional_signals import NEEDED
from exidyn.identification.recordings.recording import EFFORT, Recording
from exidyn.identification.robot_files.description import NAMED, is_description, movable_joints
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments.command import Command, Option, positive
from ..arguments.options import JSON, output_option, require_file, require_json
from ..terminal.json_output import hand_over, json_text, print_written, write_whole
from ..terminal.stopwatch import Progress, Stopwatch
from .import_command import COLUMNS

CLOCK = "time [s]"
SI = ("s", "rad", "m", "rad/s", "m/s")
"""Units of time, positions and velocities in a recording."""
EITHER = ("exidyn", "ros2_bag")
"""Kinds of logs whose efforts may be torques or currents, as --effort states."""
HELD = "held still, where their position is zero, as the log has no position and effort of them"

AS_TABLE = (
    "a recording keeps its efforts as torques. Make a table of it (exidyn export {log} --to csv), name its "
    "tau columns i, and propose for that"
)


@Command(
    "Look at a log, and propose what its columns are, in which units, and the signs and rough sizes of "
    "drive gains; write a robot.toml, and for a table the preset that import reads it by.",
    (
        "exidyn init log.csv --urdf arm.urdf",
        "exidyn init runs/*.csv --urdf arm.urdf",
        "exidyn init log.csv --mjcf arm.xml",
        "exidyn init log.mat --urdf arm.urdf -o arm/robot.toml",
    ),
    (
        Option(
            "logs LOG...",
            "a file or folder that exidyn import reads; several are runs of one arm with the same columns",
            Path,
        ),
        Option("--urdf --mjcf FILE", f"the arm: {NAMED}, or a robot.toml", Path, required=True),
        output_option("FILE", Path("robot.toml")),
        Option("--preset FILE", f"where the columns go; default: {BESIDE} beside the log", Path),
        COLUMNS,
        Option("--rate HZ", "samples a second, of a table or arrays without time", positive),
        Option("--force", "write over files that exist"),
        JSON,
    ),
    f"""A guess is written down from a probability of {100 * DECIDED:.0f} % on. What the log does not
decide is left open: it is a comment in the robot.toml, and printed with what
settles it.""",
)
def init_command(given: Namespace) -> None:
    """Read, propose, write, print."""
    with Stopwatch() as progress:
        _init(given, progress)


def _init(given: Namespace, progress: Progress) -> None:
    require_json(given.json)
    progress("read the log")
    log = given.logs[0]
    preset = given.preset or (log if log.is_dir() else log.parent) / BESIDE
    chosen = dict(given.columns or ())
    table = _table(given.logs, given.rate, chosen)
    model, held = _arm(given.urdf, log, table)
    progress("weigh units, order of joints, mounting and gains")
    proposal = _proposal(given.logs, table, model, chosen)
    if table is None:
        proposal = _in_si(proposal.by_gains())
    if held:
        proposal = replace(proposal, notes=(*proposal.notes, f"{HELD}: {listed(held)}"))
    if table is not None:
        proposal = replace(proposal, notes=(*proposal.notes, *_damaged(proposal, table)))
    unsure = [guess.what for guess in proposal.open if not guess.what.startswith((GAIN_OF, GRAVITY))]
    urdf, still = _urdf(given.urdf, given.output), NOTHING
    if table is not None and urdf and not unsure:
        still = still_joints(proposal, model.robot, table.names, table.values)
    moving = [joint for joint in model.robot.joints if joint not in still.position]
    if still.position:
        proposal = without_still(proposal, model.robot, still)
        model = read_model(given.urdf, moving, still.position)
    texts = {
        given.output: robot_toml(proposal, model, urdf, log.name, moving if held else (), still.position)
    }
    if table is not None and not unsure:
        texts[preset] = preset_toml(proposal, model.robot, log.name, given.rate, still)
    _require_free(texts, given)
    for path, text in texts.items():
        write_whole(path, text)
    then = _then(given, proposal, table is not None, preset) if not unsure else ""
    if then:
        progress("import the log as proposed")
    refusal = _refusal(given, proposal, preset if table is not None else None) if then else ""
    others = counted(len(given.logs) - 1, "other log")
    more = f"\nand the same for {others}" if len(given.logs) > 1 else ""
    following = f"import refuses the log: {refusal}" if refusal else f"Next: {then}{more}"
    page = proposal_text(proposal) + (f"\n\n{following}" if then else "")
    written = [str(path) for path in texts]
    content = as_json(proposal, written, "" if refusal else then) | {"refusal": refusal}
    hand_over(page, json_text(content), given.json)
    print_written(*texts)
    if unsure:
        print(f"no {BESIDE} written: {', '.join(unsure)} not decided", file=sys.stderr)


def _in_si(proposal: Proposal) -> Proposal:
    """The proposal for a log whose importer knows its units: others are asked for where likelier."""
    guesses = [guess for guess in proposal.guesses if guess.decided or guess.value not in SI]
    return replace(proposal, guesses=tuple(guesses))


def _refusal(given: Namespace, proposal: Proposal, preset: Path | None) -> str:
    """Why import refuses a log as it is proposed; "" where it takes all of them."""
    if preset is None and kind_of(given.logs[0]) == "exidyn":
        return AS_TABLE.format(log=given.logs[0]) if _effort_option(proposal, "exidyn") else ""
    model = read_model(given.output)
    options = {"preset": str(preset)} if preset else _effort_option(proposal, kind_of(given.logs[0]))
    for log in given.logs:
        try:
            import_source(log, model, **options)
        except ExidynError as error:
            return str(error)
    return ""


def _effort_option(proposal: Proposal, kind: str) -> dict[str, str]:
    """The option by which import reads the effort of a log without a preset."""
    return {"effort": "current"} if "current" in proposal.columns and kind in EITHER else {}


def _damaged(proposal: Proposal, table: Table) -> list[str]:
    """Columns with text in them that would be read, and what import makes of that, a sentence each."""
    signals = {name: signal for signal, names in proposal.columns.items() for name in names}
    refuses = "refuses that: correct the cell, or empty it if nothing was measured"
    return [
        f"{place}: import {refuses if signals[name] in ('time', *NEEDED) else 'leaves the column out'}"
        for name, place in table.text.items()
        if name in signals
    ]


def _table(logs: Sequence[Path], rate: float | None, chosen: Mapping[str, Names]) -> Table | None:
    """The longest tables of logs of columns, which have to be named, as one; None for other logs."""
    other = [log for log in logs if not IMPORTERS[kind_of(log)].table]
    if other:
        if rate is not None or chosen:
            option = "--columns is for tables" if chosen else "--rate is for tables without time"
            raise RecordingError(f"{other[0]} has its own columns and its own time; {option}")
        if len(other) < len(logs):
            raise RecordingError(f"{other[0]} is no table as the other logs are; give logs of one kind")
        return None
    tables = [_longest(log, rate, chosen) for log in logs]
    _require_same(logs, [table.names for table in tables])
    clock = str(chosen.get("time", ""))
    called = [CLOCK if name == clock else name for name in tables[0].names]
    values = (
        one_after_another(called, [table.values for table in tables]) if len(tables) > 1 else tables[0].values
    )
    return tables[0]._replace(values=values)


def _longest(log: Path, rate: float | None, chosen: Mapping[str, Names]) -> Table:
    table = max(read_tables(log), key=lambda table: len(table.values))
    if rate is None:
        return table
    require_no_time(log, str(chosen.get("time") or own_time(table)))
    clock = np.arange(len(table.values)) / rate
    return table._replace(names=[CLOCK, *table.names], values=np.column_stack([clock, table.values]))


def _require_same(logs: Sequence[Path], names: Sequence[Sequence[str]]) -> None:
    """Make sure that several logs have the same columns."""
    for log, own in zip(logs, names, strict=True):
        if list(own) != list(names[0]):
            apart = sorted(set(own) ^ set(names[0])) or ["in another order"]
            raise RecordingError(
                f"{log} has other columns than {logs[0]}: {listed(apart)}. Give runs with the same columns"
            )


def _arm(urdf: Path, log: Path, table: Table | None) -> tuple[Model, list[str]]:
    """The arm, and which joints of its description are held: those that the log does not have."""
    if not is_description(urdf):
        return read_model(urdf), []
    free, bound = movable_joints(urdf)
    if table is not None:
        moving = joints_named(table.names, free, table.joints)
    else:
        there = joints_of_bag(log) if kind_of(log) == "ros2_bag" else free
        moving = [joint for joint in free if joint in there] or free
    held = [joint for joint in free if joint not in moving] + bound
    return read_model(urdf, moving if held else None), held


def _proposal(
    logs: Sequence[Path], table: Table | None, model: Model, chosen: Mapping[str, Names]
) -> Proposal:
    if table is not None:
        log = log_columns(Columns(logs[0], table, model.robot), chosen)
        return log.restored(propose(log.names, log.values, model, table.joints))
    every = [_columns(max(_runs(log, model), key=lambda run: run.duration)) for log in logs]
    _require_same(logs, [names for names, _ in every])
    names = every[0][0]
    return propose(names, one_after_another(names, [values for _, values in every]), model)


def _runs(log: Path, model: Model) -> list[Recording]:
    runs = import_source(log, model)
    if not runs:
        raise RecordingError(f"{log}: there is no run in it")
    return runs


def _columns(run: Recording) -> tuple[list[str], np.ndarray]:
    """A recording as named columns, on the clock of its positions."""
    time = run.signals["position"].time
    names, columns = ["time [s]"], [time]
    for signal in ("position", "velocity", *EFFORT):
        if signal in run.signals:
            known = run.signals[signal]
            unit = " [rad]" if signal == "position" else ""
            names += [f"{joint} {signal}{unit}" for joint in run.robot.joints]
            columns += [np.interp(time, known.time, values) for values in known.values.T]
    return names, np.column_stack(columns)


def _urdf(path: Path, output: Path) -> str:
    """The description's path as seen from the robot.toml; "" for an arm that is described otherwise."""
    return os.path.relpath(path, output.parent) if is_description(path) else ""


def _require_free(texts: dict[Path, str], given: Namespace) -> None:
    """Make sure that files can be written, and none is lost."""
    for path in texts:
        require_file(path, "--output" if path == given.output else "--preset", [*given.logs, given.urdf])
        if path.exists() and not given.force:
            raise FileExistsError(17, "this file exists; --force writes over it", str(path))


def _then(given: Namespace, proposal: Proposal, table: bool, preset: Path) -> str:
    """The command line that imports the log as proposed."""
    # A recording needs no import: it is used with the new robot.
    verb = "identify" if not table and kind_of(given.logs[0]) == "exidyn" else "import"
    words = ["exidyn", verb, str(given.logs[0]), "--robot", str(given.output)]
    if table and given.preset:
        words += ["--preset", str(preset)]
    if not table:
        effort = _effort_option(proposal, kind_of(given.logs[0]))
        words += [word for name, value in effort.items() for word in (f"--{name}", value)]
    return shlex.join(words)
