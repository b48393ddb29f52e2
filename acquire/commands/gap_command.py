"""exidyn gap: compare a MuJoCo model with recordings, find the differing effects, and improve the model."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.errors import RobotError
from exidyn.identification.file_names import read_failure
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
"""Fields of the recorded robot's drives that an MJCF does not have."""
STAGES = {"read": 0.02, "filter": 0.04, "form": 0.19, "search": 0.35, "weigh": 0.02, "simulate": 0.38}
"""Stages and their shares of the time."""


@Command(
    "Simulate the real arm's commands in MuJoCo, identify the effects that make simulation and\n"
    "recording differ, and validate each finding on held-out runs. Writes an improved MJCF.",
    (
        "exidyn gap arm.xml run.mcap --validate other.mcap",
        "exidyn gap arm.xml run.mcap --payload loaded.mcap --mass 0.2 --validate other.mcap",
        "exidyn gap arm.xml one.mcap two.mcap --validate other.mcap --commands torque --json gap.json",
    ),
    (
        Option("arm ARM.xml", "MJCF of the simulation", Path),
        Option("runs RUN...", "runs to fit (.mcap, .csv)", Path),
        VALIDATE,
        *PAYLOADS,
        Option(
            "--commands KIND",
            "position, for the servos of the file, or torque as measured; default: position if both the runs "
            "and the file have it",
            (POSITION, TORQUE),
        ),
        *filters(),
        output_option("FOLDER", Path("exidyn-gap")),
        Option("--view", "show the recorded arm and both simulations in Rerun's viewer"),
        Option("--save --rerun FILE", "save that view as a file (.rrd)", Path),
        JSON,
        AS_RECORDED,
    ),
    """A finding is not written if one of its joints is worse on the held-out runs, or
if any joint is worse than with the original file. Runs imported with
--effort command have the torque of the file's position servos.""",
)
def gap_command(args: Namespace) -> None:
    """Simulate and diagnose, write and print the results."""
    require_json(args.json)
    make_folder(args.output)
    if args.save:
        require_file(args.save, "--save", [args.arm, *args.runs, *args.validate])
    source = _source(args.arm)
    with Stopwatch(STAGES) as progress:
        progress(StageText("read", "read the recordings"))
        model, runs = _read(args)
        filtering = Filtering(None, args.position_cutoff, args.torque_cutoff, args.standstill)
        result = gap(source, model, runs, args.commands or "", filtering, progress, args.as_recorded)
    written = _write(result, args)
    improved = str(written[0]) if result.kept else ""
    table = _table(result, improved)
    (args.output / "report.html").write_text(gap_html(result, improved), encoding="utf-8")
    hand_over(gap_text(result, improved), json_text(table), args.json)
    print_written(*written, args.output / "report.html", *_show(result, model, args))


def _show(result: Gap, model: Model, args: Namespace) -> list[Path]:
    """Open or save the view, if requested: Rerun takes a second to import."""
    if not (args.view or args.save):
        return []
    from ..views.gap_view import gap_view
    from ..views.live_view import Targets
    from ..views.viewers import show

    show(gap_view(result, model), Targets(view=args.view, save=args.save))
    return [args.save] if args.save else []


def _source(path: Path) -> Source:
    try:
        return Source(path.read_bytes(), str(path.resolve().parent), str(path))
    except OSError as error:
        raise RobotError(f"{path} cannot be read: {read_failure(path, error)}") from error


def _read(args: Namespace) -> tuple[Model, list[tuple[str, Recording]]]:
    """The model of the recorded joints, and all runs with their roles."""
    full_model = read_model(args.arm)
    roles = [(role, path) for role, paths in ((ROLE, args.runs), (HELD_OUT, args.validate)) for path in paths]
    read = [(role, run) for role, path in roles for run in import_source(path, full_model)]
    read += [
        (LOADED, carrying(run, loaded))
        for loaded in args.payload
        for run in import_source(loaded.path, full_model)
    ]
    named = distinct_bodies(renamed(run for _, run in read))
    runs = list(zip((role for role, _ in read), named, strict=True))
    robot = runs[0][1].robot
    model = full_model if robot.joints == full_model.robot.joints else read_model(args.arm, robot.joints)
    drives = {name: getattr(robot, name) for name in DRIVES}
    return replace(model, robot=replace(model.robot, **drives)), runs


def _write(result: Gap, args: Namespace) -> list[Path]:
    """Write the improved MJCF and its fit; return the paths."""
    if result.kept is None:
        return []
    path = args.output / f"{args.arm.stem}-identified.xml"
    write_whole(path, result.kept.text)
    write_fit(result.kept.fit, args.output / "fit.json")
    return [path, args.output / "fit.json"]


def _table(result: Gap, written: str) -> dict[str, Any]:
    return {
        "exidyn_gap": 1,
        "robot": result.diagnosis.name,
        "joints": list(result.diagnosis.joints),
        "commands": result.commands,
        "horizons": list(result.horizons),
        "validate": [run.name for run in result.runs],
        "starts": len(result.before.ends),
        "before": _distances(result.before),
        "after": _distances(result.after),
        "stages": [_stage(stage) for stage in result.stages],
        "taken_out": list(result.taken_out),
        "beyond": list(result.beyond),
        "changes": [change._asdict() for change in result.kept.changes] if result.kept else [],
        "left_out": list(result.kept.left) if result.kept else [],
        "verdict": verdict(result, written),
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


def _distances(distances: Distances) -> dict[str, Any]:
    """Root mean squares [rad, m], null if a simulation diverged."""
    return {
        "position": [_finite(row) for row in distances.joints],
        "tool": _finite(distances.tool),
        "whole": _finite(distances.whole),
        "whole_tool": _finite([distances.whole_tool])[0],
    }


def _finite(values: Sequence[float] | np.ndarray) -> list[float | None]:
    return [float(value) if np.isfinite(value) else None for value in values]
