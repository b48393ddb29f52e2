"""Diagnose: from a believed model and its runs to findings, what is left, and what was gained."""

import time
from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from ..identification import with_payloads
from ..model import Model
from ..recording import Recording
from .candidate import UNNAMED
from .confirmed import confirmed, gained, unaccounted
from .driven import Driven
from .evidence import evidence
from .finding import Alternative, Diagnosis, Finding, Improvement, Quantity
from .found import Found
from .held_out import HeldOut, columns_of
from .hypothesis import Hypothesis
from .remainder import asked, greatest, remainders
from .runs import HELD_OUT, usable
from .search import Searched, search
from .shape_doubt import Doubt
from .shape_doubt import doubts as shape_doubts


def diagnose(model: Model, recordings: Sequence[tuple[str, Recording]], name: str = "") -> Diagnosis:
    """Say which physics a model leaves out.

    Args:
        model: As believed, with its tolerances.
        recordings: Role and recording of each run; those of role "validate" are not fitted.
        name: Of the case; the robot's by default.

    Raises:
        DifferentRobot: A run of another robot.
        RecordingError: No run is left to fit.
    """
    # Thousands of small systems: threads of linear algebra would wait for one another.
    with threadpool_limits(limits=1):
        return _diagnosed(model, recordings, name)


def _diagnosed(model: Model, recordings: Sequence[tuple[str, Recording]], name: str) -> Diagnosis:
    began = time.monotonic()
    model = with_payloads(model, [recording for _, recording in recordings])
    every, doubts = usable(model, recordings)
    fitted = [run for run in every if run.role != HELD_OUT]
    found = search(model, fitted)
    apart = [run for run in every if run.role == HELD_OUT]
    noise = noise_floor(found.runs)
    features = asked(model, found.runs)
    found = confirmed(model, found, apart, features, noise)
    held_out = HeldOut.of(model, found, apart)
    gains = gained(found, held_out)
    left = unaccounted(found, greatest(found.solution, features, noise), held_out)
    rate = 1.0 / float(np.median(np.diff(found.runs[0].prepared.decimated_time)))
    return Diagnosis(
        name=name or model.robot.name,
        joints=model.robot.joints,
        findings=tuple(
            _finding(found, place, gain, doubt)
            for place, (gain, doubt) in enumerate(zip(gains, shape_doubts(found), strict=True))
        ),
        remainders=tuple(remainders(found.solution, left, rate, noise)),
        improvement=_improvement(found, held_out, apart, noise),
        runs=tuple(run.prepared.name for run in fitted),
        doubts=tuple(doubts),
        evidence=evidence(model, found, apart, held_out, noise),
        seconds=time.monotonic() - began,
        tried=found.scene.tried,
    )


def noise_floor(runs: Sequence[Driven]) -> np.ndarray:
    """Noise of each joint's torque behind the filter, shape (n,) [N m]."""
    squares = [(run.prepared.noise * run.prepared.gain) ** 2 for run in runs]
    return np.sqrt(np.mean(squares, axis=0))


def _finding(found: Searched, place: int, gain: float, doubt: Doubt) -> Finding:
    one: Found = found.found[place]
    hypothesis: Hypothesis = one.hypothesis
    candidate, own = hypothesis.candidate, columns_of(found, place)
    values = found.solution.values[own]
    numbers = {
        name: Quantity(float(value), float(deviation), unit)
        for name, value, deviation, unit in zip(
            candidate.names, *candidate.told_as(values, doubt.values), candidate.units, strict=True
        )
        if not name.startswith(UNNAMED)
    }
    shapes = {
        name: Quantity(
            value,
            doubt.shape.get(name, float("nan")),
            candidate.bounds[name].unit if name in candidate.bounds else "1",
        )
        for name, value in candidate.shape.items()
        if name != "reversal"
    } | {
        name: Quantity(value, doubt.shape.get(name, float("nan")), unit)
        for name, (value, unit) in candidate.told.items()
    }
    torque = np.zeros(found.rows.difference.shape[1])
    torque[hypothesis.columns.joints] = np.sqrt(np.mean((hypothesis.columns.values @ values) ** 2, axis=0))
    return Finding(
        candidate.effect,
        candidate.joints,
        numbers | shapes,
        one.probability,
        tuple(
            Alternative(other.candidate.effect, other.candidate.joints, p, other)
            for other, p in one.not_excluded
        ),
        torque,
        gain,
        candidate,
    )


def _improvement(
    found: Searched, held_out: HeldOut | None, runs: Sequence[Driven], noise: np.ndarray
) -> Improvement | None:
    if held_out is None:
        return None
    before, after = held_out.residuals(found)
    band = min(run.prepared.decimation.cutoff for run in runs)
    return Improvement(tuple(run.prepared.name for run in runs), before, after, noise, band)
