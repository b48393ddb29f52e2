"""Diagnose: from a nominal model and its runs to findings, remainders and held-out residuals."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np
from threadpoolctl import threadpool_limits

from ..fit.identification import pooled_noise, with_payloads
from ..model import Model
from ..plausible.gains import gains_by_masses, masses_sentence, with_gains
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
from .results.adequacy import gated
from .results.baseline import baselines
from .results.budget import NOISE, budget
from .results.evidence import Spread, deviations, evidence, places_of, with_shapes
from .results.motor_torque import undetermined_gains, with_all_torque
from .results.remainder import MAIN, MATERIAL, beside_unnamed, discrepancies, fast_ripples, remainders, rms
from .results.sizes import left_out, size
from .runs.driven import Driven
from .runs.usable import HELD_OUT, usable
from .search.beliefs import search_both
from .search.once import moments
from .search.search import SearchResult
from .words.measures import in_units_of_joints, torque_units

SMOOTH = "the signals were smoothed, so noise is unknown: runs are compared up to {:.3g} Hz"
LAPS = 2.0
"""Number of times a motion is made from which on the result says so [-]: half of the runs tests no model."""
REPEATED = (
    "the runs make each motion {:.2g} times, and laps do not test one another: another motion tells more"
)


# Threads of linear algebra would only wait for one another in thousands of small systems.
@threadpool_limits.wrap(limits=1)
def diagnose(
    model: Model,
    recordings: Sequence[tuple[str, Recording]],
    name: str = "",
    filtering: Filtering = Filtering(),  # noqa: B008
    progress: Callable[[str], None] = lambda _: None,
    as_recorded: bool = False,
    brief: bool = False,
) -> Diagnosis:
    """Find the physics that a model lacks, whose unstated parameters are fitted freely.

    Each recording has a role; those with the role "validate" are only predicted. A brief search, at a quarter
    of the time, is for findings that simulations judge.

    Raises:
        DifferentRobot: A run belongs to another robot.
        RecordingError: No run can be fitted.
    """
    began = time.monotonic()
    model = with_payloads(model, [recording for _, recording in recordings])
    progress(StageText("filter", "filter and differentiate"))
    runs, warnings = usable(model, recordings, filtering)
    if not as_recorded and (drives := gains_by_masses(_fitted(runs, recordings), model)):
        model = with_gains(model, drives)
        runs, warnings = usable(model, recordings, filtering)
        likely = masses_sentence(drives, model.robot)
        warnings = [f"no drive gain is known, so sizes are as uncertain as the {likely}", *warnings]
    suspicions: list[str] = []
    if not as_recorded:
        used = {run.prepared.name for run in runs}
        checked = [run for _, run in recordings if run.name in used]
        suspicions = doubts(checked, model)
        for doubt in suspicions:
            progress(f"warning: {doubt}")
    progress(StageText("search", "search among all candidates"))
    result, beliefs = search_both(model, runs, brief)
    result = with_all_torque(result)
    progress(StageText("weigh", "weigh the findings"))
    answers = discrepancies(result.problem, result.prediction)
    noise, rested = noise_floor(result.problem.runs)
    material = MATERIAL
    if pooled_noise([run.prepared for run in result.problem.runs])[0].noise_source in SMOOTHED_SOURCES:
        # Without a noise floor, the residual with all findings is the only available level.
        noise = np.maximum(noise, rms(result.prediction.residual, result.prediction.rows.weight))
        rested, material = False, MAIN
        warnings = [*warnings, SMOOTH.format(result.problem.runs[0].prepared.decimation.cutoff)]
    if (laps := result.problem.blocks.laps) >= LAPS:
        warnings = [*warnings, REPEATED.format(laps)]
    noise = np.sqrt(result.problem.rows.row_variance(noise**2))
    result, fit = gated(beside_unnamed(result, answers, noise))
    steps = baselines(result)
    first = next(steps)
    proof = evidence(result, first, noise)
    spread, named = with_shapes(result), sum(finding.named for finding in result.selected)
    warnings = [*warnings, *undetermined_gains(result, spread)]
    std, fitted = deviations(result, spread), proof.traces[len(result.problem.held_out) :]
    findings = [
        _sized(result, place, spread, fitted, _finding(result, place, std[place]))
        for place in range(len(result.selected))
    ]
    remaining = remainders(result.prediction, answers, noise, rested, material)
    units = torque_units(model.robot, result.problem.runs[0].prepared.measures)
    remaining += fast_ripples(result.problem.runs, noise, units)
    held_out = [run.prepared.name for run in result.problem.held_out]
    quiet = noise if rested else np.zeros_like(noise)
    spent = budget(chain([first], steps), result.prediction, answers, quiet, held_out)
    conditional = tuple(place for place, selected in enumerate(result.selected) if selected.conditional)
    diagnosis = Diagnosis(
        name=name or model.robot.name,
        joints=model.robot.joints,
        torque_units=units,
        findings=tuple(in_units_of_joints(finding, model.robot) for finding in findings[:named]),
        undecided=tuple(in_units_of_joints(finding, model.robot) for finding in findings[named:]),
        remainders=tuple(remaining),
        moments=tuple(moments(result.problem, result.prediction)),
        budget=spent,
        noise=proof.noise,
        noise_measured_at_rest=any(share.kind == NOISE for share in spent.shares),
        runs=tuple(run.prepared.name for run in result.problem.fitted),
        suspicions=tuple(suspicions),
        warnings=tuple(warnings),
        seconds=time.monotonic() - began,
        tried=result.problem.tried,
        beliefs=beliefs and replace(beliefs, conditional=conditional),
        adequacy=fit,
        evidence=proof,
    )
    return _with_held_out(diagnosis, proof, result.problem.held_out)


def _fitted(runs: Sequence[Driven], recordings: Sequence[tuple[str, Recording]]) -> list[Recording]:
    """Recordings of the runs that are fitted."""
    names = {run.prepared.name for run in runs if run.role != HELD_OUT}
    return [recording for _, recording in recordings if recording.name in names]


def noise_floor(runs: Sequence[Driven]) -> tuple[np.ndarray, bool]:
    """Noise of each joint's filtered torque, shape (n,) [N m], and whether it was measured at rest."""
    first = pooled_noise([run.prepared for run in runs])[0]
    return first.noise * np.abs(first.gain), first.noise_source == "rest"


