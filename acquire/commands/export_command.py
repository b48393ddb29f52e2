"""exidyn export: a model for other simulators, and what they cannot represent."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.export import FORMATS, Portable
from exidyn.identify.text_table import paragraph

from ..arguments.common import command_parser, table_help
from ..arguments.outputs import add_json, add_output, require_file, require_json
from ..files.arm_file import ARM_HELP, read_arm
from ..terminal.json_output import hand_over, json_text, write_whole

EXAMPLES = (
    "exidyn export exidyn-fit/fit.json --to mjcf",
    "exidyn export exidyn-fit/fit.json --to urdf --payload L --output loaded.urdf",
)


def main(arguments: Sequence[str]) -> int:
    """Write the file, and print what is missing in it."""
    given = parser().parse_args(arguments)
    require_json(given.json)
    portable, form = Portable.of(read_arm(given.arm), given.payload), FORMATS[given.to]
    path = given.output or Path(f"{portable.robot.name.replace(' ', '_')}-export{form.ending}")
    require_file(path, "--output", [given.arm])
    write_whole(path, form.text(portable))
    missing = form.leaves_out(portable)
    table = {
        "exidyn_export": 1,
        "robot": portable.robot.name,
        "joints": list(portable.robot.joints),
        "format": given.to,
        "leaves_out": list(missing),
        "written": str(path),
    }
    hand_over(_summary(given.to, missing), json_text(table), given.json)
    print(f"written: {path}", file=sys.stderr)
    return 0


def _summary(name: str, missing: Sequence[str]) -> str:
    if not missing:
        return f"{name}: everything is in it"
    lines = [f"{name}: not in it"]
    for sentence in missing:
        lines += paragraph(sentence, "    ", "  - ")
    return "\n".join(lines)


def parser() -> argparse.ArgumentParser:
    """What `exidyn export` takes."""
    found = command_parser(
        "export",
        "Write an identified or nominal model for a simulator, and list what that leaves out.",
        EXAMPLES,
        table_help("formats", {name: form.text for name, form in FORMATS.items()}),
    )
    found.add_argument("arm", metavar="ARM", help=ARM_HELP)
    found.add_argument("--to", required=True, choices=FORMATS, metavar="FORMAT", help=", ".join(FORMATS))
    add_output(found, "FILE", meaning="default: the robot's name, then -export")
    add_json(found)
    found.add_argument(
        "--payload",
        default="",
        metavar="NAME",
        help="payload of the model that becomes part of the last link",
    )
    return found
