"""exidyn export: a model for simulators, a recording as a table, and what these cannot represent."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from exidyn.identify.export import FORMATS, Portable
from exidyn.identify.file_names import file_stem
from exidyn.identify.fit.fit import Moved
from exidyn.identify.fit.fit_file import read_fit
from exidyn.identify.model import Model
from exidyn.identify.recordings.importers.tables.columns import TABLES, left_out
from exidyn.identify.recordings.mcap.mcap_file import read_recording
from exidyn.identify.text_table import digits, paragraph

from ..arguments.command import Command, Option, table_help
from ..arguments.options import JSON, output_option, require_file, require_json
from ..files.given_runs import ARM_HELP, read_arm
from ..terminal.json_output import hand_over, json_text, print_written, write_whole


@Command(
    "Write a model for a simulator, or a recording as a table, and list what that leaves out.",
    (
        "exidyn export exidyn-fit/fit.json --to mjcf",
        "exidyn export exidyn-fit/fit.json --to urdf --payload L --output loaded.urdf",
        "exidyn export run.mcap --to csv",
    ),
    (
        Option("arm ARM", ARM_HELP),
        Option("--to FORMAT", ", ".join((*FORMATS, *TABLES)), (*FORMATS, *TABLES), required=True),
        output_option("FILE", meaning="default: the robot's name, or the recording's, then -export"),
        JSON,
        Option("--payload NAME", "payload of the model that becomes part of the last link", default=""),
    ),
    table_help("formats of a model", {name: form.text for name, form in FORMATS.items()})
    + "\n\n"
    + table_help("formats of a recording (.mcap)", TABLES),
)
def export_command(given: Namespace) -> None:
    """Write the file, and print what is missing in it."""
    require_json(given.json)
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
        robot, missing, content = portable.robot, form.leaves_out(portable), form.text(portable)
        path = given.output or Path(f"{file_stem(robot.name, 'robot')}-export{form.ending}")
    require_file(path, "--output", [given.arm])
    write_whole(path, content)
    table = {
        "exidyn_export": 1,
        "robot": robot.name,
        "joints": list(robot.joints),
        "format": given.to,
        "leaves_out": list(missing),
        "moved": [one._asdict() for one in moved],
        "written": str(path),
    }
    hand_over(_summary(given.to, missing, moved), json_text(table), given.json)
    print_written(path)


def _moved(source: str, model: Model) -> tuple[Moved, ...]:
    """Base parameters of a fit that its model has beyond their 95 %; none of what is no fit."""
    if not source.endswith(".json"):
        return ()
    fit = read_fit(source)
    return replace(fit, exported=fit.base.regrouping @ model.nominal_values).moved


def _summary(name: str, missing: Sequence[str], moved: Sequence[Moved]) -> str:
    lines = [f"{name}: not in it" if missing else f"{name}: everything is in it"]
    for sentence in missing:
        lines += paragraph(sentence, "    ", "  - ")
    if moved:
        lines += ["moved beyond their 95 % to the nearest that an arm can have"]
    for one in moved:
        far = f"{one.deviations:.1f} standard deviations"
        lines.append(f"  - {one.name} from {digits(one.value)} to {digits(one.exported)}, {far}")
    return "\n".join(lines)
