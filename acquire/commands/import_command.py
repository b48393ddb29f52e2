"""exidyn import: convert logs of other tools to recordings."""

import sys
from argparse import ArgumentTypeError, Namespace
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from exidyn.identification.errors import RecordingError, listed
from exidyn.identification.file_names import distinct_stems
from exidyn.identification.plausible.gate import suspect
from exidyn.identification.plausible.position_servos import servo_gain_doubts
from exidyn.identification.recordings.align import aligned
from exidyn.identification.recordings.importers import IMPORTERS, import_source, kind_of
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.recording import EFFORT, SIGNALS, Recording
from exidyn.identification.recordings.servo_error import COMMAND
from exidyn.identification.recordings.tables.preset import preset_names
from exidyn.identification.recordings.time_order import PART
from exidyn.identification.recordings.units import BEFORE_GEAR
from exidyn.identification.robot_files.description import XML
from exidyn.identification.robot_files.mjcf import compile_mjcf
from exidyn.identification.robot_files.mjcf_drives import servo_stiffness
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import digits

from ..arguments.command import Command, Option, name_lines, positive
from ..arguments.options import JSON, make_folder, output_option, require_file, robot_option
from ..terminal.recording_text import payload_words, recording_table, warning_lines
from .result import Result

NAMES = """columns of a table, unless --columns names others (joints count from 1):
  t                    time [s]
  q1, q2, ...          position [rad]
  dq1, ...             velocity [rad/s]
  i1, ...              current of the motor [A]
  tau1, ...            torque [N m]
  temp1, ...           temperature of the motor [degC]
  ql1, ...             position of a second encoder on the link side [rad]
  q_ref1, ...          commanded position [rad]
  dq_ref1, ...         commanded velocity [rad/s]
t, all q and all i or tau are needed. An array q has the columns q1, q2, ...
A file preset.toml beside the log, or --preset, states other names, units and
signs (docs/import.md).
"""


def _listed(text: str) -> str | list[str]:
    """The list of a text with commas, or the text itself."""
    return text.split(",") if "," in text else text


def named(text: str) -> tuple[str, str | list[str]]:
    """A signal and its value: one text, or a list with one text per joint."""
    signal, equals, values = text.partition("=")
    if not equals:
        raise ArgumentTypeError(f"'{text}' is not SIGNAL=NAME")
    return signal, _listed(values)


COLUMNS = Option(
    "--columns SIGNAL=COLUMN...",
    f"columns of a table: time or one of {', '.join(SIGNALS)}; one column per joint with commas, "
    "q1..6 for six columns, or a pattern with {number}, {index} (from 0) or {joint}",
    named,
)
NAMED = (
    COLUMNS,
    Option(
        "--preset PRESET",
        f"file with names, units and signs of a table's columns, or one of {', '.join(preset_names())}; "
        "default: preset.toml beside the log, or the preset that matches its columns",
    ),
    Option(
        "--joints NAMES",
        "names of the joints in the log, in the robot's order, with commas; or a pattern with {joint} or "
        "{number}",
        _listed,
    ),
    Option("--topic TOPIC", "topic of the joint states in a bag with several; or several with commas"),
    Option(
        f"--effort {{{','.join((*EFFORT, COMMAND))}}}",
        "meaning of effort in a bag or data set, default: torque; command: the table has no effort, and the "
        "position error of its servos replaces the current",
        (*EFFORT, COMMAND),
    ),
)
"""Options on names and meanings in a table or a bag."""
DEGREES = Option(
    "--degrees", "positions, velocities and commands are in degrees; for percent of travel see --units"
)
UNITS = Option(
    "--units SIGNAL=UNIT...",
    "units of a table's columns, one for all joints or one per joint with commas: time=ms, current=mA, "
    "...; for positions also %% (-100 to 100) and 0-100%% of each joint's range",
    named,
)
RATE = Option("--rate HZ", "sampling rate of a table or arrays without time", positive)
MOTOR_SIDE = Option(
    "--motor-side [SIGNAL...]",
    f"signals on the motor side of the gear, of {', '.join(BEFORE_GEAR)}; all if none is named. Torque "
    "is multiplied, the others are divided by the robot's [drive] gear_ratio",
    BEFORE_GEAR,
)


