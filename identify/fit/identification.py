"""`identify`: from recordings to a fit in one call."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from ..effects import Payload
from ..errors import DifferentRobot, NotExcited, RecordingError
from ..model import Model
from ..plausible.gains import gains_by_masses, masses_sentence
from ..plausible.gate import doubts
from ..preparation.prepare import (
    ABOVE,
    REST,
    SMOOTHED,
    SMOOTHED_REST,
    Filtering,
    Prepared,
    choose,
    prepare,
    recorded_up_to,
    torque_off_warnings,
)
from ..progress import StageText
from ..recordings.effort_checks import check_alive
from ..recordings.recording import Recording
from ..recordings.recording_checks import check
from .agreement import agreement
from .base_parameters import BaseParameters, base_parameters
from .edit_test import edits
from .equations import Equations, assemble
from .estimators import Estimate, Estimator, maximum_likelihood, weighted
from .fit import Fit
from .fit_warnings import excitation_warnings, fit_warnings, repeated_motions, repeated_runs, unclear
from .gear_friction_bias import gear_friction_bias
from .identified import exported
from .repeatability import repeatability
from .settled_gains import as_uncertain, unsupported
from .shapes import fit_shapes

Progress = Callable[[str], None]
BEST = (REST, ABOVE, SMOOTHED_REST, SMOOTHED)
"""Sources of a noise floor, the most reliable first."""

TOO_POOR = (
    "the motion is too poor for this estimator: its equations are singular. "
    "Move all joints, farther and faster"
)


# The systems are small, so threads of linear algebra mostly wait for one another: on two loaded cores, a fit
# of 20 s of seven joints took ten times as long with two threads as with one.
@threadpool_limits.wrap(limits=1)
def identify(
    runs: Sequence[Recording],
    validate: Sequence[Recording] = (),
    *,
    model: Model | None = None,
    estimator: Estimator | None = None,
    filtering: Filtering = Filtering(),  # noqa: B008
    drop: bool = True,
    fitted_shapes: Sequence[str] = (),
    as_recorded: bool = False,
    repeat: bool = False,
    progress: Progress = lambda _: None,
) -> Fit:
    """Identify base parameters, and drive gains if a payload is known.

    Args:
        runs: Recordings of one arm; those with a payload name it.
        validate: Held-out recordings, which are only predicted.
        model: Model to fit; by default the model in the first recording, plus its payloads.
        estimator: One of `estimators.ESTIMATORS`; by default maximum likelihood if currents and a known
            payload were recorded, else weighted least squares.
        filtering: Filters; settings that are not given are chosen from the data.
        drop: Whether to leave out base parameters that the data do not support.
        fitted_shapes: Keys in `EFFECTS` of effects whose shapes are fitted to the runs first.
        as_recorded: Whether to use columns, units and signs as they are stated, without a check.
        repeat: Whether to compare the parameters of runs, or of parts of few runs, with each other.
        progress: Function that is called with a sentence at each stage.

    Raises:
        DifferentRobot: The runs are from different arms, or from another arm than that of the model.
        RecordingError: A run is invalid or inconsistent.
        NotExcited: The motions are too poor to identify the model.
    """
    if not runs:
        raise RecordingError(
            "no recording to identify from; give at least one in addition to those for validation"
        )
    recordings = [check_alive(check(run)) for run in (*runs, *validate)]
    model = with_payloads(of_these_joints(model, recordings) if model else same_robot(recordings), recordings)
    recordings = [replace(run, model=model) for run in recordings]
    suspected: list[str] = []
    if not as_recorded:
        progress(StageText("units", "compare units, signs and order of joints with the robot description"))
        suspected = doubts(recordings, model)
        for doubt in suspected:
            progress(f"warning: {doubt}")
    progress(StageText("filter", "filter and differentiate"))
    filtering = common_filtering(recordings[: len(runs)], filtering)
    prepared = pooled_noise([prepare(run, filtering) for run in recordings])
    used, held_out = prepared[: len(runs)], prepared[len(runs) :]
    if fitted_shapes:
        progress(StageText("shapes", "fit the shapes of " + ", ".join(fitted_shapes)))
        model = fit_shapes(model, used, fitted_shapes, progress=progress)
    progress(StageText("base", "find base parameters"))
    base = base_parameters(model, sorted({run.motion.payload for run in used}))
    progress(StageText("form", f"compute and decimate the regressor of {len(base.kept)} base parameters"))
    equations = assemble(model, base, used)
    progress(StageText("estimate", "estimate"))
    if estimator is None:  # drive gains can be identified from currents if some torque is known
        gains = not equations.gain_known and bool(np.any(equations.known))
        estimator = maximum_likelihood if gains else weighted
    fit = _fit(model, equations, solvable(estimator), used, drop, filtering)
    progress(StageText("compare", "compare with the runs"))
    if repeat:
        by_column = dict(zip(fit.base.kept, fit.estimate.values, strict=True))
        values = np.array([by_column.get(column, 0.0) for column in base.kept])
        compared = repeatability(model, equations, fit.estimate.gain, values, used, recordings[: len(runs)])
        fit = replace(fit, repeatability=compared)
    drives = gains_by_masses(recordings, model) if fit.unscaled else []
    warnings = (
        *fit_warnings(fit, equations),
        *([masses_sentence(drives, model.robot)] if drives else []),
        *(f"{run.name}: {warning}" for run in recordings for warning in run.warnings),
        *excitation_warnings(model.robot.joints, used, fit.condition),
        *_payload_warnings(model, used, held_out),
        *torque_off_warnings(model.robot.joints, prepared),
        *(repeated_runs(runs, validate) or repeated_motions(used, held_out)),
    )
    fit = replace(
        fit,
        warnings=warnings,
        suspicions=tuple(suspected),
        simulations=tuple(run.name for run in runs if run.simulated),
        carried={run.name: run.payload.name for run in runs if run.payload},
        validation=tuple(fit.agree(run) for run in held_out),
        edits=edits({run.name: run.motion.payload for run in held_out}, {run.motion.payload for run in used}),
        exported=exported(fit),
    )
    return _judged_by_residual(fit) if fit.noise_source == SMOOTHED else fit


def _judged_by_residual(fit: Fit) -> Fit:
    """Fit with its own residual as the noise floor, since smoothed runs without a rest show no other."""
    level = np.sqrt(np.mean([run.residual_rms**2 for run in fit.agreement], axis=0))
    agreement, validation = (
        tuple(replace(run, noise=level) for run in runs) for runs in (fit.agreement, fit.validation)
    )
    noise = level / (np.abs(fit.estimate.gain) if fit.measures == "current" else 1.0)
    return replace(fit, agreement=agreement, validation=validation, noise=noise)


def _payload_warnings(model: Model, used: Sequence[Prepared], held_out: Sequence[Prepared]) -> list[str]:
    """Warnings about held-out runs with a payload that is partly unknown and in no run of the fit."""
    open_bodies = {name for name, body in model.payloads.items() if body.parameters(model.robot)}
    strange = open_bodies - {run.motion.payload for run in used}
    return [
        f"{run.name}: carries '{run.motion.payload}', which no run used for the fit carries; its unknown "
        "parameters count as zero in the prediction"
        for run in held_out
        if run.motion.payload in strange
    ]


def solvable(estimator: Estimator) -> Estimator:
    """Estimator that raises `NotExcited` if its equations are singular."""

    def checked(equations: Equations) -> Estimate:
        try:
            with np.errstate(divide="ignore", invalid="ignore"):
                estimate = estimator(equations)
            broken = not np.all(np.isfinite(estimate.values)) or not np.all(estimate.gain)
        except np.linalg.LinAlgError as error:
            raise NotExcited(TOO_POOR) from error
        if broken:
            raise NotExcited(TOO_POOR)
        return estimate

    return checked


def same_robot(runs: Sequence[Recording]) -> Model:
    """Model of the first run, after a check that all runs are from the same robot.

    Raises:
        DifferentRobot: The runs are from different robots.
    """
    first = runs[0]
    for run in runs[1:]:
        if run.robot.joints != first.robot.joints or run.robot.kinematics != first.robot.kinematics:
            raise DifferentRobot(
                f"{first.name} was recorded on {first.robot.name} ({', '.join(first.robot.joints)}) and "
                f"{run.name} on {run.robot.name} ({', '.join(run.robot.joints)}) or with other geometry; "
                "identify them separately, or give one robot for all with --robot"
            )
    return first.model


def of_these_joints(model: Model, runs: Sequence[Recording]) -> Model:
    """The model, after a check that its joints have the names in every run; geometry and gains may differ.

    Raises:
        DifferentRobot: The joints of a run have other names.
    """
    for run in runs:
        if run.robot.joints != model.robot.joints:
            raise DifferentRobot(
                f"{run.name} was recorded on {run.robot.name} (joints {', '.join(run.robot.joints)}), but "
                f"the robot given is {model.robot.name} (joints {', '.join(model.robot.joints)}); give that "
                "of the recording, or give its joints the recording's names in the same order"
            )
    return model


def of_this_arm(fit: Fit, runs: Sequence[Recording]) -> Model:
    """The model of a fit, after a check that no run is of an arm with another name and other geometry.

    Raises:
        DifferentRobot: A run is of another arm.
    """
    robot = fit.model.robot
    of_these_joints(fit.model, runs)
    for run in runs:
        if robot.differs_from(run.robot):
            raise DifferentRobot(
                f"{run.name} was recorded on {run.robot.name}, and the fit is of {robot.name}, an arm with "
                f"other geometry; use a fit of {run.robot.name} (exidyn identify)"
            )
    return fit.model


def with_payloads(model: Model, runs: Sequence[Recording]) -> Model:
    """Model extended by each payload that a run carries."""
    carried = {run.payload.name: run.payload for run in runs if run.payload}
    for name in sorted(set(carried) - set(model.payloads)):
        model = model + Payload(name, carried[name].known)
    return model


def common_filtering(runs: Sequence[Recording], filtering: Filtering) -> Filtering:
    """Common filters of all runs: the widest band that any run needs, limited to what all recorded."""
    filters = [choose(run, filtering) for run in runs]
    torque_cutoff = max(chosen.torque_cutoff or 0.0 for chosen in filters)
    if filtering.torque_cutoff is None:
        torque_cutoff = min(torque_cutoff, *map(recorded_up_to, runs, filters))
    return replace(
        filtering,
        rate=float(np.median([chosen.rate for chosen in filters])),
        position_cutoff=max(chosen.position_cutoff or 0.0 for chosen in filters),
        torque_cutoff=torque_cutoff,
    )


def pooled_noise(runs: Sequence[Prepared]) -> list[Prepared]:
    """Runs with a common noise floor, since a rest of half a second gives it only to some thirty percent."""
    source = next(source for source in BEST for run in runs if run.noise_source == source)
    noise = np.sqrt(np.mean([run.noise**2 for run in runs if run.noise_source == source], axis=0))
    return [replace(run, noise=noise, noise_source=source) for run in runs]


def _fit(
    model: Model,
    equations: Equations,
    estimator: Estimator,
    used: Sequence[Prepared],
    drop: bool,
    filtering: Filtering,
) -> Fit:
    """Estimate, drop parameters that the data do not support, and estimate again."""
    full_estimate, all_equations = estimator(equations), equations
    estimate, structure, dropped = full_estimate, equations.base, {}
    if drop and (weak := unsupported(full_estimate, priors_away_from_zero(structure, model))):
        dropped = {structure.names[k]: float(full_estimate.values[k]) for k in weak}
        equations = equations.without(weak)
        estimate = as_uncertain(estimator(equations), full_estimate, weak)
    base = equations.base
    agreements = tuple(
        agreement(run, estimate, equations.regressor[rows], equations.known[rows])
        for run, rows in zip(used, equations.runs, strict=True)
    )
    return Fit(
        model=model,
        base=base,
        estimate=estimate,
        runs=tuple(run.name for run in used),
        filtering=filtering,
        condition=_condition(equations, estimate),
        rows=int(equations.weight.sum()),
        prior=base.before(model),
        dropped=dropped,
        structure=structure if dropped else None,
        full_estimate=full_estimate if dropped else None,
        measures=used[0].measures,
        noise=used[0].noise,
        noise_source=used[0].noise_source,
        standstill=np.max([run.standstill for run in used], axis=0),
        unclear=unclear(model, base, estimate, used[-1].motion.payload),
        agreement=agreements,
        gear_friction_bias=gear_friction_bias(model, all_equations, full_estimate, used),
    )


def priors_away_from_zero(base: BaseParameters, model: Model) -> list[int]:
    """Indices of base parameters whose prior excludes zero with 95 % (two standard deviations)."""
    nominal, deviation = base.before(model)
    return [int(k) for k in np.flatnonzero(np.abs(nominal) > 2 * deviation)]


def _condition(equations: Equations, estimate: Estimate) -> float:
    """Condition number of the weighted regressor with columns scaled to one."""
    rows = equations.regressor * (equations.weight / estimate.noise)[:, :, None]
    gram = np.einsum("rnb,rnc->bc", rows, rows, optimize=True)
    size = np.sqrt(np.diag(gram))
    singular = np.linalg.eigvalsh(gram / np.outer(size, size))
    return float(np.sqrt(singular[-1] / max(singular[0], 1e-32 * singular[-1])))  # limit of double precision
