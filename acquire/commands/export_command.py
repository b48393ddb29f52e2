"""exidyn export: write a model for simulators, or a recording as a table."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path

import numpy as np

from exidyn.identification.errors import RobotError
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.export.changes import Change
from exidyn.identification.export.mjcf_patch import Patch, patch
from exidyn.identification.export.urdf_patch import patch_urdf
from exidyn.identification.file_names import file_stem, read_failure, write_whole
from exidyn.identification.fit.fit import Moved
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.fit.identified import Standard, standard_parameters
from exidyn.identification.model import Model
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.recordings.tables.written import TABLES, left_out
from exidyn.identification.robot_files.description import is_mjcf
from exidyn.identification.robot_files.mjcf import compile_mjcf
from exidyn.identification.robot_files.mjcf_drives import servo_law
from exidyn.identification.text_table import digits, paragraph, raised
from exidyn.identification.text_table import table as text_table

from ..arguments.command import Command, Option, table_help
from ..arguments.options import JSON, output_option, require_file
from ..files.given_runs import ARM_HELP, read_arm
from .result import Result


@Command(
    "Write a model for a simulator, or a recording as a table, and list what the file lacks.",
    (
        "exidyn export exidyn-fit/fit.json --to urdf --payload L --output loaded.urdf",
        "exidyn export exidyn-fit/fit.json --to mjcf --patch arm.xml",
        "exidyn export run.mcap --to csv",
    ),
    (
        Option("arm ARM", ARM_HELP),
        Option("--to FORMAT", ", ".join((*FORMATS, *TABLES)), (*FORMATS, *TABLES), required=True),
        output_option("FILE", meaning="default: name of the robot or recording with -export"),
        JSON,
        Option("--payload NAME", "payload of the model to be merged into the last link", default=""),
        Option(
            "--patch ARM",
            "with --to mjcf or urdf: change only the necessary numbers of this file of the robot",
            Path,
        ),
    ),
    table_help("formats of a model", {name: form.text for name, form in FORMATS.items()})
    + "\n\n"
    + table_help("formats of a recording (.mcap)", TABLES),
)
def export_command(args: Namespace) -> Result:
    """Write the file, and print what it lacks."""
    _check_patch(args)
    changes: tuple[Change, ...] | None = None
    content: str | bytes
    moved: tuple[Moved, ...] = ()
    if args.to in TABLES:
        recording = read_recording(args.arm)
        robot, missing, content = recording.robot, left_out(recording), TABLES[args.to](recording)
        path = args.output or Path(f"{Path(args.arm).stem}-export.{args.to}")
    else:
        model = read_arm(args.arm)
        moved = _moved(args.arm, model)
        source = Path(args.arm)
        servos = servo_law(compile_mjcf(source), model.robot.joints) if is_mjcf(source) else None
        portable = Portable.of(model, args.payload, servos)
        form = FORMATS[args.to]
        robot = portable.robot
        if args.patch is None:
            missing, content = form.leaves_out(portable), form.text(portable)
            path = args.output or Path(f"{file_stem(robot.name, 'robot')}-export{form.ending}")
        else:
            patched = _patched(args, portable)
            missing, content, changes = list(patched.left_out), patched.text, patched.changes
            path = args.output or args.patch.with_stem(f"{args.patch.stem}-identified")
    require_file(path, "--output", [args.arm, args.patch])
    write_whole(path, content)
    table = {
        "exidyn_export": 1,
        "robot": robot.name,
        "joints": list(robot.joints),
        "format": args.to,
        "leaves_out": list(missing),
        "moved": [parameter._asdict() for parameter in moved],
        "written": str(path),
    }
    if changes is not None:
        table["changes"] = [change._asdict() | {"told_apart": change.told_apart} for change in changes]
    text = _summary(args.to, missing, moved, () if changes is None else _changes(changes))
    return Result(text, table, [path])


def _check_patch(args: Namespace) -> None:
    """Refuse options that exclude --patch."""
    if args.patch is None:
        return
    if args.to not in ("mjcf", "urdf"):
        raise RobotError(f"--patch changes an MJCF or URDF; with --to {args.to} the whole model is written")
    if args.payload:
        raise RobotError(
            f"--patch changes the arm's own file, which does not contain payload {args.payload}. "
            "Omit one of them"
        )


def _patched(args: Namespace, portable: Portable) -> Patch:
    """The user's MJCF or URDF with the estimates of a fit, or with the nominal values of another model."""
    if args.arm.endswith(".json"):
        parameters = standard_parameters(read_fit(args.arm))
    else:
        priors = portable.model.priors
        parameters = Standard(portable.model.nominal_values, np.diag([prior.std**2 for prior in priors]))
    try:
        text = args.patch.read_bytes()
    except OSError as error:
        raise RobotError(f"{args.patch} cannot be read: {read_failure(args.patch, error)}") from error
    if args.to == "urdf":
        return patch_urdf(portable, parameters, text, str(args.patch))
    return patch(portable, parameters, text, str(args.patch.resolve().parent), str(args.patch))


def _changes(changes: Sequence[Change]) -> list[str]:
    """Table of the changed numbers of the file."""
    if not changes:
        return ["no number changed"]
    rows: list[list[str]] = []
    for where, changes_there in groupby(changes, lambda change: change.where):
        rows.append([where])
        rows += [
            [c.attribute, c.unit, digits(c.old), digits(c.new), digits(c.half), _unchanged_note(c)]
            for c in changes_there
        ]
    head = ("changed", "unit", "old", "new", "± 95 %", "note")
    return [*text_table(head, rows, left=(0, 1, 5)), ""]


def _unchanged_note(change: Change) -> str:
    """Why a number without an interval changes; or that the old number is within the 95 % interval."""
    return change.reason or ("" if change.told_apart or not np.isfinite(change.half) else "or unchanged")


def _moved(source: str, model: Model) -> tuple[Moved, ...]:
    """Base parameters that the exported model has outside their 95 % interval; none without a fit."""
    if not source.endswith(".json"):
        return ()
    fit = read_fit(source)
    return replace(fit, exported=fit.base.regrouping @ model.nominal_values).moved


def _summary(name: str, missing: Sequence[str], moved: Sequence[Moved], changes: Sequence[str] = ()) -> str:
    lines = [*changes, f"{name} cannot represent:" if missing else f"{name} represents everything"]
    for sentence in missing:
        lines += paragraph(sentence, "    ", "  - ")
    if moved:
        lines += ["moved outside their 95 % interval to the nearest physically consistent values:"]
    for parameter in moved:
        stds = f"{parameter.deviations:.1f} standard deviations"
        lines.append(
            f"  - {parameter.name} from {digits(parameter.value)} to {digits(parameter.exported)}, {stds}"
        )
    return raised("\n".join(lines))
