"""exidyn gap: compare a MuJoCo model with recordings, find the differing effects, and improve the model."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from exidyn.identification.diagnosis.findings.finding import Hypothesis
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.errors import RobotError
from exidyn.identification.export.mjcf_servos import with_motors
from exidyn.identification.file_names import read_failure, write_whole
from exidyn.identification.fit.fit_file import write_fit
from exidyn.identification.in_mujoco.answer import Answer
from exidyn.identification.in_mujoco.distances import Distances
from exidyn.identification.in_mujoco.gap import Gap, gap
from exidyn.identification.in_mujoco.ladder import Stage
from exidyn.identification.in_mujoco.replay import POSITION, TORQUE
from exidyn.identification.in_mujoco.trial import Source
from exidyn.identification.model import Model
from exidyn.identification.pages.gap_document import Written, gap_document, verdict
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.progress import StageText
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_text import model_text

from ..arguments import options
from ..arguments.command import Command, Option, any_number, positive
from ..files.given_runs import LOADED, PAYLOADS, ROLE, carrying, distinct_bodies, renamed
from ..files.simulated_arm import controlled, import_runs, simulated_arm
from ..terminal.stopwatch import Stopwatch
from .result import Result, later

STAGES = {
    "read": 0.02, "servos": 0.08, "filter": 0.03, "form": 0.1, "search": 0.25, "weigh": 0.05, "simulate": 0.2,
    "refine": 0.27,
}  # fmt: skip
"""Stages and their shares of the time."""


@Command(
    "Simulate the real arm's commands in MuJoCo, identify the effects that make simulation and\n"
    "recording differ, and validate each finding on held-out runs. Writes an improved MJCF.",
    (
        "exidyn gap arm.xml run.mcap --validate other.mcap",
        "exidyn gap arm.xml run.mcap --payload loaded.mcap --mass 0.2 --validate other.mcap",
        "exidyn gap legs.xml run.mcap --validate other.mcap --kp 20 --kd 0.5",
        "exidyn gap arm.xml one.mcap two.mcap --validate other.mcap --commands torque --json gap.json",
    ),
    (
        Option("arm ARM.xml", "MJCF of the simulation", Path),
        Option("runs RUN...", "runs to fit (.mcap, .csv)", Path),
        options.VALIDATE,
        *PAYLOADS,
        Option(
            "--commands KIND",
            "position, for the servos of the file, or torque as measured; default: position if both the runs "
            "and the file have it",
            (POSITION, TORQUE),
        ),
        Option(
            "--kp KP...",
            "torque per position error of a controller that drives the file's motors, one number or one per "
            "joint [N m/rad]",
            positive,
        ),
        Option("--kd KD...", "its torque against the velocity, default: 0 [N m s/rad]", any_number),
        *options.FILTERS,
        options.output_option("FOLDER", Path("exidyn-gap")),
        *options.view_options("the recorded arm and both simulations"),
        options.JSON,
        options.FULL,
        options.AS_RECORDED,
    ),
    """Two files are written: the best one by itself, for any simulator, and the one with
the findings, for exidyn.mujoco.attach. Nothing is written that moves the simulation of
the held-out runs away from them. Runs imported with --effort command have the torque
of the file's position servos.""",
)
def gap_command(args: Namespace) -> Result:
    """Simulate and diagnose, write and print the results."""
    options.make_folder(args.output)
    options.require_file(args.save, "--save", [args.arm, *args.runs, *args.validate])
    try:
        source = Source(args.arm.read_bytes(), str(args.arm.resolve().parent), str(args.arm))
    except OSError as error:
        raise RobotError(f"{args.arm} cannot be read: {read_failure(args.arm, error)}") from error
    with Stopwatch(STAGES) as progress:
        progress(StageText("read", "read the recordings"))
        model, runs = _read(args)
        original = source.text
        if args.kp:
            source = controlled(source, model.robot, args.kp, args.kd or [0.0])
        filtering = Filtering(None, args.position_cutoff, args.torque_cutoff, args.standstill)
        result = gap(source, model, runs, args.commands or "", filtering, progress, args.as_recorded)
    written = _write(result, args, original)
    document, report = gap_document(result, written), args.output / "report.html"
    return Result(document, _table(result, written), report=report, view=later("gap_view", result, model))


