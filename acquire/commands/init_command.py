"""exidyn init: propose a robot.toml and the meaning of a log's columns, or print a driver's settings."""

import os
import shlex
from argparse import Namespace
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from exidyn.drivers import driver_class, explain, known_drivers
from exidyn.identification.errors import ExidynError, RecordingError, listed
from exidyn.identification.file_names import write_whole
from exidyn.identification.model import Model
from exidyn.identification.plausible.gains import GAIN_OF
from exidyn.identification.plausible.log_columns import log_columns
from exidyn.identification.plausible.proposal import Proposal, propose
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
from exidyn.identification.plausible.stated_units import Stated, stated_by
from exidyn.identification.plausible.suspicion import DECIDED
from exidyn.identification.recordings.bags.ros2_bag import joints_of_bag
from exidyn.identification.recordings.importers import import_source, is_table, kind_of, read_tables
from exidyn.identification.recordings.incomplete_samples import NEEDED
from exidyn.identification.recordings.recording import EFFORT
from exidyn.identification.recordings.tables.column_names import joints_named
from exidyn.identification.recordings.tables.columns import Columns, Names, own_time
from exidyn.identification.recordings.tables.preset import BESIDE
from exidyn.identification.recordings.tables.signal_units import require_no_time
from exidyn.identification.recordings.tables.table import Table
from exidyn.identification.robot_files.description import NAMED, is_description, movable_joints
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments.command import Command, Group, Option, WrongUse, refuse_with
from ..arguments.options import JSON, output_option, require_file
from ..terminal.stopwatch import Progress, Stopwatch
from .import_command import COLUMNS, DEGREES, RATE, UNITS
from .result import Result

CLOCK = "time [s]"
"""Name under which the time column of a log is proposed."""
SI = ("s", "rad", "m", "rad/s", "m/s")
"""Units of time, positions and velocities in a recording."""
EITHER = ("exidyn", "ros2_bag")
"""Kinds of logs whose effort can be torque or current, as stated by --effort."""
HELD = "held fixed at position zero, since the log has neither their position nor their effort"

AS_TABLE = (
    "a recording has its efforts as torques. Export it as a table (exidyn export {log} --to csv), rename its "
    "tau columns to i, and run exidyn init on the table"
)


LOGS = Option(
    "logs [LOG...]",
    "file or folder that exidyn import reads; several are runs of one arm with equal columns",
    Path,
    [],
)
ROBOT = Option("--robot ROBOT", f"description of the arm: {NAMED}, or a robot.toml", Path)
PRESET = Option("--preset FILE", f"file of the preset; default: {BESIDE} beside the log", Path)


@Command(
    "Propose the meaning, units and signs of a log's columns and rough drive gains; write a robot.toml, and "
    "for a table the preset with which exidyn import reads it. Or print the settings of a driver.",
    (
        "exidyn init log.csv --robot arm.urdf",
        "exidyn init runs/*.csv --robot arm.xml -o arm/robot.toml",
        "exidyn init --driver can_mit > cell.toml",
        "exidyn init --driver kuka_rsi --for 172.31.1.10 > RSI_EthernetConfig.xml",
    ),
    (
        LOGS,
        ROBOT,
        output_option("FILE", Path("robot.toml")),
        PRESET,
        COLUMNS,
        DEGREES,
        UNITS,
        RATE,
        Option("--force", "overwrite existing files"),
        JSON,
        Group(
            "print a controller file instead, for exidyn record, watch and jog",
            (
                Option(
                    "--driver [DRIVER]",
                    f"settings of {', '.join(known_drivers())}, each explained; without a name, list these",
                    alone="",
                ),
                Option(
                    "--for ADDRESS",
                    "instead the file with which the controller finds this host, if it needs one (kuka_rsi: "
                    "RSI_EthernetConfig.xml)",
                    dest="address",
                ),
            ),
        ),
    ),
    f"""The likeliest guesses are written. What the log does not decide, with a probability of
at least {100 * DECIDED:.0f} %, is a comment in the files, and is printed with advice on how
to decide it.""",
)
def init_command(args: Namespace) -> Result | None:
    """Read the logs, write and print the proposal; or print the settings of a driver."""
    if args.driver is not None:
        refuse_with("--driver", args, [LOGS, ROBOT, PRESET, COLUMNS, DEGREES, UNITS, RATE, JSON])
        _print_driver(args.driver, args.address)
        return None
    if not args.logs or args.robot is None or args.address:
        raise WrongUse("give LOG and --robot ROBOT, or --driver DRIVER to print the settings of a driver")
    with Stopwatch() as progress:
        return _init(args, progress)


