"""Real recordings with models that users have: how far simulation is off, with both answers.

Errors are those of the tool point 0.1, 0.5 and 2 s after starts in the recorded states, with the original
file, with the file as answered, and with effects attached to it.
"""

import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from common import Kept, show

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.in_mujoco.distances import Distances
from exidyn.identification.in_mujoco.gap import gap
from exidyn.identification.in_mujoco.replay import Run
from exidyn.identification.in_mujoco.trial import Source, Trial
from exidyn.identification.model import Model
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model
from parts.real.data import piece

from .answers import said
from .recorded_arms import ARMS, GO2_LAW, SERVOS, XL330, Recorded, with_servos

ANSWERS = ("original", "file", "attached")


def figures(folder: Path, quick: bool, kept: Kept) -> dict[str, Any]:
    """Errors of every arm with every answer; the quick run has two pendulums."""
    chosen = (SERVOS[0], XL330) if quick else (*SERVOS, *ARMS)
    by_arm = {
        arm.name: kept.of(f"recorded, {arm.name}", lambda arm=arm: answered(arm, folder)) for arm in chosen
    }
    _show(by_arm)
    judged = [arm for arm in by_arm.values() if "refused" not in arm]
    return {
        "recorded_refused": len(by_arm) - len(judged),
        "recorded_joints": sum(arm["joints"] for arm in judged),
        **{f"recorded_worse_{key}": sum(arm[f"worse_{key}"] for arm in judged) for key in ANSWERS[1:]},
        **{f"recorded_left_{key}": _median([arm[f"left_{key}"] for arm in judged]) for key in ANSWERS[1:]},
        "recorded": by_arm,
    }


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else np.nan


def _show(by_arm: dict[str, Any]) -> None:
    head = ["arm", *(f"{when} {answer}" for when in ("0.1 s", "0.5 s", "2 s") for answer in ANSWERS)]
    rows = []
    for name, arm in by_arm.items():
        errors = np.full((3, 3), np.nan)
        if "refused" in arm:
            print(f"  {name} was refused: {arm['refused']}")
        else:
            errors[:] = 1e3 * np.array([arm[f"tool_{answer}"] for answer in ANSWERS]).T
        rows.append([name, *errors.ravel()])
    show("Real recordings: tool point [mm]", head, rows)


def answered(arm: Recorded, folder: Path) -> dict[str, Any]:
    """Errors of joints and tool point with every answer; the message of an arm that is refused."""
    began = time.process_time()
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "arm.xml"
        path.write_text(_text(arm, folder))
        try:
            errors = _errors(arm, folder / arm.folder, path)
            figures = _compared(errors)
        except Exception as error:
            figures = {"refused": f"{type(error).__name__}: {error}"}
    return figures | {"cpu_seconds": time.process_time() - began}


def _text(arm: Recorded, folder: Path) -> str:
    """Text of the file; legs, which have motors, follow positions by the law of their controller."""
    text = arm.text or (folder / arm.mjcf).read_text()
    return with_servos(text, *GO2_LAW) if "<motor" in text else text


def _errors(arm: Recorded, folder: Path, path: Path) -> tuple[list[Distances], np.ndarray]:
    """Distances with every answer, and the noise of encoders, shape (n,) [rad]."""
    model = read_model(path, arm.joints or None)
    if arm.gain:
        model = replace(model, robot=replace(model.robot, drive_gain=np.array(arm.gain)))
    roles = (("identify", arm.fitted), (HELD_OUT, arm.held_out))
    recordings = [(role, _run(arm, folder, name, model)) for role, names in roles for name in names]
    source = Source(path.read_bytes(), str(path.parent), path.name)
    answer = said(gap(source, model, recordings, arm.commands), path.read_text())
    runs = [Run.of(_run(arm, folder, name, model), Filtering()) for name in arm.judges or arm.held_out]
    simulations = ((source.text, model, False), (answer.file, answer.arm, False))
    simulations += ((answer.attached, answer.arm, answer.attaches),)
    trial = Trial(source, model, runs, answer.commands, answer.held)
    errors = [trial.distances(text, of, attach) for text, of, attach in simulations]
    return errors, np.max([run.noise for run in runs], axis=0)


def _compared(errors: tuple[list[Distances], np.ndarray]) -> dict[str, Any]:
    """Figures of three distances; a joint is worse if its error has grown by more than encoder noise."""
    (original, *answers), noise = errors
    rows, every = original.telling, np.arange(len(noise))
    before = original.joints[rows, every]
    figures = {"joints": len(noise), "tool_original": original.tool, "joints_original": original.joints}
    for key, answer in zip(ANSWERS[1:], answers, strict=True):
        after = answer.joints[rows, every]
        figures |= {
            f"tool_{key}": answer.tool, f"joints_{key}": answer.joints,
            f"worse_{key}": int(np.sum(after > before + noise)),
            f"left_{key}": float(np.median(after / before)),
        }  # fmt: skip
    return figures


def _run(arm: Recorded, folder: Path, name: str, model: Model) -> Recording:
    """A run of a log, or a part of it."""
    stem, _, part = name.partition("[")
    (run,) = import_source(folder / f"{stem}.csv.gz", model, **arm.columns)
    if not part:
        return replace(run, name=name)
    first, stop = map(int, part.rstrip("]").split(":"))
    return piece(run, first, stop, 3, name)
