"""Predicted: a fit that was read from its file, beside recordings again."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..effects import Payload
from ..fit.fit import Fit
from ..fit.identification import of_these_joints, pooled_noise
from ..preparation.prepare import Prepared, prepare
from ..recordings.recording import Recording
from ..recordings.recording_checks import check


def predicted(fit: Fit, recordings: Sequence[Recording]) -> Fit:
    """The fit with what it predicts of recordings; those that it was not made from count as held out.

    Raises:
        DifferentRobot: Of other joints.
        RecordingError: One that is too short for the fit's filters.
    """
    of_these_joints(fit.model, recordings)
    known = [_with_its_body(fit, recording) for recording in recordings]
    strange = tuple(
        f"{run.name}: carries '{run.payload.name}', of which the fit knows nothing; it is predicted without"
        for run in known
        if run.payload and run.payload.name not in _bodies(fit)
    )
    return replace(beside(fit, prepared(fit, known)), warnings=(*fit.warnings, *strange))


def prepared(fit: Fit, recordings: Sequence[Recording]) -> list[Prepared]:
    """Recordings behind the filters of the fit, with one noise floor."""
    runs = [prepare(check(replace(recording, model=fit.model)), fit.filtering) for recording in recordings]
    return pooled_noise(runs) if runs else []


def beside(fit: Fit, runs: Sequence[Prepared]) -> Fit:
    """The fit with what it predicts of prepared runs."""
    shown = [fit.agree(run) for run in runs]
    used = tuple(one for one in shown if one.run in fit.runs)
    return replace(fit, agreement=used, validation=tuple(one for one in shown if one.run not in fit.runs))


def as_nominal(fit: Fit) -> Fit:
    """The same model with the values and drive gains that were nominal before the data."""
    base, model = fit.structure or fit.base, fit.model
    values = base.regrouping @ model.nominal_values
    size = len(values) + model.robot.dof
    estimate = replace(
        fit.estimate, values=values, gain=model.robot.drive_gain, covariance=np.zeros((size, size))
    )
    return replace(fit, base=base, estimate=estimate, structure=None, dropped={})


def _with_its_body(fit: Fit, recording: Recording) -> Recording:
    """The recording, its body called as the fit calls the one of which the same is known."""
    body = recording.payload
    names = [name for name, known in _bodies(fit).items() if body and known == body.known]
    return replace(recording, payload=replace(body, name=names[0])) if body and names else recording


def _bodies(fit: Fit) -> dict[str, tuple[tuple[str, float], ...]]:
    return {effect.name: effect.known for effect in fit.model.effects if isinstance(effect, Payload)}
