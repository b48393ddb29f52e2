"""exidyn init: propose a robot.toml and the meaning of a log's columns, or print a driver's settings."""

import os
import shlex
import sys
from argparse import Namespace
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from exidyn.drivers import driver_class, explain, known_drivers
from exidyn.identification.errors import ExidynError, RecordingError, listed
from exidyn.identification.model import Model
from exidyn.identification.notebook import counted
from exidyn.identification.plausible.gains import GAIN_OF
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
from exidyn.identification.plausible.suspicion import DECIDED
from exidyn.identification.recordings.bags.ros2_bag import joints_of_bag
from exidyn.identification.recordings.importers import IMPORTERS, import_source, kind_of, read_tables
from exidyn.identification.recordings.incomplete_samples import NEEDED
from exidyn.identification.recordings.recording import EFFORT, Recording
from exidyn.identification.recordings.tables.column_names import joints_named
from exidyn.identification.recordings.tables.columns import Columns, Names, own_time
from exidyn.identification.recordings.tables.preset import BESIDE
from exidyn.identification.recordings.tables.signal_units import require_no_time
from exidyn.identification.recordings.tables.table import Table
from exidyn.identification.robot_files.description import NAMED, is_description, movable_joints
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments.command import Command, Group, Option, WrongUse, positive, refuse_with
from ..arguments.options import JSON, output_option, require_file
from ..terminal.json_output import write_whole
from ..terminal.stopwatch import Progress, Stopwatch
from .import_command import COLUMNS
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
RATE = Option("--rate HZ", "sampling rate of a table or arrays without time", positive)


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
    f"""A guess is written if its probability is at least {100 * DECIDED:.0f} %. What the log does not
decide stays open: it is a comment in the robot.toml, and is printed with advice
on how to decide it.""",
)
def init_command(args: Namespace) -> Result | None:
    """Read the logs, write and print the proposal; or print the settings of a driver."""
    if args.driver is not None:
        refuse_with("--driver", args, [LOGS, ROBOT, PRESET, COLUMNS, RATE, JSON])
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
    table = _table(args.logs, args.rate, chosen)
    model, fixed_joints = _arm(args.robot, log, table, chosen)
    progress("weigh units, order of joints, mounting and gains")
    proposal = _proposal(args.logs, table, model, chosen)
    if table is None:
        proposal = _in_si(proposal.by_gains())
    if fixed_joints:
        proposal = replace(proposal, notes=(*proposal.notes, f"{HELD}: {listed(fixed_joints)}"))
    if table is not None:
        proposal = replace(proposal, notes=(*proposal.notes, *_damaged(proposal, table)))
    undecided = [guess.what for guess in proposal.open if not guess.what.startswith((GAIN_OF, GRAVITY))]
    # An arm of a robot.toml has no description to refer to.
    urdf = os.path.relpath(args.robot, args.output.parent) if is_description(args.robot) else ""
    still = NOTHING
    if table is not None and urdf and not undecided:
        still = still_joints(proposal, model.robot, table.names, table.values)
    moving = [joint for joint in model.robot.joints if joint not in still.position]
    if still.position:
        proposal = without_still(proposal, model.robot, still)
        model = read_model(args.robot, moving, still.position)
    texts = {
        args.output: robot_toml(
            proposal, model, urdf, log.name, moving if fixed_joints else (), still.position
        )
    }
    if table is not None and not undecided:
        texts[preset] = preset_toml(proposal, model.robot, log.name, args.rate, still)
    _require_free(texts, args)
    for path, text in texts.items():
        write_whole(path, text)
    next_command = _next_command(args, proposal, table is not None, preset) if not undecided else ""
    if next_command:
        progress("import the log as proposed")
    refusal = _refusal(args, proposal, preset if table is not None else None) if next_command else ""
    others = counted(len(args.logs) - 1, "other log")
    more = f"\nand the same for {others}" if len(args.logs) > 1 else ""
    following = f"import refuses the log: {refusal}" if refusal else f"Next: {next_command}{more}"
    page = proposal_text(proposal) + (f"\n\n{following}" if next_command else "")
    written = [str(path) for path in texts]
    content = as_json(proposal, written, "" if refusal else next_command) | {"refusal": refusal}
    if undecided:
        print(f"no {BESIDE} written: {', '.join(undecided)} not decided", file=sys.stderr)
    return Result(page, content, tuple(texts))


