"""Alignment of two recordings of the same run by different recorders with different clocks.

A controller's trace and the recorded run both contain positions from the same encoders. The clocks differ by
the offset at which these positions agree best. The latency with which an arm follows its commands, due to
drives and their smoothing, is found in the same way.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.interpolate import CubicSpline

from ..errors import DifferentRobot, RecordingError
from .recording import Recording, Signal

OVERLAP = 0.25
"""Minimum overlap as a share of the shorter recording; a smaller overlap may agree by chance."""
MOVES = 0.01
"""Minimum motion within the overlap, root mean square [rad]: arms at rest agree at any offset."""
AGREES = 1e-3
"""Maximum difference of two recordings of one run, root mean square [rad]: 12 ms at 0.1 rad/s."""
CLEARER = 4.0
"""Ratio of variances by which every other offset must be worse for the best offset to be unique."""
RESOLVED = 1e-6
"""Difference below the resolution of any encoder [rad]."""
NEAR = 0.1
"""Distance from the best offset within which offsets belong to the same minimum [s]."""
STEPS = 20
"""Maximum number of Gauss-Newton steps; from a grid, three suffice."""
BLOCKS = 20
"""Number of pieces of the overlap whose differences count as independent."""
LONGEST = 0.3
"""Maximum latency of the search [s]: more than that of any drive that accepts streamed commands."""
LATENCY_STEP = 0.001
"""Distance between trial latencies, refined by a parabola [s]."""
SAMPLES = 4000
"""Maximum number of positions that are compared."""
LEAST_TRAVEL = 1e-3
"""Minimum travel of commands for a latency to be observable [rad]."""


@dataclass(frozen=True)
class Alignment:
    """Relation of two clocks."""

    offset: float  # time to add to the clock of the first recording [s]
    std: float  # standard deviation of the offset [s]
    difference: np.ndarray  # difference of the positions after alignment, root mean square, shape (n,) [rad]
    overlap: float  # duration of the overlap of both recordings [s]

    def __str__(self) -> str:
        worst = float(self.difference.max())
        return (
            f"{self.offset:.6f} s +- {1e3 * self.std:.3g} ms, positions agree to {worst:.2g} rad over "
            f"{self.overlap:.1f} s"
        )


def align(recording: Recording, run: Recording) -> Alignment:
    """Offset by `nearest` between a recording, such as a trace, and the run to whose clock it is aligned.

    Raises `RecordingError` if the runs differ, or if their motion repeats itself.
    """
    alignment, distance = nearest(recording, run)
    worst = float(alignment.difference.max())
    if worst > AGREES:
        joint = run.robot.joints[int(alignment.difference.argmax())]
        raise RecordingError(
            f"{recording.name} and {run.name} differ by {worst:.2g} rad on {joint} at the best offset, "
            f"limit {AGREES:g}: they are different runs, or their joints differ in sign or zero"
        )
    if distance:
        raise RecordingError(
            f"{recording.name} and {run.name} agree equally well {distance:.2f} s further: the motion "
            "repeats itself. Trace a piece that contains its beginning or end"
        )
    return alignment


def nearest(recording: Recording, run: Recording) -> tuple[Alignment, float]:
    """Offset at which the positions of a recording agree best with those of a run.

    The offset is found on a grid by correlation, and then refined by least squares on a spline. Its standard
    deviation comes from the scatter between pieces of the overlap, which includes differences that are not
    white noise. Beside the alignment is the distance to another offset at which they agree equally well [s];
    zero if there is none. Raises `RecordingError` without common motion.
    """
    if recording.robot.joints != run.robot.joints:
        raise DifferentRobot(
            f"{recording.name} is of {', '.join(recording.robot.joints)}, {run.name} of "
            f"{', '.join(run.robot.joints)}"
        )
    trace, reference = recording.signals["position"], run.signals["position"]
    if min(len(trace), len(reference)) < 2 * BLOCKS:
        raise RecordingError(
            f"{recording.name} has {len(trace)} positions and {run.name} {len(reference)}; to align them "
            f"each needs {2 * BLOCKS}"
        )
    step = max(trace.period, reference.period)
    offset, distance = _coarse(recording, run, step)
    return _refined(trace, reference, offset, step), distance


def aligned(recording: Recording, run: Recording) -> Recording:
    """A recording on the clock of a run, with the payload, trajectory and settings of the run."""
    alignment = align(recording, run)
    known = {"aligned to": run.name, "clock offset": str(alignment)}
    signals = {
        name: Signal(signal.time + alignment.offset, signal.values)
        for name, signal in recording.signals.items()
    }
    for name in ("command", "command_velocity"):
        if name in run.signals:
            signals.setdefault(name, run.signals[name])
    return replace(
        run,
        name=recording.name,
        signals=signals,
        settings={**run.settings, **recording.settings, **known},
        host_time=_host_time(run, signals["position"].time),
        timing=None,
        warnings=(*run.warnings, *recording.warnings),
    )


def _coarse(recording: Recording, run: Recording, step: float) -> tuple[float, float]:
    """Best offset in whole steps, and distance to another equally good offset [s]; zero if there is none."""
    trace, reference = (
        CubicSpline(signal.time, signal.values)(np.arange(signal.time[0], signal.time[-1], step))
        for signal in (recording.signals["position"], run.signals["position"])
    )
    count = round(OVERLAP * min(len(trace), len(reference)))
    lags = np.arange(count - len(trace), len(reference) - count + 1)
    mean, power = _disagreement(trace, reference, lags)
    mean = np.where(power < MOVES**2, np.inf, mean)
    if not np.isfinite(mean).any():
        raise RecordingError(
            f"{recording.name} and {run.name} have no motion in common: root mean square below {MOVES:g} rad"
        )
    # A difference below the resolution of encoders counts as zero.
    good = CLEARER * max(float(np.min(mean)), RESOLVED**2)
    time = lags * step
    best = _first(mean, good, np.minimum(lags + len(trace), len(reference)) - np.maximum(lags, 0), time)
    away = np.abs(time - time[best])
    others = np.where(away > NEAR, mean, np.inf)
    distance = float(away[_first(others, good, -away, time)]) if np.any(others < good) else 0.0
    start = run.signals["position"].time[0] - recording.signals["position"].time[0]
    return float(start + time[best]), distance


def _first(mean: np.ndarray, good: float, preference: np.ndarray, time: np.ndarray) -> int:
    """Index of the smallest difference near the preferred offset among all good offsets.

    If a motion repeats itself, only one of these offsets has the largest overlap.
    """
    preferred = int(np.argmax(np.where(mean <= good, preference, -np.inf)))
    return int(np.argmin(np.where(np.abs(time - time[preferred]) <= NEAR, mean, np.inf)))


def _disagreement(
    trace: np.ndarray, reference: np.ndarray, lags: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Mean square of the difference and of the motion in the overlap, at each lag."""
    center = reference.mean(axis=0)
    trace, reference = trace - center, reference - center
    size = next_fast_len(len(trace) + len(reference))
    spectra = rfft(reference, size, axis=0) * rfft(trace, size, axis=0).conj()
    product = irfft(spectra.sum(axis=1), size)[lags]
    begin, end = np.maximum(lags, 0), np.minimum(lags + len(trace), len(reference))
    length = end - begin
    mine, other = (np.concatenate([[0.0], np.cumsum((a**2).sum(axis=1))]) for a in (trace, reference))
    squares = mine[end - lags] - mine[begin - lags] + other[end] - other[begin]
    sums = np.concatenate([np.zeros((1, reference.shape[1])), np.cumsum(reference, axis=0)])
    middle = (((sums[end] - sums[begin]) / length[:, None]) ** 2).sum(axis=1)
    power = (other[end] - other[begin]) / length - middle
    return (squares - 2.0 * product) / length, power


