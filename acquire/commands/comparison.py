"""exidyn simulate --against: compare a simulation with a recording of the same motion."""

import shlex
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.pages.compared_document import compared_document, differs
from exidyn.identification.recordings.align import nearest
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import model_text, read_model
from exidyn.identification.simulation.comparison import Comparison, compare

from ..arguments.command import Option, number
from ..arguments.options import robot_option
from ..files.given_runs import single_recording
from ..files.result_files import comparison_table
from .result import Result

COMPARISON = (
    robot_option("for tables, which do not contain their robot"),
    Option(
        "--offset S", "added to the time of the simulation; default: where the positions agree best", number
    ),
    Option("--fit FIT", "fit.json that sets filters and noise floor", Path),
)


def compare_with(args: Namespace, path: Path, note: str = "") -> Result:
    """Compare the simulation at a path with the recording of --against; the note is on the simulation."""
    model = read_model(args.robot) if args.robot else None
    simulated, recorded = (single_recording(source, model) for source in (path, args.against))
    if simulated.name == recorded.name:
        simulated = replace(simulated, name=str(path))
    comparison = _compared(simulated, recorded, args.offset, read_fit(args.fit) if args.fit else None)
    following = _next_commands(args, path, simulated, recorded)
    table = comparison_table(comparison, [f"exidyn {command}" for command in following])
    return Result(compared_document(comparison, note), table, next=following if differs(comparison) else ())


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


def _next_commands(args: Namespace, path: Path, simulated: Recording, recorded: Recording) -> list[str]:
    """Commands that diagnose the simulation's model with the recording."""
    run = shlex.quote(str(args.against))
    if args.robot:
        return [f"diagnose {run} --robot {shlex.quote(args.robot)}"]
    if model_text(simulated.model) == model_text(recorded.model):
        return [f"diagnose {run}"]
    model = shlex.quote(str(path.with_name(f"{path.stem}-model.toml")))
    return [f"export {shlex.quote(str(path))} --to toml -o {model}", f"diagnose {run} --robot {model}"]