@Command(
    "Convert logs of other tools to recordings. The kind of a log is recognized from its\nname and content.",
    (
        "exidyn import run.csv --robot robot.toml",
        "exidyn import run.csv --robot robot.toml --columns position=A{number} current=I1,I2",
        "exidyn import bag --robot robot.toml --joints left_{joint} --effort current",
        "exidyn import trace_folder --align run.mcap -o traced",
    ),
    (
        Option("source SOURCE", "file or folder", Path),
        robot_option("not for --align, which has its own"),
        Option("--kind KIND", "one of the kinds below", IMPORTERS),
        output_option("FOLDER", Path(), "folder, or FILE.mcap for a single run; default: this folder"),
        JSON,
        *NAMED,
        DEGREES,
        UNITS,
        RATE,
        MOTOR_SIDE,
        Option(
            "--align RUN",
            "recording (.mcap) of the same run: times are shifted to its clock, to where the positions agree "
            "best, and its robot, payload, trajectory and settings are copied",
            Path,
        ),
    ),
    f"{name_lines('kinds', {name: entry.content for name, entry in IMPORTERS.items()})}\n\n{NAMES}",
)
def import_command(args: Namespace) -> Result:
    """Import the log, write its runs, and print their contents."""
    run = read_recording(args.align) if args.align else None
    model = read_model(args.robot) if args.robot else (run.model if run else None)
    trace = run is not None and (args.kind or kind_of(args.source)) == "kuka_trace"
    options = import_options(args) | (_axes(run) if run and trace else {})
    recordings = import_source(args.source, model, args.kind, **options)
    if not recordings:
        raise RecordingError(f"{args.source} contains no runs")
    single = args.output.suffix == ".mcap"
    if single:
        _require_single(args.output, recordings, args.source)
    else:
        make_folder(args.output)
    if run is not None:
        recordings = [aligned(recording, run) for recording in recordings]
    stems = distinct_stems([recording.name for recording in recordings], "run")
    paths = [args.output] if single else [args.output / f"{stem}.mcap" for stem in stems]
    written = dict(zip(paths, recordings, strict=True))
    tables = []
    for path, recording in written.items():
        write_recording(recording, path)
        suspicion = suspect([recording], recording.model) if model is not None else None
        doubts = filter(None, [*_servo_doubts(args, recording), suspicion])
        for line in [*warning_lines(recording), *(f"warning: {recording.name}: {doubt}" for doubt in doubts)]:
            print(line, file=sys.stderr)
        suspected = suspicion and asdict(suspicion)
        tables.append(recording_table(recording) | {"written": str(path), "suspicion": suspected})
    page = "\n".join(_line(recording, path) for path, recording in written.items())
    return Result(page, {"exidyn_import": 1, "recordings": tables})


def _servo_doubts(args: Namespace, recording: Recording) -> list[str]:
    """Doubts whether the servos of the robot's MJCF are those of a log without effort."""
    if args.robot is None or Path(args.robot).suffix.lower() not in XML or recording.robot.servo is not None:
        return []
    stiffness = servo_stiffness(compile_mjcf(Path(args.robot)), recording.robot.joints)
    return [] if stiffness is None else servo_gain_doubts([recording], recording.model, stiffness)


def _axes(run: Recording) -> dict[str, list[float]]:
    """Signs and zeros of the controller's axes, which a trace does not contain."""
    texts = {name: run.settings.get(f"driver {name}", "") for name in ("sign", "zero")}
    return {name: [float(n) for n in text.split() if n != "rad"] for name, text in texts.items() if text}


def import_options(args: Namespace) -> dict[str, Any]:
    """Options of a command for the importer, which refuses those that the kind of log does not have."""
    names = ("degrees", "motor_side", "preset", "joints", "topic", "effort", "rate", "columns", "units")
    options = {name: getattr(args, name, None) for name in names}
    options["motor_side"] = True if options["motor_side"] == [] else options["motor_side"]
    options |= {name: dict(options[name] or ()) or None for name in ("columns", "units")}
    return {name: value for name, value in options.items() if value is not None and value is not False}


def _require_single(path: Path, recordings: Sequence[Recording], source: Path) -> None:
    """Raise if several runs would be written to one file."""
    if len(recordings) > 1:
        names = [recording.name for recording in recordings]
        _, colon, where = recordings[0].settings.get(PART, "").partition(": ")
        raise RecordingError(
            f"{source} contains {len(recordings)} runs ({listed(names)}{colon}{where}), but --output {path} "
            f"is one file. Name a folder: --output {path.with_suffix('')}"
        )
    require_file(path, "--output", [source])


def _line(recording: Recording, path: Path) -> str:
    signals = ", ".join(
        f"{name} {digits(signal.rate) if signal.rate else '-'} Hz"
        for name, signal in recording.signals.items()
    )
    payload = f"; payload {payload_words(recording)}" if recording.payload else ""
    preset = f"; preset {recording.settings['preset']}" if "preset" in recording.settings else ""
    return f"{path}: {recording.robot.name}, {recording.duration:.3f} s, {signals}{payload}{preset}"
