"""Refit: the model with what was found, identified again, for everything that takes a fit."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..fit.fit import Fit
from ..fit.identification import identify
from ..model import Model
from ..preparation.prepare import Filtering
from ..recordings.recording import EFFORT, Recording, Signal
from .candidates import kind_of
from .findings.finding import Diagnosis, Finding
from .improved.improved import as_found
from .runs.usable import HELD_OUT
from .words.measures import by_kind, slides
from .words.sentences import sentence


def refit(
    diagnosis: Diagnosis,
    recordings: Sequence[tuple[str, Recording]],
    progress: Callable[[str], None] = lambda _: None,
    filtering: Filtering = Filtering(),  # noqa: B008
) -> Fit | None:
    """Identify the model again with what was found; None for a diagnosis without evidence.

    What no fit can hold is among its warnings.

    Args:
        diagnosis: With its evidence.
        recordings: Role and recording of each run.
        progress: Called with a sentence at each stage.
        filtering: Filters; chosen from the data where none is given.

    Raises:
        ExidynError: The runs cannot carry a fit.
    """
    if diagnosis.evidence is None:
        return None
    left_out = as_found(diagnosis.evidence, diagnosis.findings).left_out
    delays = [one for one in diagnosis.findings if one.effect == "time_delay"]
    used = [(role, earlier(run, delays)) for role, run in recordings if _kept(run, diagnosis)]
    fit = identify(
        [run for role, run in used if role != HELD_OUT],
        [run for role, run in used if role == HELD_OUT],
        model=model_to_fit(diagnosis),
        filtering=filtering,
        progress=progress,
    )
    warnings = [
        f"{sentence(finding, diagnosis.joints, slides(diagnosis, finding))}: {_why(finding)}"
        for place, finding in enumerate(by_kind(diagnosis).findings)
        if kind_of(finding.effect).gear or finding in delays or place in left_out
    ]
    return replace(fit, warnings=(*warnings, *fit.warnings))


def model_to_fit(diagnosis: Diagnosis) -> Model:
    """The nominal model with the effects found, and gains by what was found of them."""
    assert diagnosis.evidence is not None
    evidence = diagnosis.evidence
    arm = as_found(evidence, diagnosis.findings)
    share = arm.gain / evidence.gain_after
    return replace(arm.model, robot=replace(arm.model.robot, drive_gain=arm.model.robot.drive_gain * share))


def _kept(run: Recording, diagnosis: Diagnosis) -> bool:
    """Whether the diagnosis could ask the run."""
    assert diagnosis.evidence is not None
    return run.name in [trace.name for trace in diagnosis.evidence.traces]


def earlier(recording: Recording, delays: Sequence[Finding]) -> Recording:
    """The recording with currents, or torques, moved to where they were earlier by some delays."""
    signals = dict(recording.signals)
    for delay in delays:
        seconds = delay.parameters["delay"].value
        joints = list(delay.joints) or list(range(recording.robot.dof))
        for name in set(EFFORT) & set(signals):
            signals[name] = _moved(signals[name], joints, seconds)
    return replace(recording, signals=signals)


def _moved(signal: Signal, joints: Sequence[int], seconds: float) -> Signal:
    values = np.array(signal.values)
    for joint in joints:
        values[:, joint] = np.interp(signal.time + seconds, signal.time, signal.values[:, joint])
    return Signal(signal.time, values)


def _why(finding: Finding) -> str:
    if finding.effect == "time_delay":
        return "currents were moved back by that before they were fitted"
    if kind_of(finding.effect).gear:
        return "a fit has rigid gears, so that this is no part of it"
    return "no part of this fit, which is of the arm and not of how it was measured"