def _in_si(proposal: Proposal) -> Proposal:
    """The proposal for a log whose importer knows its units; only likelier other units remain open."""
    guesses = [guess for guess in proposal.guesses if guess.decided or guess.value not in SI]
    return replace(proposal, guesses=tuple(guesses))


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


def _table(logs: Sequence[Path], rate: float | None, chosen: Mapping[str, Names]) -> Table | None:
    """The longest table of each log, joined; None for logs that are not tables."""
    other = [log for log in logs if not IMPORTERS[kind_of(log)].table]
    if other:
        if rate is not None or chosen:
            option = "--columns is for tables" if chosen else "--rate is for tables without time"
            raise RecordingError(f"{other[0]} has its own columns and its own time; {option}")
        if len(other) < len(logs):
            raise RecordingError(f"{other[0]} is not a table like the other logs; give logs of one kind")
        return None
    tables = [_longest(log, rate, chosen) for log in logs]
    _require_same(logs, [table.names for table in tables])
    clock = str(chosen.get("time", ""))
    column_names = [CLOCK if name == clock else name for name in tables[0].names]
    values = (
        one_after_another(column_names, [table.values for table in tables])
        if len(tables) > 1
        else tables[0].values
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
    logs: Sequence[Path], table: Table | None, model: Model, chosen: Mapping[str, Names]
) -> Proposal:
    if table is not None:
        log = log_columns(Columns(logs[0], table, model.robot), chosen)
        return log.restored(propose(log.names, log.values, model, table.joints))
    columns = [_columns(max(_runs(log, model), key=lambda run: run.duration)) for log in logs]
    _require_same(logs, [names for names, _ in columns])
    names = columns[0][0]
    return propose(names, one_after_another(names, [values for _, values in columns]), model)


def _runs(log: Path, model: Model) -> list[Recording]:
    runs = import_source(log, model)
    if not runs:
        raise RecordingError(f"{log} contains no runs")
    return runs


def _columns(run: Recording) -> tuple[list[str], np.ndarray]:
    """A recording as named columns, at the times of its positions."""
    time = run.signals["position"].time
    names, columns = ["time [s]"], [time]
    for signal in ("position", "velocity", *EFFORT):
        if signal in run.signals:
            known = run.signals[signal]
            unit = " [rad]" if signal == "position" else ""
            names += [f"{joint} {signal}{unit}" for joint in run.robot.joints]
            columns += [np.interp(time, known.time, values) for values in known.values.T]
    return names, np.column_stack(columns)


def _require_free(texts: dict[Path, str], args: Namespace) -> None:
    """Raise if a file cannot be written or would be overwritten."""
    for path in texts:
        require_file(path, "--output" if path == args.output else "--preset", [*args.logs, args.robot])
        if path.exists() and not args.force:
            raise FileExistsError(17, "this file exists; --force overwrites it", str(path))


def _next_command(args: Namespace, proposal: Proposal, table: bool, preset: Path) -> str:
    """Command line that imports the log as proposed."""
    # A recording needs no import; it is identified with the new robot.
    verb = "identify" if not table and kind_of(args.logs[0]) == "exidyn" else "import"
    words = ["exidyn", verb, str(args.logs[0]), "--robot", str(args.output)]
    if table and args.preset:
        words += ["--preset", str(preset)]
    if not table:
        effort = _effort_option(proposal, kind_of(args.logs[0]))
        words += [word for name, value in effort.items() for word in (f"--{name}", value)]
    return shlex.join(words)