def _finding(result: SearchResult, place: int, spread: tuple[np.ndarray, dict[str, float]]) -> Finding:
    selected, values = result.selected[place], result.prediction.values[places_of(result, place)]
    answer, candidate = selected.answer, selected.answer.candidate
    torque = np.zeros(result.prediction.joints)
    torque[answer.columns.joints] = np.sqrt(np.mean((answer.columns.values @ values) ** 2, axis=0))
    held_out = answer.gains[~result.problem.blocks.fitted]
    family, family_probability = selected.family
    return Finding(
        **stated(candidate),
        parameters=quantities(candidate, values, *spread) | _range(answer, values),
        probability=selected.certainty,
        alternatives=tuple(alternative(other, chance) for other, chance in selected.elsewhere),
        torque_rms=torque,
        held_out=2.0 * float(held_out.sum()) if len(held_out) else float("nan"),
        alone=selected.alone,
        unnamed=selected.unnamed >= 1.0,
        family=family,
        family_probability=family_probability,
        proven=selected.proven,
    )


def _sized(
    result: SearchResult, place: int, spread: Spread, fitted: Sequence[Trace], finding: Finding
) -> Finding:
    """The finding with its torque in the fitted runs and with its undetermined parameters."""
    undetermined = left_out(result, spread, place, finding.parameters)
    if not kind_of(finding.effect).formula:
        undetermined = dict.fromkeys(finding.parameters, OF_A_CURVE)
    return replace(finding, size=size(result, spread, fitted, place), left_out=undetermined)


def _range(answer: Answer, values: np.ndarray) -> dict[str, Quantity]:
    """Smallest and largest torque of a finding whose parameters are known only as a product."""
    determined_as = kind_of(answer.candidate.effect).determined_as
    if not determined_as:
        return {}
    torque, (_, unit) = answer.columns.values @ values, next(iter(determined_as.values()))
    ends = {"torque_least": float(np.min(torque)), "torque_most": float(np.max(torque))}
    return {name: Quantity(value, float("nan"), unit) for name, value in ends.items()}


def _with_held_out(diagnosis: Diagnosis, proof: Evidence, runs: Sequence[Driven]) -> Diagnosis:
    """The diagnosis with the residuals of its held-out runs; unchanged without such runs."""
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