def _print_driver(name: str, address: str | None) -> None:
    """Print a controller file to be filled in, or the controller's own file; without a name, the drivers."""
    drivers = known_drivers()
    if name:
        print(driver_class(name).controller_file(address) if address else explain(name), end="")
    else:
        width = max(map(len, drivers))
        print("\n".join(f"{name:<{width}}  {entry.purpose}" for name, entry in drivers.items()))


def _init(args: Namespace, progress: Progress) -> Result:
    progress("read the log")
    log = args.logs[0]
    preset = args.preset or (log if log.is_dir() else log.parent) / BESIDE
    chosen = dict(args.columns or ())
    tables = _tables(args, chosen)
    model, fixed_joints = _arm(args.robot, log, tables and tables.table, chosen)
    progress("weigh units, order of joints, mounting and gains")
    stated = stated_by(dict(args.units or ()), args.degrees, model.robot)
    proposal = _proposal(args.logs, tables, model, chosen, stated)
    if fixed_joints:
        proposal = replace(proposal, notes=(*proposal.notes, f"{HELD}: {listed(fixed_joints)}"))
    # An arm of a robot.toml has no description to refer to.
    urdf = os.path.relpath(args.robot, args.output.parent) if is_description(args.robot) else ""
    still = NOTHING
    if tables is not None and urdf:
        still = still_joints(proposal, model.robot, tables.table.names, tables.table.values)
    moving = [joint for joint in model.robot.joints if joint not in still.position]
    if still.position:
        proposal = without_still(proposal, model.robot, still)
        model = read_model(args.robot, moving, still.position)
    stated_joints = moving if fixed_joints else ()
    texts = {args.output: robot_toml(proposal, model, urdf, log.name, stated_joints, still.position)}
    if tables is not None:
        texts[preset] = preset_toml(proposal, log.name, args.rate, still)
    for path in texts:
        require_file(path, "--output" if path == args.output else "--preset", [*args.logs, args.robot])
        if path.exists() and not args.force:
            raise FileExistsError(17, "this file exists; --force overwrites it", str(path))
    for path, text in texts.items():
        write_whole(path, text)
    progress("import the log as proposed")
    return _result(args, proposal, preset if tables is not None else None, list(texts))


def _result(args: Namespace, proposal: Proposal, preset: Path | None, written: list[Path]) -> Result:
    """The proposal, and the command that follows, or why import refuses the log."""
    following = [_next_command(args, log, proposal, preset) for log in args.logs]
    refusal = _refusal(args, proposal, preset)
    open_questions = [g.what for g in proposal.open if not g.what.startswith((GAIN_OF, GRAVITY))]
    first = f"Check first what is not decided ({', '.join(open_questions)})." if open_questions else ""
    said = [proposal_text(proposal), f"import refuses the log: {refusal}" if refusal else first]
    go_on = "" if refusal else f"exidyn {following[0]}"
    content = as_json(proposal, list(map(str, written)), go_on) | {"refusal": refusal}
    return Result("\n\n".join(filter(None, said)), content, written, next=[] if refusal else following)


def _refusal(args: Namespace, proposal: Proposal, preset: Path | None) -> str:
    """Why import refuses a log with the proposal; empty if it accepts all logs."""
    if preset is None and kind_of(args.logs[0]) == "exidyn":
        return AS_TABLE.format(log=args.logs[0]) if _effort_option(proposal, "exidyn") else ""
    model = read_model(args.output)
    options = {"preset": str(preset)} if preset else _effort_option(proposal, kind_of(args.logs[0]))
    for log in args.logs:
        try:
            import_source(log, model, **options)
        except ExidynError as error:
            return str(error)
    return ""


def _effort_option(proposal: Proposal, kind: str) -> dict[str, str]:
    """The option with which import reads the effort of a log without a preset."""
    return {"effort": "current"} if "current" in proposal.columns and kind in EITHER else {}


def _damaged(proposal: Proposal, table: Table) -> list[str]:
    """A sentence for each proposed column with text, on how import treats it."""
    signals = {name: signal for signal, names in proposal.columns.items() for name in names}
    refuses = "refuses that: correct the cell, or empty it if nothing was measured"
    return [
        f"{place}: import {refuses if signals[name] in ('time', *NEEDED) else 'leaves the column out'}"
        for name, place in table.text.items()
        if name in signals
    ]


class Tables(NamedTuple):
    """The longest table of each log, whose rows follow each other in one table."""

    table: Table
    counts: list[int]  # number of rows of each log

    def divided(self, values: np.ndarray) -> list[np.ndarray]:
        """Values (t, c) of the rows of all logs, divided by log."""
        return np.split(values, np.cumsum(self.counts)[:-1])


