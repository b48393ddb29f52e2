"""Evidence: traces of all runs out of what a search has come to."""

from collections.abc import Sequence

import numpy as np

from ..model import Model
from .driven import Driven, slices
from .held_out import HeldOut, at_its_word
from .rows import Rows
from .search import Searched
from .trace import Evidence, Trace


def evidence(
    model: Model, found: Searched, runs: Sequence[Driven], held_out: HeldOut | None, noise: np.ndarray
) -> Evidence:
    """What the answer rests on.

    Args:
        model: As believed, with the payloads of the runs.
        found: Result of the search.
        runs: Those held out.
        held_out: Their rows; None without any.
        noise: Noise floor of each joint's torque, shape (n,) [N m].
    """
    word, fitted = at_its_word(found), found.solution.values
    own = [] if held_out is None else _traces(model, found, runs, held_out.rows, word)
    count = len(model.names)
    return Evidence(
        model=model,
        before=model.believed_values + word[:count],
        after=model.believed_values + fitted[:count],
        gain_before=_gains(found, word),
        gain_after=_gains(found, fitted),
        noise=noise,
        traces=(*own, *_traces(model, found, found.runs, found.rows, word)),
        filtering=found.runs[0].filtering,
    )


def _gains(found: Searched, values: np.ndarray) -> np.ndarray:
    """Drive gains out of the shares by which they are off, among all unknowns (b,)."""
    believed = found.runs[0].prepared.gain
    places = dict(zip(found.rows.names, values, strict=True))
    return believed * (
        1.0 + np.array([places.get(f"gain{joint + 1}", 0.0) for joint in range(len(believed))])
    )


def _traces(
    model: Model, found: Searched, runs: Sequence[Driven], rows: Rows, word: np.ndarray
) -> list[Trace]:
    before = rows.difference - rows.columns @ word
    after = rows.difference - rows.columns @ found.solution.values
    explained = _explained(found, rows)
    return [
        _trace(model, run, before[own], after[own], explained[:, own], rows.weight[own])
        for run, own in zip(runs, slices(runs), strict=True)
    ]


def _explained(found: Searched, rows: Rows) -> np.ndarray:
    """Torque of each finding, shape (f, r, n) [N m]; their columns are the last."""
    counts = [len(one.hypothesis.candidate.names) for one in found.found]
    values = found.solution.values
    stops = len(values) - sum(counts) + np.cumsum(counts, dtype=int)
    parts = [
        rows.columns[:, :, stop - count : stop] @ values[stop - count : stop]
        for stop, count in zip(stops, counts, strict=True)
    ]
    return np.array(parts).reshape(len(parts), *rows.difference.shape)


def _trace(
    model: Model,
    run: Driven,
    before: np.ndarray,
    after: np.ndarray,
    explained: np.ndarray,
    weight: np.ndarray,
) -> Trace:
    prepared, robot = run.prepared, model.robot
    motion = run.motion
    places = prepared.decimation.centres(len(motion))
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
        measured=prepared.gain * prepared.decimated_current,
        before=before,
        after=after,
        explained=explained,
        weight=weight,
    )
