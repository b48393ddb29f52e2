"""Predictions of recordings by a fit that was read from a file."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from ..arm.rigid_regressor import INERTIAL
from ..effects import Payload
from ..fit.fit import Fit
from ..fit.identification import of_these_joints
from ..preparation.prepare import Prepared, prepare
from ..recordings.recording import JOG, KnownPayload, Recording
from ..recordings.recording_checks import check

SAME = 1e-6
"""Relative tolerance at which masses or moments count as equal after being written and read."""


def predicted(fit: Fit, recordings: Sequence[Recording]) -> Fit:
    """The fit with its predictions of recordings; recordings that it was not fitted to count as held out.

    Simulated recordings, jogs, and runs with an unknown payload are predicted too, but do not judge the fit.
    """
    of_these_joints(fit.model, recordings)
    named = [_with_payload_of_fit(fit, recording) for recording in recordings]
    for payload in [run.payload for run in named if run.payload]:
        # A payload that is new to the fit, but completely known, adds no unknowns.
        if payload.name not in fit.model.payloads and set(INERTIAL) <= {name for name, _ in payload.known}:
            fit = replace(fit, model=fit.model + Payload(payload.name, payload.known))
    reasons = {run.name: reason for run in named if (reason := _why_not_judging(fit, run))}
    words = tuple(
        f"{name}: {reason}; it is shown, but does not judge the fit" for name, reason in reasons.items()
    )
    shown = beside(fit, prepared(fit, named), tuple(reasons))
    return replace(shown, warnings=(*fit.warnings, *words))


def prepared(fit: Fit, recordings: Sequence[Recording]) -> list[Prepared]:
    """Recordings prepared with the filters of the fit and its noise level."""
    runs = [prepare(check(replace(recording, model=fit.model)), fit.filtering) for recording in recordings]
    return [
        run
        if (level := fit.noise_of(run.measures)) is None
        else replace(run, noise=level, noise_source=fit.noise_source)
        for run in runs
    ]


def beside(fit: Fit, runs: Sequence[Prepared], apart: Collection[str] = ()) -> Fit:
    """The fit with its predictions of prepared runs; runs named in `apart` do not judge it."""
    agreements = [fit.agree(run) for run in runs]
    judging = [agreement for agreement in agreements if agreement.run not in apart]
    return replace(
        fit,
        agreement=tuple(agreement for agreement in judging if agreement.run in fit.runs),
        validation=tuple(agreement for agreement in judging if agreement.run not in fit.runs),
        apart=tuple(agreement for agreement in agreements if agreement.run in apart),
    )


def _with_payload_of_fit(fit: Fit, recording: Recording) -> Recording:
    """The recording with its payload named as in the fit, and with the fit's values if it has none."""
    payload = recording.payload
    known_of = {name: effect.known for name, effect in fit.model.payloads.items()}
    fitted = fit.carried.get(recording.name, "")
    if fitted in known_of and (payload is None or not payload.known) and not recording.simulated:
        return replace(recording, payload=KnownPayload(fitted, known_of[fitted]))
    if payload is None:
        return recording
    values = dict(payload.known)
    name = next((name for name, known in known_of.items() if known == payload.known), payload.name)
    if name == payload.name and name in known_of:
        alike = (np.isclose(value, values.get(key, value), rtol=SAME) for key, value in known_of[name])
        name = name if all(alike) else f"another {name}"
    return replace(recording, payload=replace(payload, name=name))


def _why_not_judging(fit: Fit, recording: Recording) -> str:
    """Why a recording does not judge a fit; empty if it does."""
    if recording.simulated and not fit.simulations:
        return "simulated by a model"
    if JOG in recording.settings and recording.name not in fit.runs:
        return "a jog, in which one joint moves slowly and all others stand still"
    if recording.payload and recording.payload.name not in fit.model.payloads:
        return f"carries '{recording.payload.name}', which is unknown to the fit, and is predicted without it"
    return ""