def _tables(args: Namespace, chosen: Mapping[str, Names]) -> Tables | None:
    """The longest table of each log; None for logs that are not tables."""
    tables_of = {log: read_tables(log) if is_table(log) else [] for log in args.logs}
    others = [log for log, tables in tables_of.items() if not tables]
    if others:
        options = {"--columns": chosen, "--rate": args.rate, "--units": args.units, "--degrees": args.degrees}
        if stated := [option for option, value in options.items() if value]:
            raise RecordingError(
                f"{others[0]} has its own columns, units and time; {stated[0]} is for tables"
            )
        if len(others) < len(args.logs):
            raise RecordingError(f"{others[0]} is not a table like the other logs; give logs of one kind")
        return None
    longest = [_longest(log, tables, args.rate, chosen) for log, tables in tables_of.items()]
    _require_same(args.logs, [table.names for table in longest])
    values = np.concatenate([table.values for table in longest])
    return Tables(longest[0]._replace(values=values, lines=None), [len(table.values) for table in longest])


def _longest(log: Path, tables: Sequence[Table], rate: float | None, chosen: Mapping[str, Names]) -> Table:
    """The longest table of a log; with a sampling rate [Hz], with a column of time."""
    table = max(tables, key=lambda table: table.values.size)
    if rate is None:
        return table
    require_no_time(log, str(chosen.get("time") or own_time(table)))
    clock = np.arange(len(table.values)) / rate
    return table._replace(names=[CLOCK, *table.names], values=np.column_stack([clock, table.values]))


def _require_same(logs: Sequence[Path], names: Sequence[Sequence[str]]) -> None:
    """Raise if several logs do not have the same columns."""
    for log, columns in zip(logs, names, strict=True):
        if list(columns) != list(names[0]):
            differing = sorted(set(columns) ^ set(names[0])) or ["in another order"]
            raise RecordingError(
                f"{log} has other columns than {logs[0]}: {listed(differing)}. Give runs with equal columns"
            )


def _arm(urdf: Path, log: Path, table: Table | None, chosen: Mapping[str, Names]) -> tuple[Model, list[str]]:
    """The arm, and the joints that are held fixed because the log does not have them.

    `chosen` are the columns of each signal, if they are named: as many as joints stand for all joints.
    """
    if not is_description(urdf):
        return read_model(urdf), []
    free, unsupported = movable_joints(urdf)
    if any(len(names) == len(free) for names in chosen.values() if not isinstance(names, str)):
        moving = free
    elif table is not None:
        moving = joints_named(table.names, free, table.joints)
    else:
        in_log = joints_of_bag(log) if kind_of(log) == "ros2_bag" else free
        moving = [joint for joint in free if joint in in_log] or free
    fixed_joints = [joint for joint in free if joint not in moving] + unsupported
    return read_model(urdf, moving if fixed_joints else None), fixed_joints


def _proposal(
    logs: Sequence[Path], tables: Tables | None, model: Model, chosen: Mapping[str, Names], stated: Stated
) -> Proposal:
    if tables is not None:
        log = log_columns(Columns(logs[0], tables.table, model.robot), chosen)
        values = tables.divided(log.values)
        proposal = log.restored(propose(log.names, values, model, tables.table.joints, stated, str(logs[0])))
        return replace(proposal, notes=(*proposal.notes, *_damaged(proposal, tables.table)))
    columns = [_columns(log, model) for log in logs]
    _require_same(logs, [names for names, _ in columns])
    proposal = propose(columns[0][0], [values for _, values in columns], model, source=str(logs[0]))
    proposal = proposal.by_gains()
    # The importer knows the units of the log; only likelier other units remain open.
    guesses = [guess for guess in proposal.guesses if guess.decided or guess.value not in SI]
    return replace(proposal, guesses=tuple(guesses))


def _columns(log: Path, model: Model) -> tuple[list[str], np.ndarray]:
    """The longest recording of a log as named columns, at the times of its positions."""
    if not (runs := import_source(log, model)):
        raise RecordingError(f"{log} contains no runs")
    run = max(runs, key=lambda run: run.duration)
    time = run.signals["position"].time
    names, columns = ["time [s]"], [time]
    for signal in ("position", "velocity", *EFFORT):
        if signal in run.signals:
            known = run.signals[signal]
            unit = " [rad]" if signal == "position" else ""
            names += [f"{joint} {signal}{unit}" for joint in run.robot.joints]
            columns += [np.interp(time, known.time, values) for values in known.values.T]
    return names, np.column_stack(columns)


def _next_command(args: Namespace, log: Path, proposal: Proposal, preset: Path | None) -> str:
    """Command that imports a log as proposed."""
    kind = kind_of(log)
    # A recording needs no import; it is identified with the new robot.
    verb = "identify" if preset is None and kind == "exidyn" else "import"
    words = [verb, str(log), "--robot", str(args.output)]
    if preset is not None and args.preset:
        words += ["--preset", str(preset)]
    effort = _effort_option(proposal, kind) if preset is None else {}
    words += [word for name, value in effort.items() for word in (f"--{name}", value)]
    return shlex.join(words)
