"""exidyn export: a model for other simulators, and what they have no words for."""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from exidyn.identify.errors import RobotError
from exidyn.identify.export import FORMATS, Portable
from exidyn.identify.text_table import paragraph

from .arm_file import ARM_HELP, read_arm
from .table_help import table_help

EXAMPLE = """\
examples:
  exidyn export exidyn-fit/fit.json --to mjcf
  exidyn export exidyn-fit/fit.json --to urdf --payload L --output loaded.urdf"""


def main(arguments: Sequence[str]) -> int:
    """Write the file, and print what is missing in it."""
    given = _parser().parse_args(arguments)
    portable, form = Portable.of(read_arm(given.arm), given.payload), FORMATS[given.to]
    path = given.output or Path(f"{portable.robot.name.replace(' ', '_')}-export{form.ending}")
    if path.exists() and path.resolve() == Path(given.arm).resolve():
        raise RobotError(f"{path} is what is exported; name another file with --output")
    part = path.with_name(path.name + ".part")
    part.write_text(form.text(portable), encoding="utf-8")
    os.replace(part, path)
    print(_summary(given.to, form.leaves_out(portable)))
    print(f"written: {path}", file=sys.stderr)
    return 0


def _summary(name: str, missing: Sequence[str]) -> str:
    if not missing:
        return f"{name}: everything is in it"
    lines = [f"{name}: not in it"]
    for sentence in missing:
        lines += paragraph(sentence, "    ", "  - ")
    return "\n".join(lines)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="exidyn export",
        description="Write an identified or believed model for a simulator, and say what that leaves out.",
        epilog=f"{EXAMPLE}\n\n{table_help('formats', {name: form.text for name, form in FORMATS.items()})}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("arm", metavar="ARM", help=ARM_HELP)
    parser.add_argument("--to", required=True, choices=FORMATS, metavar="FORMAT", help=", ".join(FORMATS))
    parser.add_argument(
        "--output", "-o", type=Path, metavar="FILE", help="default: the robot's name, then -export"
    )
    parser.add_argument(
        "--payload",
        default="",
        metavar="NAME",
        help="payload of the model that becomes part of the last link",
    )
    return parser