def _refined(trace: Signal, reference: Signal, start: float, step: float) -> Alignment:
    """Alignment whose offset is within a step of the start, by Gauss-Newton least squares."""
    offset = start
    spline = CubicSpline(trace.time, trace.values)
    slope = spline.derivative()
    for _ in range(STEPS):
        inside = (reference.time - offset >= trace.time[0]) & (reference.time - offset <= trace.time[-1])
        time = reference.time[inside] - offset
        velocity, difference = slope(time), spline(time) - reference.values[inside]
        power = float((velocity**2).sum())
        change = float((velocity * difference).sum()) / power
        if abs(change) < 1e-9 or abs(offset + change - start) > step:
            break  # converged, or diverging because nothing agrees
        offset += change
    score = (velocity * difference).sum(axis=1)
    pieces = np.array([piece.sum() for piece in np.array_split(score, BLOCKS)])
    std = float(np.sqrt((pieces**2).sum() * BLOCKS / (BLOCKS - 1)) / power)
    return Alignment(offset, std, np.sqrt((difference**2).mean(axis=0)), float(time[-1] - time[0]))


def _host_time(run: Recording, time: np.ndarray) -> np.ndarray | None:
    """Host clock at times of a run, extrapolated beyond its ends, shape (t,) [ns]."""
    if run.host_time is None or not len(run.host_time):
        return None
    known = run.signals["position"].time
    late = run.host_time - run.host_time[0] - 1e9 * (known - known[0])
    since = 1e9 * (time - known[0]) + np.interp(time, known, late)
    return run.host_time[0] + np.rint(since).astype(np.int64)


def follows_by(command: Signal, position: Signal) -> float:
    """Latency of positions behind commands, by least squares over all joints [s]; NaN if it is unobservable.

    A constant difference, such as that of a loaded joint, has no influence.
    """
    if len(command) < 2 or np.nanmax(np.ptp(command.values, axis=0)) < LEAST_TRAVEL:
        return float("nan")
    inside = (position.time >= command.time[0] + LONGEST) & (position.time <= command.time[-1])
    rows = np.flatnonzero(inside & np.isfinite(position.values).all(axis=1))
    rows = rows[:: max(len(rows) // SAMPLES, 1)]
    if len(rows) < 10:
        return float("nan")
    time, values = position.time[rows], position.values[rows]
    latencies = np.arange(0.0, LONGEST + 0.5 * LATENCY_STEP, LATENCY_STEP)
    squares = []
    for latency in latencies:
        away = values - command.at(time - latency)
        squares.append(float(np.sum((away - away.mean(axis=0)) ** 2)))
    best = int(np.argmin(squares))
    if best in (0, len(squares) - 1):
        return float(latencies[best]) if best == 0 else float("nan")
    before, here, after = squares[best - 1 : best + 2]
    return float(latencies[best] + 0.5 * LATENCY_STEP * (before - after) / (before - 2.0 * here + after))
