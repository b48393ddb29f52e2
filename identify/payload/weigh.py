"""`weigh`: from runs to the payload on the flange."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import FitError, NotExcited, RecordingError
from ..fit.base_parameters import BaseParameters
from ..fit.fit import Fit
from ..fit.identification import common_filtering, of_these_joints, of_this_arm, pooled_noise, same_robot
from ..fit.settled_gains import settled
from ..model import Model
from ..plausible.gate import doubts
from ..positive_definite import factored, solve
from ..preparation.prepare import Filtering, Prepared, prepare
from ..progress import StageText
from ..recordings.effort_checks import check_alive
from ..recordings.recording import KnownPayload, Recording
from ..recordings.recording_checks import check
from .body import MASS, Body, consistent_body, intervals
from .estimate import Posterior, posterior
from .known import BARE, Known, complete, known_from_description, known_from_fit
from .payload_estimate import DESCRIPTION, DIFFERENCE, FIT, PayloadEstimate
from .pose_check import Check, check_poses
from .rows import TOOL, Rows, arm_base, rows_of, with_columns, with_tool

Progress = Callable[[str], None]
PASSES = 5
"""Largest number of times that the equations are formed: from the second on, gears carry the payload too."""
SETTLED = 0.02
"""Relative change of the mass after which they are not formed again: friction under load is a tenth of it."""


def weigh(
    runs: Sequence[Recording],
    *,
    fit: Fit | None = None,
    empty: Sequence[Recording] = (),
    model: Model | None = None,
    com: Sequence[float] | None = None,
    filtering: Filtering = Filtering(),  # noqa: B008
    as_recorded: bool = False,
    progress: Progress = lambda _: None,
) -> PayloadEstimate:
    """Identify the payload on the flange; see `exidyn.payload`.

    Raises:
        RecordingError: There is no run, or one is invalid.
        DifferentRobot: The runs, the fit and the description are of different arms.
        FitError: Drive gains are unknown.
        NotExcited: The motion shows no payload.
    """
    if not runs:
        raise RecordingError("no run with the payload; give at least one")
    if fit is not None:
        fit = fit.undropped  # the run with the payload may show what those of the fit did not
        if filtering.torque_cutoff is None:  # beyond the filters of the fit, nothing is known of the arm
            filtering = replace(filtering, torque_cutoff=fit.filtering.torque_cutoff)
    recordings = [check_alive(check(run)) for run in (*empty, *runs)]
    arm = _arm(recordings, fit, model)
    tooled = with_tool(arm)
    recordings = [
        replace(run, model=tooled, payload=None if k < len(empty) else KnownPayload(TOOL))
        for k, run in enumerate(recordings)
    ]
    with threadpool_limits(limits=1):  # see `identify`
        warnings: list[str] = []
        if not as_recorded:
            progress(
                StageText("units", "compare units, signs and order of joints with the robot description")
            )
            warnings += doubts(recordings, tooled)
        progress(StageText("filter", "filter and differentiate"))
        filtering = common_filtering(recordings, filtering)
        prepared = pooled_noise([prepare(run, filtering) for run in recordings])
        _require_gains(arm, prepared)
        base = with_columns(arm_base(tooled) if fit is None else fit.structure or fit.base, tooled)
        progress(StageText("estimate", "estimate the payload"))
        rows, result, known = _estimated(tooled, base, prepared, fit, com)
        progress(StageText("check", "predict two poses that were left out"))
        position = [run.motion.position[run.decimation.centres(len(run.motion))] for run in prepared]
        checked = check_poses(rows, known, np.concatenate(position), result)
        return _result(arm, result, checked, runs, empty, fit, warnings, recordings)


def _arm(recordings: Sequence[Recording], fit: Fit | None, model: Model | None) -> Model:
    """Model of the arm; that of a fit has the fit's gains."""
    if fit is None:
        described = of_these_joints(model, recordings) if model else same_robot(recordings)
        if described.robot.inertias_stated:
            return described
        return replace(described, robot=replace(described.robot, inertial_tolerance=BARE))
    if model is not None:
        raise RecordingError("the arm is given twice, as a fit and as a description; leave one out")
    arm = of_this_arm(fit, recordings)
    if fit.measures != "current":
        return arm
    return replace(arm, robot=replace(arm.robot, drive_gain=settled(fit).gain))


def _require_gains(arm: Model, prepared: Sequence[Prepared]) -> None:
    """Refuse currents without drive gains, of which no mass follows."""
    if prepared[0].measures == "current" and np.all(arm.robot.drive_gain == 1.0):
        raise FitError(
            f"{arm.robot.name}: currents were recorded and no drive gains are known, so no mass follows from "
            "them. For a rough mass, let exidyn init propose gains by the described masses, from a log "
            "without the payload; for an exact one, state [drive] gain in robot.toml (torque constant of the "
            "motor [N m/A] times gear ratio), or give a fit with gains (exidyn identify --payload)"
        )


def _estimated(
    model: Model,
    base: BaseParameters,
    prepared: Sequence[Prepared],
    fit: Fit | None,
    com: Sequence[float] | None,
) -> tuple[Rows, Posterior, Known]:
    """Equations, estimate and prior, with gear loads that include the payload."""
    described, mass = None, 1.0  # a guess of the mass for the first pass
    center = None if com is None else np.asarray(com, float)
    for number in range(PASSES):
        rows = rows_of(model, base, prepared)
        if fit is not None:
            arm = known_from_fit(fit, rows)
        elif described is None:  # later, nominal values are those of the last pass
            arm = described = known_from_description(model, rows)
        known = complete(rows, *arm, center, mass, scaled=fit is None)
        try:
            result = posterior(rows, known)
        except np.linalg.LinAlgError as error:
            raise NotExcited("the motion does not show the payload; move all joints, farther") from error
        before, mass = mass, abs(float(result.payload[MASS]))
        if number > 0 and abs(mass - before) < SETTLED * mass:
            break
        model = base.applied_to(model, result.values[: rows.payload.stop])
    return rows, result, known


def _result(
    arm: Model,
    result: Posterior,
    checked: Check,
    runs: Sequence[Recording],
    empty: Sequence[Recording],
    fit: Fit | None,
    warnings: Sequence[str],
    recordings: Sequence[Recording],
) -> PayloadEstimate:
    estimate, columns = result.payload, result.rows.payload
    covariance = result.covariance[columns, columns]
    parameters = consistent_body(estimate, covariance)
    body = Body.of(parameters)
    moved = parameters - estimate
    distance = float(np.sqrt(max(moved @ solve(factored(covariance), moved), 0.0)))
    n = arm.robot.dof
    std = np.sqrt(np.maximum(np.diag(result.covariance)[-n:], 0.0))
    return PayloadEstimate(
        robot=arm.robot.name,
        frame=arm.robot.flange_name,
        joints=arm.robot.joints,
        body=body,
        intervals=intervals(estimate, covariance, body),
        certain=intervals(estimate, result.certain, body),
        estimate=estimate,
        covariance=covariance,
        source=FIT if fit else DIFFERENCE if empty else DESCRIPTION,
        nominal_gains=bool(np.any(std)) and (fit is None or not np.any(fit.estimate.gain_estimated)),
        runs=tuple(run.name for run in runs),
        empty=tuple(run.name for run in empty),
        seconds=float(sum(run.duration for run in runs)),
        noise=result.noise,
        gain_error=np.exp(-result.values[-n:]) - 1.0,
        gain_std=std,
        check=checked,
        distance=distance,
        warnings=tuple(dict.fromkeys([*warnings, *(w for run in recordings for w in run.warnings)])),
    )
