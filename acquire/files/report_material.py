"""Material of a joined report: fits, runs, comparisons and one diagnosis of one robot."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from exidyn.identification.diagnosis.findings.evidence import Trace
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.errors import DifferentRobot, NotAFile
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.model import Model
from exidyn.identification.notebook import counted
from exidyn.identification.pages.report_document import Fitted, Material
from exidyn.identification.pages.runs_document import Run
from exidyn.identification.pages.shown import Shown
from exidyn.identification.progress import StageText
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import EFFORT, JOG, SIMULATED, Recording
from exidyn.identification.simulation.predicted import as_nominal, predicted

from ..terminal.recording_text import payload_words
from ..terminal.stopwatch import Progress
from .given_runs import PayloadRun, carrying, renamed, role_words
from .report_files import (
    COMPARISON,
    DIAGNOSIS,
    FIT,
    KINDS,
    RECORDING,
    read_comparison,
    read_shown,
)


def read_material(
    files: Mapping[Path, str], loaded: Sequence[PayloadRun], model: Model | None, progress: Progress
) -> Material:
    """Read all files, and predict the runs with the fits.

    Args:
        files: Kind of each file.
        loaded: Recordings with a payload of the command line.
        model: The robot of tables, which do not contain their robot.
        progress: Function that takes a sentence at each stage.

    Raises:
        NotAFile: If a file is damaged, or there are two diagnoses.
        DifferentRobot: If the files are results of different arms.
    """
    progress(StageText("read", "read the files"))
    paths = {kind: [path for path, its_kind in files.items() if its_kind == kind] for kind in KINDS}
    diagnosis = _diagnosis(paths[DIAGNOSIS])
    comparisons = [(path, read_comparison(path)) for path in paths[COMPARISON]]
    read = [(path, read_fit(path)) for path in paths[FIT]]
    recordings = _recordings(paths[RECORDING], loaded, model)
    joints = _common_joints(
        [
            *((str(path), fit.model.robot.joints) for path, fit in read),
            *((str(path), diagnosis.diagnosis.joints) for path in paths[DIAGNOSIS] if diagnosis),
            *((str(path), comparison.joints) for path, comparison in comparisons),
            *((run.name, run.robot.joints) for run in recordings),
        ]
    )
    beside = {path.with_name("fit.json").resolve() for path in paths[DIAGNOSIS]}
    fits = [_fitted(*pair, recordings, progress) for pair in read if pair[0].resolve() not in beside]
    added = diagnosis is not None and bool(diagnosis.diagnosis.findings)
    improved = [
        _fitted(*pair, recordings, progress, improved=True)
        for pair in read
        if added and pair[0].resolve() in beside
    ]
    counts = {kind: len(paths[kind]) for kind in KINDS} | {RECORDING: len(recordings)}
    return Material(
        joints=joints,
        model=_nominal(diagnosis, (*fits, *improved), recordings),
        runs=_runs(recordings, diagnosis, fits),
        fits=(*fits, *improved),
        diagnosis=diagnosis,
        comparisons=tuple(comparison for _, comparison in comparisons),
        files={kind: counted(count, kind) for kind, count in counts.items() if count},
    )


def _diagnosis(paths: Sequence[Path]) -> Shown | None:
    """The diagnosis, if there is one."""
    if len(paths) > 1:
        raise NotAFile(f"{' and '.join(map(str, paths))}: give one diagnosis at a time")
    return read_shown(paths[0]) if paths else None


def _recordings(paths: Sequence[Path], loaded: Sequence[PayloadRun], model: Model | None) -> list[Recording]:
    """All recordings at the paths, with distinct names."""
    payloads = {run.path.resolve() for run in loaded}
    unloaded = [path for path in paths if path.resolve() not in payloads]
    recordings = [recording for path in unloaded for recording in import_source(path, model)]
    recordings += [carrying(recording, run) for run in loaded for recording in import_source(run.path, model)]
    return renamed(recordings)


def _fitted(
    path: Path, fit: Fit, recordings: Sequence[Recording], progress: Progress, improved: bool = False
) -> Fitted:
    """A fit's prediction of the runs, and the prediction with nominal values unless it has findings."""
    _report_stage(path, recordings, progress)
    prediction = predicted(fit, recordings)
    if improved:
        return Fitted("Fit with findings", prediction, improved=True)
    if fit.unscaled:  # nominal values are in other units
        return Fitted("Fit", prediction)
    return Fitted("Fit", prediction, predicted(as_nominal(fit), recordings))


def _report_stage(path: Path, recordings: Sequence[Recording], progress: Progress) -> None:
    if recordings:
        progress(
            StageText(
                "predict", f"predict {', '.join(recording.name for recording in recordings)} with {path}"
            )
        )


def _common_joints(named: Sequence[tuple[str, tuple[str, ...]]]) -> tuple[str, ...]:
    """The joints that all files have in common."""
    first, joints = named[0]
    for other, other_joints in named:
        if other_joints != joints:
            raise DifferentRobot(
                f"{first} has joints {', '.join(joints)}, {other} has {', '.join(other_joints)}: "
                "a report is about one arm"
            )
    return joints


def _nominal(
    diagnosis: Shown | None, fits: Sequence[Fitted], recordings: Sequence[Recording]
) -> Model | None:
    """The nominal model of the diagnosis, or else of the fits, or of the recordings."""
    models = [diagnosis.model] if diagnosis is not None and diagnosis.model is not None else []
    models += [fitted.fit.model for fitted in fits] + [recording.model for recording in recordings]
    return models[0] if models else None


def _runs(
    recordings: Sequence[Recording], diagnosis: Shown | None, fits: Sequence[Fitted]
) -> tuple[Run, ...]:
    """The recordings, and the samples that the diagnosis has of further runs."""
    runs = [_recorded(recording, fits) for recording in recordings]
    names = {run.name for run in runs}
    diagnosed = () if diagnosis is None else diagnosis.traces
    return (*runs, *(_diagnosed(trace) for trace in diagnosed if trace.name not in names))


def _recorded(recording: Recording, fits: Sequence[Fitted]) -> Run:
    quantity = next(name for name in EFFORT if name in recording.signals)
    position, effort = recording.signals["position"], recording.signals[quantity]
    role = SIMULATED if recording.simulated else recording.settings.get("role", "")
    role = JOG if JOG in recording.settings else role
    if not role and fits:
        not_judged = {run.run for run in fits[0].fit.apart}
        role = "not judged" if recording.name in not_judged else HELD_OUT
        role = "fitted" if recording.name in fits[0].fit.runs else role
    return Run(
        recording.name, role_words(role), payload_words(recording), position.rate, position.time,
        position.values, effort.time, effort.values, quantity, recording.warnings,
    )  # fmt: skip


def _diagnosed(trace: Trace) -> Run:
    rate = (len(trace.time) - 1) / float(trace.time[-1] - trace.time[0])
    return Run(
        trace.name, role_words(trace.role), "", rate, trace.time, trace.position, trace.time, trace.measured,
        "torque",
    )  # fmt: skip
