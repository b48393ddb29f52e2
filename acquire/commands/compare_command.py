"""exidyn compare: a simulation and a recording in; where they differ, out."""

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
from ..arguments.options import JSON, require_json, robot_option
from ..files.report_files import comparison_table
from ..terminal.json_output import hand_over, json_text


@Command(
    "Lay a simulation beside a recording of the same motion: where they differ, and how far.",
    (
        "exidyn compare sim.mcap real.mcap",
        "exidyn compare mujoco.csv real.mcap --robot robot.toml --json compared.json",
    ),
    (
        Option("simulated SIM", "recording of any simulator (.mcap, .csv), or another run", Path),
        Option("recorded REAL", "recording of the real arm", Path),
        robot_option("for tables, which do not name their robot"),
        Option("--offset S", "to add to the time of SIM; default: where the positions agree best", number),
        Option("--fit FIT", "fit.json whose filters and noise level are taken", Path),
        JSON,
    ),
)
def compare_command(given: Namespace) -> None:
    """Compare, print, write."""
    require_json(given.json)
    model = read_model(given.robot) if given.robot else None
    simulated, recorded = (_one(path, model) for path in (given.simulated, given.recorded))
    if simulated.name == recorded.name:
        simulated = replace(simulated, name=str(given.simulated))
    found = _compared(simulated, recorded, given.offset, read_fit(given.fit) if given.fit else None)
    go_on = _go_on(given, simulated, recorded)
    page = [compared_text(found)]
    if differs(found):
        page += ["which physics that is:", *(f"  {line}" for line in go_on)]
    hand_over("\n".join(page), json_text(comparison_table(found, go_on)), given.json)


def _compared(simulated: Recording, recorded: Recording, offset: float | None, fit: Fit | None) -> Comparison:
    """Both on one clock."""
    if offset is not None:
        return compare(simulated, recorded, offset, fit)
    alignment, again = nearest(simulated, recorded)
    found = compare(simulated, recorded, alignment.offset, fit)
    if not again:
        return found
    warning = (
        f"both agree as well {again:.2f} s further, since the motion repeats itself; "
        "state how far apart the clocks are with --offset"
    )
    return replace(found, warnings=(*found.warnings, warning))


def _one(path: Path, model: Model | None) -> Recording:
    """The one recording at a path."""
    recordings = import_source(path, model)
    if len(recordings) != 1:
        names = ", ".join(recording.name for recording in recordings)
        raise RecordingError(
            f"{path} holds {len(recordings)} recordings: {names or 'none'}; bring the one that is meant into "
            "a file of its own with exidyn import"
        )
    return recordings[0]


def _go_on(given: Namespace, simulated: Recording, recorded: Recording) -> list[str]:
    """Commands that diagnose the model of the simulation by the recording."""
    real = shlex.quote(str(given.recorded))
    if given.robot:
        return [f"exidyn diagnose {shlex.quote(given.robot)} {real}"]
    if model_text(simulated.model) == model_text(recorded.model):
        return [f"exidyn diagnose {real}"]
    model = shlex.quote(str(given.simulated.with_name(f"{given.simulated.stem}-model.toml")))
    return [
        f"exidyn export {shlex.quote(str(given.simulated))} --to toml -o {model}",
        f"exidyn diagnose {model} {real}",
    ]
