"""Diagnose: from a nominal model and its runs to findings, what is left, and what was gained."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from ..fit.identification import pooled_noise, with_payloads
from ..model import Model
from ..plausible.gate import doubts
from ..preparation.prepare import SMOOTHED_SOURCES, Filtering
from ..progress import StageText
from ..quantity import Quantity
from ..recordings.recording import Recording
from .candidates import kind_of
from .findings.diagnosis import Diagnosis
from .findings.evidence import Evidence, Trace
from .findings.finding import Finding
from .findings.quantities import alternative, quantities, stated
from .findings.size import OF_A_CURVE
from .questions.block_answer import Answer
from .questions.shape import Shaped
from .results.budget import NOISE, budget, changes
from .results.evidence import Spread, deviations, evidence, places_of, with_shapes
from .results.located import hinted, located
from .results.motor_torque import undetermined_gains, with_all_torque
from .results.remainder import MAIN, MATERIAL, beside_unnamed, discrepancies, remainders, rms
from .results.sizes import left_out, size
from .runs.driven import Driven
from .runs.usable import usable
from .search.held_out import hints
from .search.once import moments
from .search.problem import Problem
from .search.search import SearchResult, search
from .words.measures import in_units_of_joints, torque_units

SMOOTH = (
    "The recordings were smoothed before they were recorded: the noise of the motion is not known, and what "
    "is left may be what the filter took. They are compared up to {:.3g} Hz. Record what the drive measures, "
    "without a filter."
)
UNSTATED = 100.0
"""Relative standard deviation of unstated inertias [-]: flat, and still a number."""


class Diagnosed(NamedTuple):
    """A diagnosis, and the search that it reports."""

    diagnosis: Diagnosis
    search: SearchResult


def diagnosed(
    model: Model,
    recordings: Sequence[tuple[str, Recording]],
    name: str = "",
    filtering: Filtering = Filtering(),  # noqa: B008
    progress: Callable[[str], None] = lambda _: None,
    before: Sequence[Shaped] = (),
    as_recorded: bool = False,
) -> Diagnosed:
    """Find the physics that a model leaves out, with the search that found it.

    Args:
        model: Nominal, with its tolerances; what is unstated is fitted freely.
        recordings: Role and recording of each run; those of role "validate" are only predicted.
        name: What is diagnosed; the robot's name by default.
        filtering: Filters; chosen from the data where none is given.
        progress: Called with a sentence at each stage.
        before: Shapes that an earlier diagnosis of some of these runs has found.
        as_recorded: Take columns, units and signs as they are stated, without a check.

    Raises:
        DifferentRobot: A run of another robot.
        RecordingError: No run is left to fit.
    """
    # Thousands of small systems: threads of linear algebra would wait for one another.
    with threadpool_limits(limits=1):
        return _diagnosed(model, recordings, name, filtering, progress, before, as_recorded)


def diagnose(
    model: Model,
    recordings: Sequence[tuple[str, Recording]],
    name: str = "",
    filtering: Filtering = Filtering(),  # noqa: B008
    progress: Callable[[str], None] = lambda _: None,
    as_recorded: bool = False,
) -> Diagnosis:
    """Find the physics that a model leaves out; see `diagnosed`."""
    return diagnosed(model, recordings, name, filtering, progress, as_recorded=as_recorded).diagnosis


def _diagnosed(
    model: Model,
    recordings: Sequence[tuple[str, Recording]],
    name: str,
    filtering: Filtering,
    progress: Callable[[str], None],
    before: Sequence[Shaped],
    as_recorded: bool,
) -> Diagnosed:
    began = time.monotonic()
    model = nominal(with_payloads(model, [recording for _, recording in recordings]))
    progress(StageText("filter", "filter and differentiate"))
    runs, warnings = usable(model, recordings, filtering)
    suspicions: list[str] = []
    if not as_recorded:
        used = {run.prepared.name for run in runs}
        likely = [run for _, run in recordings if run.name in used]
        suspicions = doubts(likely, model)
        for doubt in suspicions:
            progress(f"warning: {doubt}")
    progress(StageText("form", "form the columns of all candidates"))
    problem = Problem.of(model, runs, before)
    progress(StageText("search", f"search among {sum(problem.tried.values())} candidates"))
    found = with_all_torque(search(problem))
    progress(StageText("weigh", "weigh what was found"))
    left = discrepancies(found.problem, found.prediction)
    noise, rested = noise_floor(found.problem.runs)
    material = MATERIAL
    if pooled_noise([run.prepared for run in found.problem.runs])[0].noise_source in SMOOTHED_SOURCES:
        # No floor: what is left with all findings is the only level there is.
        noise = np.maximum(noise, rms(found.prediction.residual, found.prediction.rows.weight))
        rested, material = False, MAIN
        warnings = [*warnings, SMOOTH.format(found.problem.runs[0].prepared.decimation.cutoff)]
    noise = np.sqrt(found.problem.rows.row_variance(noise**2))
    found = beside_unnamed(found, left, noise)
    proof = evidence(found, noise)
    spread, named = with_shapes(found), sum(one.named for one in found.selected)
    warnings = [*warnings, *undetermined_gains(found, spread)]
    std, fitted = deviations(found, spread), proof.traces[len(found.problem.held_out) :]
    findings = [
        _sized(found, place, spread, fitted, _finding(found, place, std[place]))
        for place in range(len(found.selected))
    ]
    remaining = remainders(found.prediction, left, noise, rested, material)
    spent = budget(found.problem, found.selected, left, noise if rested else np.zeros_like(noise))
    diagnosis = Diagnosis(
        name=name or model.robot.name,
        joints=model.robot.joints,
        torque_units=torque_units(model.robot),
        findings=tuple(in_units_of_joints(finding, model.robot) for finding in findings[:named]),
        undecided=tuple(in_units_of_joints(finding, model.robot) for finding in findings[named:]),
        remainders=tuple(remaining),
        moments=tuple(moments(found.problem, found.prediction)),
        changes=tuple(changes(found.problem, found.single)),
        located=located(spent, found.selected, remaining),
        hints=hinted(hints(found.left, found.total)),
        budget=spent,
        noise=proof.noise,
        noise_measured_at_rest=any(share.kind == NOISE for share in spent.shares),
        runs=tuple(run.prepared.name for run in found.problem.fitted),
        suspicions=tuple(suspicions),
        warnings=tuple(warnings),
        seconds=time.monotonic() - began,
        tried=found.problem.tried,
        evidence=proof,
    )
    return Diagnosed(_with_held_out(diagnosis, proof, found.problem.held_out), found)


def nominal(model: Model) -> Model:
    """The model with inertias that may be anything, unless it is stated how well they are known."""
    if model.robot.inertias_stated:
        return model
    return replace(model, robot=replace(model.robot, inertial_tolerance=UNSTATED))


def noise_floor(runs: Sequence[Driven]) -> tuple[np.ndarray, bool]:
    """Noise of each joint's torque behind the filter, shape (n,) [N m], and whether it was seen at rest."""
    first = pooled_noise([run.prepared for run in runs])[0]
    return first.noise * np.abs(first.gain), first.noise_source == "rest"


