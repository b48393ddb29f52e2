"""exidyn export: a model for simulators, a recording as a table, and what these cannot represent."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path

import numpy as np

from exidyn.identification.errors import RobotError
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.export.mjcf_changes import Change
from exidyn.identification.export.mjcf_patch import Patch, patch
from exidyn.identification.file_names import file_stem
from exidyn.identification.fit.fit import Moved
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.fit.identified import Standard, standard_parameters
from exidyn.identification.model import Model
from exidyn.identification.recordings.importers.tables.written import TABLES, left_out
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.text_table import digits, paragraph
from exidyn.identification.text_table import table as text_table

from ..arguments.command import Command, Option, table_help
from ..arguments.options import JSON, output_option, require_file, require_json
from ..files.given_runs import ARM_HELP, read_arm
from ..terminal.json_output import hand_over, json_text, print_written, write_whole


@Command(
    "Write a model for a simulator, or a recording as a table, and list what that leaves out.",
    (
        "exidyn export exidyn-fit/fit.json --to mjcf",
        "exidyn export exidyn-fit/fit.json --to urdf --payload L --output loaded.urdf",
        "exidyn export exidyn-fit/fit.json --to mjcf --patch arm.xml",
        "exidyn export run.mcap --to csv",
    ),
    (
        Option("arm ARM", ARM_HELP),
        Option("--to FORMAT", ", ".join((*FORMATS, *TABLES)), (*FORMATS, *TABLES), required=True),
        output_option("FILE", meaning="default: the robot's name, or the recording's, then -export"),
        JSON,
        Option("--payload NAME", "payload of the model that becomes part of the last link", default=""),
        Option(
            "--patch ARM.xml",
            "with --to mjcf: change this file, of which the robot is, only where needed",
            Path,
        ),
    ),
    table_help("formats of a model", {name: form.text for name, form in FORMATS.items()})
    + "\n\n"
    + table_help("formats of a recording (.mcap)", TABLES),
)
def export_command(given: Namespace) -> None:
    """Write the file, and print what is missing in it."""
    require_json(given.json)
    _check_patch(given)
    changes: tuple[Change, ...] | None = None
    content: str | bytes
    moved: tuple[Moved, ...] = ()
    if given.to in TABLES:
        recording = read_recording(given.arm)
        robot, missing, content = recording.robot, left_out(recording), TABLES[given.to](recording)
        path = given.output or Path(f"{Path(given.arm).stem}-export.{given.to}")
    else:
        model = read_arm(given.arm)
        moved = _moved(given.arm, model)
        portable, form = Portable.of(model, given.payload), FORMATS[given.to]
        robot = portable.robot
        if given.patch is None:
            missing, content = form.leaves_out(portable), form.text(portable)
            path = given.output or Path(f"{file_stem(robot.name, 'robot')}-export{form.ending}")
        else:
            made = _patched(given, portable)
            missing, content, changes = list(made.left), made.text, made.changes
            path = given.output or given.patch.with_stem(f"{given.patch.stem}-identified")
    require_file(path, "--output", [given.arm, *([given.patch] if given.patch else [])])
    write_whole(path, content)
    table = {
        "exidyn_export": 1,
        "robot": robot.name,
        "joints": list(robot.joints),
        "format": given.to,
        "leaves_out": list(missing),
        "moved": [one._asdict() for one in moved],
        **({} if changes is None else {"changes": [_change(one) for one in changes]}),
        "written": str(path),
    }
    text = _summary(given.to, missing, moved, () if changes is None else _changes(changes))
    hand_over(text, json_text(table), given.json)
    print_written(path)


def _check_patch(given: Namespace) -> None:
    """Refuse what goes with no patch.

    Raises:
        RobotError: Another format, or a payload, which is no part of the arm's file.
    """
    if given.patch is None:
        return
    if given.to != "mjcf":
        raise RobotError(f"--patch changes an MJCF; with --to {given.to} the whole model is written")
    if given.payload:
        raise RobotError(f"--patch changes the arm's own file, of which payload {given.payload} is no part")


def _patched(given: Namespace, portable: Portable) -> Patch:
    """The user's MJCF with what the fit found, or with the values of what is no fit."""
    if given.arm.endswith(".json"):
        found = standard_parameters(read_fit(given.arm))
    else:
        priors = portable.model.priors
        found = Standard(portable.model.nominal_values, np.diag([prior.std**2 for prior in priors]))
    try:
        text = given.patch.read_bytes()
    except OSError as error:
        raise RobotError(f"{given.patch} cannot be read: {error.strerror}") from error
    return patch(portable, found, text, str(given.patch.resolve().parent), str(given.patch))


def _change(one: Change) -> dict[str, object]:
    known = np.isfinite(one.half)
    return one._asdict() | {"half": one.half if known else None, "told_apart": one.told_apart}


def _changes(changes: Sequence[Change]) -> list[str]:
    """The numbers of the file that are others now, as a table."""
    if not changes:
        return ["nothing is another number now"]
    rows: list[list[str]] = []
    for where, own in groupby(changes, lambda one: one.where):
        rows.append([where])
        rows += [
            [one.attribute, one.unit, digits(one.old), digits(one.new), digits(one.half), _near(one)]
            for one in own
        ]
    head = ("changed", "unit", "old", "new", "± 95 %", "note")
    return [*text_table(head, rows, left=(0, 1, 5)), ""]


def _near(change: Change) -> str:
    """Whether a number may be the old one as well."""
    return "" if change.told_apart else "or as it was"


def _moved(source: str, model: Model) -> tuple[Moved, ...]:
    """Base parameters of a fit that its model has beyond their 95 %; none of what is no fit."""
    if not source.endswith(".json"):
        return ()
    fit = read_fit(source)
    return replace(fit, exported=fit.base.regrouping @ model.nominal_values).moved


def _summary(name: str, missing: Sequence[str], moved: Sequence[Moved], changes: Sequence[str] = ()) -> str:
    lines = [*changes, f"{name}: not in it" if missing else f"{name}: everything is in it"]
    for sentence in missing:
        lines += paragraph(sentence, "    ", "  - ")
    if moved:
        lines += ["moved beyond their 95 % to the nearest that an arm can have"]
    for one in moved:
        far = f"{one.deviations:.1f} standard deviations"
        lines.append(f"  - {one.name} from {digits(one.value)} to {digits(one.exported)}, {far}")
    return "\n".join(lines)
