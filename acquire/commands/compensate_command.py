"""exidyn compensate: write the torque for gravity, friction and motion from a fit, for a controller."""

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from exidyn.identification.arm.robot import Robot, ServoLaw
from exidyn.identification.errors import FitError
from exidyn.identification.feedforward.cpp_file import cpp_file
from exidyn.identification.feedforward.feedforward import (
    SHARE,
    Feedforward,
    Summary,
    make_feedforward,
    summary,
)
from exidyn.identification.feedforward.python_file import python_file
from exidyn.identification.file_names import file_stem, write_whole
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.robot_files.mjcf import compile_mjcf
from exidyn.identification.robot_files.mjcf_drives import servo_law
from exidyn.identification.text_table import digits, paragraph, table

from ..arguments.command import Command, Option, percent, positive
from ..arguments.options import JSON, output_option, payload_name, require_file
from .result import Result

ENDINGS = (".py", ".hpp")
"""Files that are written: Python, and C++17."""


@Command(
    "Write the torque for gravity, friction and motion from a fit, as Python and as C++.",
    (
        "exidyn compensate exidyn-fit/fit.json",
        "exidyn compensate exidyn-fit/fit.json --payload L --output arm.hpp",
        "exidyn compensate exidyn-fit/fit.json --robot arm-identified.xml  # offset against sag",
    ),
    (
        Option("fit FIT", "fit.json of exidyn identify", Path),
        output_option("FILE", meaning=".py or .hpp; default: both, named after the robot"),
        JSON,
        Option("--payload NAME", "payload of the fit on the flange; default: none", payload_name, ""),
        Option("--robot ROBOT", "MJCF with the arm's position servos; default: those of the fit", Path),
        Option(
            "--standstill RAD/S",
            "speed below which friction is not compensated: 5 times the noise of the controller's velocity; "
            "default: the speed below which joints stood in the runs of the fit",
            positive,
        ),
        Option(
            "--friction PERCENT",
            f"share of the friction that is compensated, below 100; default: {100 * SHARE:g}",
            percent,
            SHARE,
        ),
    ),
    """Both files have inverse_dynamics, gravity, friction, friction_compensation and
compensation (gravity plus friction); with drive gains also current, and with
position servos position_offset, which is added to the command.""",
)
def compensate_command(args: Namespace) -> Result:
    """Write the files; print their torques and what they lack."""
    fit = read_fit(args.fit)
    servos = None if args.robot is None else _servos(args.robot, fit.model.robot.joints)
    feedforward = make_feedforward(fit, args.payload, servos, args.standstill, args.friction)
    paths = _paths(args.output, feedforward)
    for path in paths:
        require_file(path, "--output", [args.fit])
        write_whole(path, python_file(feedforward) if path.suffix == ".py" else cpp_file(feedforward))
    results = summary(feedforward)
    content = {
        "exidyn_feedforward": 1,
        "robot": feedforward.robot.name,
        "joints": list(feedforward.robot.joints),
        "payload": args.payload,
        "unit": feedforward.unit,
        **results._asdict(),
        "band": feedforward.band,
        "share": feedforward.share,
        "remarks": list(feedforward.remarks),
        "written": [str(path) for path in paths],
    }
    return Result("\n".join(_page(feedforward, results)), content, paths)


def _servos(path: Path, joints: Sequence[str]) -> ServoLaw:
    """Law of the position servos of an MJCF."""
    law = servo_law(compile_mjcf(path), joints)
    if law is None:
        raise FitError(f"--robot {path}: not every joint of the fit has a position servo there")
    return law


def _paths(output: Path | None, feedforward: Feedforward) -> list[Path]:
    """Files to write."""
    if output is None:
        stem = file_stem(feedforward.robot.name, "robot")
        return [Path(f"{stem}-feedforward".replace("-", "_") + ending) for ending in ENDINGS]
    if output.suffix not in ENDINGS:
        raise FitError(f"--output {output}: the name must end in {' or '.join(ENDINGS)}")
    return [output]


def _page(feedforward: Feedforward, results: Summary) -> list[str]:
    """Table of the joints, its words, and the remarks."""
    robot = feedforward.robot
    torque = feedforward.unit if feedforward.unit == "A" else _units(robot, "N m")
    columns = {
        f"gravity [{torque}]": results.gravity,
        f"friction [{torque}]": results.friction,
        f"compensated [{torque}]": results.compensated,
        f"from [{_units(robot, 'rad/s')}]": feedforward.band,
    }
    words = (
        "gravity: largest torque at rest within the position limits. friction: at twice the speed from which "
        "it is compensated, and how much of it is compensated. from: that speed."
    )
    if results.offset is not None:
        columns[f"sag [{_units(robot, 'rad')}/1000]"] = 1e3 * results.offset
        words += " sag: largest position offset of the servos."
    rows = [
        [joint, *(digits(values[j]) for values in columns.values())] for j, joint in enumerate(robot.joints)
    ]
    lines = [*paragraph(f"Feedforward: {feedforward.title}"), ""]
    lines += [*table(["joint", *columns], rows, left=(0,)), "", *paragraph(words)]
    for remark in feedforward.remarks:
        lines += paragraph(remark, "    ", "  - ")
    return lines


def _units(robot: Robot, turning: str) -> str:
    """Units of the joints, each once."""
    return "/".join(dict.fromkeys(robot.units(turning)))