def _finding(found: SearchResult, place: int, spread: tuple[np.ndarray, dict[str, float]]) -> Finding:
    selected, values = found.selected[place], found.prediction.values[places_of(found, place)]
    answer, candidate = selected.answer, selected.answer.candidate
    torque = np.zeros(found.prediction.joints)
    torque[answer.columns.joints] = np.sqrt(np.mean((answer.columns.values @ values) ** 2, axis=0))
    held_out = answer.gains[~found.problem.blocks.fitted]
    return Finding(
        **stated(candidate),
        parameters=quantities(candidate, values, *spread) | _range(answer, values),
        probability=selected.certainty,
        alternatives=tuple(alternative(other, chance) for other, chance in selected.elsewhere),
        torque_rms=torque,
        held_out=2.0 * float(held_out.sum()) if len(held_out) else float("nan"),
        alone=selected.alone,
        unnamed=selected.unnamed >= 1.0,
        family=selected.family.name if selected.family else "",
        family_probability=selected.family.probability if selected.family else float("nan"),
        proven=selected.proven,
    )


def _sized(
    found: SearchResult, place: int, spread: Spread, fitted: Sequence[Trace], finding: Finding
) -> Finding:
    """The finding with its torque, from traces of the fitted runs, and what is not determined."""
    undetermined = left_out(found, spread, place, finding.parameters)
    if not kind_of(finding.effect).formula:
        undetermined = dict.fromkeys(finding.parameters, OF_A_CURVE)
    return replace(finding, size=size(found, spread, fitted, place), left_out=undetermined)


def _range(answer: Answer, values: np.ndarray) -> dict[str, Quantity]:
    """Least and most torque of a finding, where that is what is known of it, and not its parameters."""
    determined_as = kind_of(answer.candidate.effect).determined_as
    if not determined_as:
        return {}
    torque, (_, unit) = answer.columns.values @ values, next(iter(determined_as.values()))
    ends = {"torque_least": float(np.min(torque)), "torque_most": float(np.max(torque))}
    return {name: Quantity(value, float("nan"), unit) for name, value in ends.items()}


def _with_held_out(diagnosis: Diagnosis, proof: Evidence, runs: Sequence[Driven]) -> Diagnosis:
    """The diagnosis with residuals of its held-out runs; unchanged without any."""
    if not runs:
        return diagnosis
    traces = proof.traces[: len(runs)]
    weight = np.concatenate([trace.weight for trace in traces])
    return replace(
        diagnosis,
        held_out=tuple(run.prepared.name for run in runs),
        torque_rms_before=rms(np.concatenate([trace.before for trace in traces]), weight),
        torque_rms_after=rms(np.concatenate([trace.after for trace in traces]), weight),
        torque_rms_filter_hz=min(run.prepared.decimation.cutoff for run in runs),
    )
