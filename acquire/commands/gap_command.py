"""exidyn gap: a MuJoCo model and recordings in; where both part, what it is, and a better model, out."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.errors import RobotError
from exidyn.identification.fit.fit_file import write_fit
from exidyn.identification.in_mujoco.distances import Distances
from exidyn.identification.in_mujoco.gap import Gap, gap
from exidyn.identification.in_mujoco.ladder import Source, Stage
from exidyn.identification.in_mujoco.replay import POSITION, TORQUE
from exidyn.identification.model import Model
from exidyn.identification.pages.gap_document import gap_html, gap_text, verdict
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.progress import StageText
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model

from ..arguments.command import Command, Option
from ..arguments.options import (
    AS_RECORDED,
    JSON,
    VALIDATE,
    filters,
    make_folder,
    output_option,
    require_file,
    require_json,
)
from ..files.given_runs import LOADED, PAYLOADS, ROLE, carrying, distinct_bodies, renamed
from ..terminal.json_output import hand_over, json_text, print_written, write_whole
from ..terminal.stopwatch import Stopwatch

DRIVES = ("drive_gain", "drive_gain_tolerance", "gear_ratio", "servo")
"""What the recordings' robot says of its drives and no MJCF does."""
STAGES = {"read": 0.02, "filter": 0.03, "form": 0.1, "search": 0.3, "weigh": 0.05, "simulate": 0.5}
"""Stages and their shares of the time."""


@Command(
    "Simulate in MuJoCo what was commanded to the real arm: where both part, which physics\n"
    "that is, and what each finding gains on a run held out. Writes a better MJCF.",
    (
        "exidyn gap arm.xml run.mcap --validate other.mcap",
        "exidyn gap arm.xml run.mcap --payload loaded.mcap --mass 0.2 --validate other.mcap",
        "exidyn gap arm.xml one.mcap two.mcap --validate other.mcap --commands torque --json gap.json",
    ),
    (
        Option("arm ARM.xml", "MJCF of the simulation", Path),
        Option("runs RUN...", "runs that are fitted (.mcap, .csv)", Path),
        VALIDATE,
        *PAYLOADS,
        Option(
            "--commands KIND",
            "position, followed by the file's servos, or torque as it was measured; default: position where "
            "the runs and the file have that",
            (POSITION, TORQUE),
        ),
        *filters(),
        output_option("FOLDER", Path("exidyn-gap")),
        Option("--view", "show the arms as recorded and as simulated, before and after, in Rerun's viewer"),
        Option("--save --rerun FILE", "save that view as a file (.rrd)", Path),
        JSON,
        AS_RECORDED,
    ),
    """A finding for which one of its joints is worse on the runs held out is not written,
nor one for which any joint is worse than by the file as it was. Runs imported with
--effort command have the torque of the file's position servos.""",
)
def gap_command(given: Namespace) -> None:
    """Simulate, diagnose, write, print."""
    require_json(given.json)
    make_folder(given.output)
    if given.save:
        require_file(given.save, "--save", [given.arm, *given.runs, *given.validate])
    source = _source(given.arm)
    with Stopwatch(STAGES) as progress:
        progress(StageText("read", "read the recordings"))
        model, runs = _read(given)
        filtering = Filtering(None, given.position_cutoff, given.torque_cutoff, given.standstill)
        found = gap(source, model, runs, given.commands or "", filtering, progress, given.as_recorded)
    written = _write(found, given)
    said = str(written[0]) if found.kept else ""
    table = _table(found, said)
    (given.output / "report.html").write_text(gap_html(found, said), encoding="utf-8")
    hand_over(gap_text(found, said), json_text(table), given.json)
    print_written(*written, given.output / "report.html", *_show(found, model, given))


def _show(found: Gap, model: Model, given: Namespace) -> list[Path]:
    """Open or save the view; Rerun takes a second to import, so only then."""
    if not (given.view or given.save):
        return []
    from ..views.gap_view import gap_view
    from ..views.live_view import Targets
    from ..views.viewers import show

    show(gap_view(found, model), Targets(view=given.view, save=given.save))
    return [given.save] if given.save else []


def _source(path: Path) -> Source:
    try:
        return Source(path.read_bytes(), str(path.resolve().parent), str(path))
    except OSError as error:
        raise RobotError(f"{path} cannot be read: {error.strerror}") from error


def _read(given: Namespace) -> tuple[Model, list[tuple[str, Recording]]]:
    """What the file describes of the joints that were recorded, and all runs with their roles."""
    whole = read_model(given.arm)
    roles = [
        (role, path) for role, paths in ((ROLE, given.runs), (HELD_OUT, given.validate)) for path in paths
    ]
    found = [(role, run) for role, path in roles for run in import_source(path, whole)]
    found += [(LOADED, carrying(run, one)) for one in given.payload for run in import_source(one.path, whole)]
    named = distinct_bodies(renamed(run for _, run in found))
    runs = list(zip((role for role, _ in found), named, strict=True))
    robot = runs[0][1].robot
    model = whole if robot.joints == whole.robot.joints else read_model(given.arm, robot.joints)
    drives = {name: getattr(robot, name) for name in DRIVES}
    return replace(model, robot=replace(model.robot, **drives)), runs


def _write(found: Gap, given: Namespace) -> list[Path]:
    """The file with what was found, and the fit behind it."""
    if found.kept is None:
        return []
    path = given.output / f"{given.arm.stem}-identified.xml"
    write_whole(path, found.kept.text)
    write_fit(found.kept.fit, given.output / "fit.json")
    return [path, given.output / "fit.json"]


def _table(found: Gap, written: str) -> dict[str, Any]:
    return {
        "exidyn_gap": 1,
        "robot": found.diagnosis.name,
        "joints": list(found.diagnosis.joints),
        "commands": found.commands,
        "horizons": list(found.horizons),
        "validate": [run.name for run in found.runs],
        "starts": len(found.before.ends),
        "before": _distances(found.before),
        "after": _distances(found.after),
        "stages": [_stage(stage) for stage in found.stages],
        "taken_out": list(found.taken_out),
        "beyond": list(found.beyond),
        "changes": [change._asdict() for change in found.kept.changes] if found.kept else [],
        "left_out": list(found.kept.left) if found.kept else [],
        "verdict": verdict(found, written),
        "written": written,
    }


def _stage(stage: Stage) -> dict[str, Any]:
    return {
        "name": stage.name,
        "written": not stage.reason,
        "reason": stage.reason,
        "worse": [joint + 1 for joint in stage.worse],
        "nearer": [joint + 1 for joint in stage.nearer],
        **({} if stage.distances is None else _distances(stage.distances)),
    }


def _distances(found: Distances) -> dict[str, Any]:
    """Root mean squares [rad, m], null where a simulation has diverged."""
    return {
        "position": [_finite(row) for row in found.joints],
        "tool": _finite(found.tool),
        "whole": _finite(found.whole),
        "whole_tool": _finite([found.whole_tool])[0],
    }


def _finite(values: Sequence[float] | np.ndarray) -> list[float | None]:
    return [float(value) if np.isfinite(value) else None for value in values]
