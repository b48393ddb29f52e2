"""exidyn info: what is inside a recording."""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from exidyn.identify.effects import EFFECTS
from exidyn.identify.recordings.importers import import_source
from exidyn.identify.recordings.recording import SIGNALS, Recording
from exidyn.identify.robot_files.robot_file import read_model
from exidyn.identify.text_table import digits, paragraph, table

from ..arguments.common import add_robot, command_parser
from ..terminal.info_course import course_lines
from ..terminal.json_output import add_json, hand_over, json_text, require_json
from ..terminal.recording_table import recording_table

EXAMPLES = ("exidyn info run.mcap", "exidyn info run.mcap --json -")


def main(arguments: Sequence[str]) -> int:
    """Print what a recording holds."""
    given = parser().parse_args(arguments)
    require_json(given.json)
    model = read_model(given.robot) if given.robot else None
    recordings = [recording for path in given.runs for recording in import_source(path, model)]
    table = {"exidyn_info": 1, "recordings": [recording_table(recording) for recording in recordings]}
    hand_over("\n\n".join(map(describe, recordings)), json_text(table), given.json)
    return 0


def parser() -> argparse.ArgumentParser:
    """What `exidyn info` takes."""
    found = command_parser("info", "Print what is inside recordings.", EXAMPLES)
    found.add_argument(
        "runs", nargs="+", type=Path, metavar="RUN", help="recording (.mcap), table (.csv) or case folder"
    )
    add_robot(found, "for tables, which do not say of which robot they are")
    add_json(found)
    return found


def describe(recording: Recording) -> str:
    """Robot, signals, ranges, payload, settings and doubts of a recording, in lines."""
    robot, model = recording.robot, recording.model
    names = {kind: name for name, kind in EFFECTS.items()}
    facts = {
        "robot": f"{robot.name}: {', '.join(robot.joints)}",
        "model": ", ".join(dict.fromkeys(names[type(effect)] for effect in model.effects)),
        "duration": f"{recording.duration:.3f} s",
        "payload": payload_words(recording),
        "trajectory": "inside" if recording.trajectory else "none",
        **dict(recording.settings),
    }
    lines = [recording.name]
    width = max(map(len, facts)) + 2
    for name, text in facts.items():
        lines += paragraph(str(text), " " * (width + 2), f"  {name + ':':<{width}}")
    for each in (_signals(recording), _ranges(recording), course_lines(recording)):
        lines += ["", *(f"  {line}" for line in each)] if each else []
    return "\n".join(lines + warning_lines(recording))


def payload_words(recording: Recording) -> str:
    """What hung on the flange."""
    if recording.payload is None:
        return "none"
    known = ", ".join(f"{name} {digits(value)}" for name, value in recording.payload.known)
    return f"{recording.payload.name}: {known or 'nothing known'}"


def warning_lines(recording: Recording) -> list[str]:
    """The recording's doubts, a sentence each."""
    return [line for doubt in recording.warnings for line in paragraph(doubt, " " * 11, "  warning: ")]


def _signals(recording: Recording) -> list[str]:
    """Table of the signals."""
    rows = [
        [name, SIGNALS[name], str(len(signal)), digits(signal.rate) if signal.rate else "-"]
        for name, signal in recording.signals.items()
    ]
    return table(["signal", "unit", "samples", "Hz"], rows, left=(0, 1))


def _ranges(recording: Recording) -> list[str]:
    """Table of the range that each joint covers in each signal."""
    columns = [[_range(column) for column in s.values.T] for s in recording.signals.values()]
    rows = [list(row) for row in zip(recording.robot.joints, *columns, strict=True)]
    return table(["joint", *recording.signals], rows)


def _range(column: np.ndarray) -> str:
    known = column[np.isfinite(column)]
    if not len(known):
        return "-"
    return f"{known.min():.3g} .. {known.max():.3g}"
