"""Evidence: traces of all runs out of what a search has come to."""

from dataclasses import dataclass

import numpy as np

from ...model import Model
from ..findings.trace import Evidence, Trace
from ..runs.driven import Driven
from ..runs.rows import Rows
from ..search.search import SearchResult


@dataclass(frozen=True, eq=False)
class Residuals:
    """What is left of the torque of all runs, shape (r, n) each [N m].

    Attributes:
        before: By the nominal model, friction, offsets and what is unstated fitted.
        after: With everything that was found.
        explained: Torque of each finding, shape (f, r, n) [N m].
    """

    before: np.ndarray
    after: np.ndarray
    explained: np.ndarray

    @classmethod
    def of(cls, found: SearchResult) -> "Residuals":
        """Of a search."""
        rows, values = found.prediction.rows, found.prediction.values
        before = rows.difference - rows.columns @ nominal_unknowns(found)
        return cls(before, found.prediction.residual, explained(found, rows, values))


def evidence(found: SearchResult, residuals: Residuals, noise: np.ndarray) -> Evidence:
    """What the answer rests on, runs held out first.

    Args:
        found: Result of the search.
        residuals: Of all its rows.
        noise: Noise floor of each joint's torque, shape (n,) [N m].
    """
    model, word, fitted = found.problem.model, nominal_unknowns(found), found.prediction.values
    runs, count = found.problem.runs, len(model.names)
    traces = [
        _trace(model, run, residuals, rows, found.problem.base.weight[rows])
        for run, rows in zip(runs, found.prediction.rows.runs, strict=True)
    ]
    fitted_runs = len(found.problem.fitted)
    return Evidence(
        model=model,
        before=model.nominal_values + word[:count],
        after=model.nominal_values + fitted[:count],
        gain_before=_gains(found, word),
        gain_after=_gains(found, fitted),
        noise=noise,
        traces=(*traces[fitted_runs:], *traces[:fitted_runs]),
        filtering=runs[0].filtering,
    )


def nominal_unknowns(found: SearchResult) -> np.ndarray:
    """Unknowns (b,) of the nominal model, without any finding; what is unstated is fitted."""
    word = found.problem.nominal_unknowns(found.without_findings)
    return np.append(word, np.zeros(len(found.prediction.rows.names) - len(word)))


def places_of(found: SearchResult, place: int) -> np.ndarray:
    """Places of a finding's coefficients among all unknowns."""
    counts = [len(one.answer.values) for one in found.selected]
    start = len(found.prediction.rows.names) - sum(counts[place:])
    return np.arange(start, start + counts[place])


def explained(found: SearchResult, rows: Rows, values: np.ndarray) -> np.ndarray:
    """Torque of each finding by unknowns (b,), shape (f, r, n) [N m]."""
    own = [places_of(found, place) for place in range(len(found.selected))]
    parts = [rows.columns[:, :, places] @ values[places] for places in own]
    return np.array(parts).reshape(len(parts), *rows.difference.shape)


def _gains(found: SearchResult, values: np.ndarray) -> np.ndarray:
    """Drive gains out of the shares by which they are off, among all unknowns (b,)."""
    nominal = found.problem.runs[0].prepared.gain
    places = dict(zip(found.prediction.rows.names, values, strict=True))
    return nominal * (1.0 + np.array([places.get(f"gain{joint + 1}", 0.0) for joint in range(len(nominal))]))


def _trace(model: Model, run: Driven, left: Residuals, rows: slice, weight: np.ndarray) -> Trace:
    prepared, robot, motion = run.prepared, model.robot, run.motion
    places = prepared.decimation.centres(len(motion))[: run.rows]
    return Trace(
        name=prepared.name,
        role=run.role,
        time=motion.time[places],
        position=motion.position[places],
        velocity=motion.velocity[places],
        acceleration=motion.acceleration[places],
        load=motion.load[places],
        temperature=motion.temperature[places],
        motor_angle=motion.position[places] @ robot.coupling.T * robot.gear_ratio,
        measured=prepared.gain * prepared.decimated_current[: run.rows],
        before=left.before[rows],
        after=left.after[rows],
        explained=left.explained[:, rows],
        weight=weight,
    )
