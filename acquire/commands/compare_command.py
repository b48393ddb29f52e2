"""exidyn compare: compare a simulation with a recording."""

import shlex
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

from exidyn.identification.errors import RecordingError
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.model import Model
from exidyn.identification.pages.compared_document import compared_text, differs
from exidyn.identification.recordings.align import nearest
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import model_text, read_model
from exidyn.identification.simulation.comparison import Comparison, compare

from ..arguments.command import Command, Option, number
from ..arguments.options import JSON, robot_option
from ..files.report_files import comparison_table
from ..terminal.json_output import hand_over, json_text


@Command(
    "Compare a simulation with a recording of the same motion: where they differ, and by how much.",
    (
        "exidyn compare sim.mcap real.mcap",
        "exidyn compare mujoco.csv real.mcap --robot robot.toml --json compared.json",
    ),
    (
        Option("simulated SIM", "recording of a simulator (.mcap, .csv), or another run", Path),
        Option("recorded REAL", "recording of the real arm", Path),
        robot_option("for tables, which do not contain their robot"),
        Option("--offset S", "added to the time of SIM; default: where the positions agree best", number),
        Option("--fit FIT", "fit.json that sets filters and noise floor", Path),
        JSON,
    ),
)
def compare_command(args: Namespace) -> None:
    """Compare both recordings, print the result, write the JSON."""
    model = read_model(args.robot) if args.robot else None
    simulated, recorded = (_single(path, model) for path in (args.simulated, args.recorded))
    if simulated.name == recorded.name:
        simulated = replace(simulated, name=str(args.simulated))
    comparison = _compared(simulated, recorded, args.offset, read_fit(args.fit) if args.fit else None)
    next_commands = _next_commands(args, simulated, recorded)
    page = [compared_text(comparison)]
    if differs(comparison):
        page += ["To find the physics that differs:", *(f"  {line}" for line in next_commands)]
    hand_over("\n".join(page), json_text(comparison_table(comparison, next_commands)), args.json)


def _compared(simulated: Recording, recorded: Recording, offset: float | None, fit: Fit | None) -> Comparison:
    """Compare both on one clock."""
    if offset is not None:
        return compare(simulated, recorded, offset, fit)
    alignment, repeat = nearest(simulated, recorded)
    comparison = compare(simulated, recorded, alignment.offset, fit)
    if not repeat:
        return comparison
    warning = (
        f"both agree as well {repeat:.2f} s further, since the motion repeats itself; "
        "state the offset of the clocks with --offset"
    )
    return replace(comparison, warnings=(*comparison.warnings, warning))


def _single(path: Path, model: Model | None) -> Recording:
    """The only recording at a path."""
    recordings = import_source(path, model)
    if len(recordings) != 1:
        names = ", ".join(recording.name for recording in recordings)
        raise RecordingError(
            f"{path} holds {len(recordings)} recordings: {names or 'none'}; write the intended one to a "
            "separate file with exidyn import"
        )
    return recordings[0]


def _next_commands(args: Namespace, simulated: Recording, recorded: Recording) -> list[str]:
    """Commands that diagnose the simulation's model with the recording."""
    real = shlex.quote(str(args.recorded))
    if args.robot:
        return [f"exidyn diagnose {shlex.quote(args.robot)} {real}"]
    if model_text(simulated.model) == model_text(recorded.model):
        return [f"exidyn diagnose {real}"]
    model = shlex.quote(str(args.simulated.with_name(f"{args.simulated.stem}-model.toml")))
    return [
        f"exidyn export {shlex.quote(str(args.simulated))} --to toml -o {model}",
        f"exidyn diagnose {model} {real}",
    ]
