"""Usable runs, and the reasons why others are excluded."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...errors import DifferentRobot, RecordingError
from ...fit.fit_warnings import excitation_warnings, repeated_motions
from ...fit.identification import common_filtering, of_these_joints
from ...model import Model
from ...preparation.prepare import Filtering, torque_off_warnings
from ...recordings.effort_checks import check_alive
from ...recordings.recording import Recording
from ...recordings.recording_checks import check
from .driven import Driven

HELD_OUT = "validate"
"""Role of held-out runs."""


def usable(
    model: Model,
    recordings: Sequence[tuple[str, Recording]],
    filtering: Filtering = Filtering(),  # noqa: B008
) -> tuple[list[Driven], list[str]]:
    """Select the runs that can be filtered and compared; return them, and warnings about all runs.

    Raises:
        DifferentRobot: If a run belongs to another robot.
        RecordingError: If no run remains to fit; the message gives the reason.
    """
    of_these_joints(model, [recording for _, recording in recordings])
    sound: list[tuple[str, Recording]] = []
    warnings: list[str] = []
    for role, recording in recordings:
        try:
            checked = check_alive(check(replace(recording, model=model)))
            common_filtering([checked], filtering)
            sound.append((role, checked))
            warnings += [f"{recording.name}: {warning}" for warning in checked.warnings]
        except DifferentRobot:
            raise
        except RecordingError as error:
            warnings.append(f"{recording.name} is left out: {str(error).removeprefix(f'{recording.name}: ')}")
    measures = ["current" if "current" in recording.signals else "torque" for _, recording in sound]
    for (_, recording), measure in zip(sound, measures, strict=True):
        if measure != measures[0]:
            warnings.append(
                f"{recording.name} is left out: it recorded {measure}, "
                f"but the first run recorded {measures[0]}"
            )
    sound = [pair for pair, measure in zip(sound, measures, strict=True) if measure == measures[0]]
    # All rows need one rate, so that the noise has one autocorrelation.
    to_fit = [recording for role, recording in sound if role != HELD_OUT]
    filtering = common_filtering(to_fit, filtering) if to_fit else filtering
    runs: list[Driven] = []
    for role, recording in sound:
        try:
            runs.append(Driven.of(model, recording, role, filtering))
        except RecordingError as error:
            warnings.append(f"{recording.name} is left out: {str(error).removeprefix(f'{recording.name}: ')}")
    if all(run.role == HELD_OUT for run in runs):
        reason = "; ".join(warnings) or "all are held out. Give at least one run that is not for validation"
        raise RecordingError(f"no run is left to fit: {reason}")
    fitted = [run.prepared for run in runs if run.role != HELD_OUT]
    warnings += torque_off_warnings(model.robot.joints, [run.prepared for run in runs])
    warnings += repeated_motions(fitted, [run.prepared for run in runs if run.role == HELD_OUT])
    return runs, [*warnings, *excitation_warnings(model.robot.joints, fitted, 0.0), *_missing(model, runs)]


def _missing(model: Model, runs: Sequence[Driven]) -> list[str]:
    """Warnings about effects that these runs cannot show, and why."""
    warnings = []
    if runs[0].prepared.measures == "current" and np.all(model.robot.drive_gain == 1.0):
        warnings.append(
            "no drive gain is known, so torques are in amperes: the runs tell kind and shape of an effect on "
            "one joint, but neither masses nor ratios of joints. Give [drive] gain, the torque constant of "
            "the motor [N m/A] times the gear ratio; exidyn init proposes it from the described masses"
        )
    if all(run.role != HELD_OUT for run in runs):
        warnings.append("no run was held out, so an improved fit proves little")
    if any(np.isnan(run.motion.temperature).any() for run in runs):
        warnings.append("temperatures were not recorded: warm friction looks like a change over time")
    if not any(run.motion.payload for run in runs):
        warnings.append("no run has a known payload: errors of gains, zeros and masses look alike")
    return warnings
