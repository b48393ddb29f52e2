"""Predicted: a fit that was read from its file, beside recordings again."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from ..arm.rigid_regressor import INERTIAL
from ..effects import Payload
from ..fit.fit import Fit
from ..fit.identification import of_these_joints, pooled_noise
from ..preparation.prepare import Prepared, prepare
from ..recordings.recording import JOG, KnownPayload, Recording
from ..recordings.recording_checks import check

Known = tuple[tuple[str, float], ...]
SAME = 1e-6
"""Share up to which two masses or moments are the same: numbers that were written and read."""


def predicted(fit: Fit, recordings: Sequence[Recording]) -> Fit:
    """The fit with what it predicts of recordings; those that it was not made from count as held out.

    What a model made, a jog, and what carries a body of which the fit knows nothing, is predicted too, and
    judges nothing.

    Raises:
        DifferentRobot: Of other joints.
        RecordingError: One that is too short for the fit's filters.
    """
    of_these_joints(fit.model, recordings)
    known = [_with_its_body(fit, recording) for recording in recordings]
    for body in [run.payload for run in known if run.payload]:
        # A body that the fit lacks and of which all is known adds no unknowns.
        if body.name not in fit.model.payloads and set(INERTIAL) <= {name for name, _ in body.known}:
            fit = replace(fit, model=fit.model + Payload(body.name, body.known))
    reasons = {run.name: reason for run in known if (reason := _judges_nothing(fit, run))}
    words = tuple(
        f"{name}: {reason}; it is shown, and does not judge the fit" for name, reason in reasons.items()
    )
    shown = beside(fit, prepared(fit, known), tuple(reasons))
    return replace(shown, warnings=(*fit.warnings, *words))


def prepared(fit: Fit, recordings: Sequence[Recording]) -> list[Prepared]:
    """Recordings behind the filters of the fit, with its noise level."""
    runs = [prepare(check(replace(recording, model=fit.model)), fit.filtering) for recording in recordings]
    if fit.noise is None:
        return pooled_noise(runs) if runs else []
    return [
        run
        if (level := fit.noise_of(run.measures)) is None
        else replace(run, noise=level, noise_source=fit.noise_source)
        for run in runs
    ]


def beside(fit: Fit, runs: Sequence[Prepared], apart: Collection[str] = ()) -> Fit:
    """The fit with what it predicts of prepared runs; those `apart`, by name, do not judge it."""
    shown = [fit.agree(run) for run in runs]
    judging = [one for one in shown if one.run not in apart]
    return replace(
        fit,
        agreement=tuple(one for one in judging if one.run in fit.runs),
        validation=tuple(one for one in judging if one.run not in fit.runs),
        apart=tuple(one for one in shown if one.run in apart),
    )


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
    """The recording, its body called as the fit calls it; with that of the run used, if it brings none."""
    body = recording.payload
    bodies = {name: effect.known for name, effect in fit.model.payloads.items()}
    own = fit.carried.get(recording.name, "")
    if own in bodies and (body is None or not body.known) and not recording.simulated:
        return replace(recording, payload=KnownPayload(own, bodies[own]))
    if body is None:
        return recording
    same = [name for name, known in bodies.items() if known == body.known]
    same += [name for name, known in bodies.items() if name == body.name and _agree(known, body.known)]
    name = same[0] if same else body.name if body.name not in bodies else f"another {body.name}"
    return replace(recording, payload=replace(body, name=name))


def _agree(one: Known, other: Known) -> bool:
    """Whether what is known of two bodies may be of one."""
    values = dict(other)
    return all(np.isclose(value, values.get(name, value), rtol=SAME) for name, value in one)


def _judges_nothing(fit: Fit, recording: Recording) -> str:
    """Why a recording does not judge a fit; empty if it does."""
    if recording.simulated and not fit.simulations:
        return "simulated by a model"
    if JOG in recording.settings and recording.name not in fit.runs:
        return "a jog, in which one joint moves slowly and all others stand"
    if recording.payload and recording.payload.name not in fit.model.payloads:
        return f"carries '{recording.payload.name}', of which the fit knows nothing, and is predicted without"
    return ""