def _read(args: Namespace) -> tuple[Model, list[tuple[str, Recording]]]:
    """The model of the recorded joints, and all runs with their roles."""
    roles = [(role, path) for role, paths in ((ROLE, args.runs), (HELD_OUT, args.validate)) for path in paths]
    paths = [path for _, path in roles] + [loaded.path for loaded in args.payload]
    imported = import_runs(args.arm, paths)
    read = [(role, run) for (role, _), runs in zip(roles, imported, strict=False) for run in runs]
    carried = zip(args.payload, imported[len(roles) :], strict=True)
    read += [(LOADED, carrying(run, loaded)) for loaded, runs in carried for run in runs]
    named = distinct_bodies(renamed(run for _, run in read))
    runs = list(zip((role for role, _ in read), named, strict=True))
    return simulated_arm(args.arm, runs[0][1].robot), runs


def _write(result: Gap, args: Namespace, original: bytes) -> Written:
    """Write the improved MJCFs, with the motors of the original, and the fit; return their paths."""
    stem, folder = args.arm.stem, args.output
    if not result.changed:
        return Written()
    file = folder / f"{stem}-identified.xml"
    write_whole(file, _with_motors(result.file.text, original, args))
    fit = result.attached.fit
    if fit is None:
        return Written(str(file))
    attached = folder / f"{stem}-attached.xml"
    write_whole(attached, _with_motors(result.attached.text, original, args))
    write_fit(fit, folder / "fit.json")
    effects = folder / f"{stem}-effects.toml"
    write_whole(effects, model_text(result.attached.arm).encode())
    return Written(str(file), str(attached), str(effects))


def _with_motors(text: bytes, original: bytes, args: Namespace) -> bytes:
    """The text, with the motors of the original where a controller stood in for them."""
    return with_motors(text, original, str(args.arm)) if args.kp else text


def _table(result: Gap, written: Written) -> dict[str, Any]:
    return {
        "exidyn_gap": 2,
        "robot": result.diagnosis.name,
        "joints": list(result.diagnosis.joints),
        "commands": result.commands,
        "commands_held": result.held,
        "horizons": list(result.horizons),
        "validate": [run.name for run in result.runs],
        "starts": len(result.original.ends),
        "original": _distances(result.original),
        "drive_gains": result.drive_gains,
        "servos": result.servos,
        "undetermined": [joint + 1 for joint in result.undetermined],
        "file": _answer(result.file) | {"written": written.file},
        "attached": _answer(result.attached) | {"written": written.attached, "effects": written.effects},
        "findings": [
            _hypothesis(finding) | {"alternatives": [_hypothesis(other) for other in finding.alternatives]}
            for finding in result.findings
        ],
        "stages": [_stage(stage) for stage in result.stages],
        "taken_out": list(result.taken_out),
        "beyond": list(result.beyond),
        "verdict": verdict(result, written),
    }


def _answer(answer: Answer) -> dict[str, Any]:
    return {
        **_distances(answer.distances),
        "attaches": answer.attaches,
        "changes": [change._asdict() for change in answer.changes],
        "left_out": list(answer.left_out),
    }


def _hypothesis(hypothesis: Hypothesis) -> dict[str, Any]:
    """Effect, joints from 1, probability."""
    joints = [joint + 1 for joint in hypothesis.joints]
    return {"effect": hypothesis.effect, "joints": joints, "probability": hypothesis.probability}


def _stage(stage: Stage) -> dict[str, Any]:
    return {
        "name": stage.name,
        "kept": not stage.reason,
        "gain": stage.gain.value if stage.gain else None,
        "reason": stage.reason,
        **({} if stage.distances is None else _distances(stage.distances)),
    }


def _distances(distances: Distances) -> dict[str, Any]:
    """Root mean squares [rad, m], null if a simulation diverged."""
    return {
        "position": distances.joints,
        "tool": distances.tool,
        "whole": distances.whole_run,
        "whole_tool": distances.whole_tool,
    }
