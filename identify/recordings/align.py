"""Aligning a recording to another one of the same run that was made by another recorder with another clock.

A controller's trace and the run that was commanded to it both have the positions, from the same encoders:
where these agree best is the offset between the clocks. In the same way it is seen how late an arm follows
its commands, which is of drives and their smoothing, and in no measurement.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.interpolate import CubicSpline

from ..errors import DifferentRobot, RecordingError
from .recording import Recording, Signal

OVERLAP = 0.25
"""Least share of the shorter recording that lies within the other; less is found by chance."""
MOVES = 0.01
"""Least motion within the overlap [rad], root mean square: standing arms agree at any offset."""
AGREES = 1e-3
"""Largest disagreement of two recordings of one run [rad], root mean square: 12 ms at 0.1 rad/s."""
CLEARER = 4.0
"""By how much every other offset must be worse, as variance, for one to be taken as the right one."""
RESOLVED = 1e-6
"""Difference that no encoder sees [rad]."""
NEAR = 0.1
"""Offsets no further from the best than this are not others, but the same minimum [s]."""
STEPS = 20
"""Of Gauss and Newton, at most; three do, from a grid."""
BLOCKS = 20
"""Pieces of the overlap whose disagreement is taken as independent of each other's."""
LONGEST = 0.3
"""Latency up to which is looked for [s]: more than any drive has that can be streamed to."""
LATENCY_STEP = 0.001
"""Between latencies that are tried; a parabola finds what lies between [s]."""
SAMPLES = 4000
"""Positions that are looked at, at most."""
LEAST_WAY = 1e-3
"""Way of commands below which none can be seen [rad]."""


@dataclass(frozen=True)
class Alignment:
    """How two clocks are related.

    Attributes:
        offset: To be added to the time of the first recording [s].
        std: Standard deviation of the offset [s].
        difference: Difference of the positions after alignment, root mean square, shape (n,) [rad].
        overlap: How long both were recording [s].
    """

    offset: float
    std: float
    difference: np.ndarray
    overlap: float

    def __str__(self) -> str:
        worst = float(self.difference.max())
        return (
            f"{self.offset:.6f} s +- {1e3 * self.std:.3g} ms, positions agree to {worst:.2g} rad over "
            f"{self.overlap:.1f} s"
        )


def align(recording: Recording, run: Recording) -> Alignment:
    """The offset between a recording, such as a trace, and the run whose time counts, by `nearest`.

    Raises:
        DifferentRobot: Not the same joints.
        RecordingError: No motion in common, not one run, or a motion that repeats itself.
    """
    found, again = nearest(recording, run)
    worst = float(found.difference.max())
    if worst > AGREES:
        joint = run.robot.joints[int(found.difference.argmax())]
        raise RecordingError(
            f"{recording.name} and {run.name} differ by {worst:.2g} rad on {joint} where they agree best, "
            f"limit {AGREES:g}: they are not of one run, or their joints count otherwise (sign and zero)"
        )
    if again:
        raise RecordingError(
            f"{recording.name} and {run.name} agree as well {again:.2f} s further: the motion repeats "
            "itself. Trace a piece with its beginning or end in it"
        )
    return found


def nearest(recording: Recording, run: Recording) -> tuple[Alignment, float]:
    """The offset at which positions of a recording agree best with those of the run whose time counts.

    First on a grid, by correlation; then between its points, by least squares on a spline. The standard
    deviation is that between pieces of the overlap, so that disagreement that is no white noise counts.

    Returns:
        The offset, and how much further they agree as well; zero if they do not [s].

    Raises:
        DifferentRobot: Not the same joints.
        RecordingError: No motion in common.
    """
    if recording.robot.joints != run.robot.joints:
        raise DifferentRobot(
            f"{recording.name} is of {', '.join(recording.robot.joints)}, {run.name} of "
            f"{', '.join(run.robot.joints)}"
        )
    ours, theirs = recording.signals["position"], run.signals["position"]
    if min(len(ours), len(theirs)) < 2 * BLOCKS:
        raise RecordingError(
            f"{recording.name} has {len(ours)} positions and {run.name} {len(theirs)}; to align them each "
            f"needs {2 * BLOCKS}"
        )
    step = max(ours.period, theirs.period)
    offset, again = _coarse(recording, run, step)
    return _refined(ours, theirs, offset, step), again


def aligned(recording: Recording, run: Recording) -> Recording:
    """A recording on the clock of a run, with all that is known of it: payload, trajectory, settings.

    Raises:
        DifferentRobot: As `align`.
        RecordingError: As `align`.
    """
    found = align(recording, run)
    signals = {
        name: Signal(signal.time + found.offset, signal.values) for name, signal in recording.signals.items()
    }
    for name in ("command", "command_velocity"):
        if name in run.signals:
            signals.setdefault(name, run.signals[name])
    return replace(
        run,
        name=recording.name,
        signals=signals,
        settings={**run.settings, **recording.settings, "aligned to": run.name, "clock offset": str(found)},
        host_time=_host_time(run, signals["position"].time),
        timing=None,
        warnings=(*run.warnings, *recording.warnings),
    )


def _coarse(recording: Recording, run: Recording, step: float) -> tuple[float, float]:
    """The best offset of whole steps [s], and how far from it another is as good; zero if none is."""
    ours, theirs = (_even(one.signals["position"], step) for one in (recording, run))
    count = round(OVERLAP * min(len(ours), len(theirs)))
    lags = np.arange(count - len(ours), len(theirs) - count + 1)
    mean, power = _disagreement(ours, theirs, lags)
    mean = np.where(power < MOVES**2, np.inf, mean)
    if not np.isfinite(mean).any():
        raise RecordingError(
            f"{recording.name} and {run.name} have no motion in common: root mean square below {MOVES:g} rad"
        )
    # What no encoder resolves is as good as nothing.
    good = CLEARER * max(float(np.min(mean)), RESOLVED**2)
    time = lags * step
    best = _first(mean, good, np.minimum(lags + len(ours), len(theirs)) - np.maximum(lags, 0), time)
    away = np.abs(time - time[best])
    others = np.where(away > NEAR, mean, np.inf)
    again = float(away[_first(others, good, -away, time)]) if np.any(others < good) else 0.0
    start = run.signals["position"].time[0] - recording.signals["position"].time[0]
    return float(start + time[best]), again


def _first(mean: np.ndarray, good: float, preference: np.ndarray, time: np.ndarray) -> int:
    """The place of the least disagreement near the one that is preferred of all that are good.

    Of a motion that repeats itself, most of both is compared at one offset only.
    """
    preferred = int(np.argmax(np.where(mean <= good, preference, -np.inf)))
    return int(np.argmin(np.where(np.abs(time - time[preferred]) <= NEAR, mean, np.inf)))


def _even(signal: Signal, step: float) -> np.ndarray:
    """Positions in even steps from the first on, shape (t, n)."""
    time = np.arange(signal.time[0], signal.time[-1], step)
    return CubicSpline(signal.time, signal.values)(time)


def _disagreement(ours: np.ndarray, theirs: np.ndarray, lags: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean square of the difference, and of the motion, where both overlap, at each lag."""
    centre = theirs.mean(axis=0)
    ours, theirs = ours - centre, theirs - centre
    size = next_fast_len(len(ours) + len(theirs))
    product = irfft((rfft(theirs, size, axis=0) * rfft(ours, size, axis=0).conj()).sum(axis=1), size)[lags]
    begin, end = np.maximum(lags, 0), np.minimum(lags + len(ours), len(theirs))
    length = end - begin
    mine, other = (np.concatenate([[0.0], np.cumsum((a**2).sum(axis=1))]) for a in (ours, theirs))
    squares = mine[end - lags] - mine[begin - lags] + other[end] - other[begin]
    sums = np.concatenate([np.zeros((1, theirs.shape[1])), np.cumsum(theirs, axis=0)])
    middle = (((sums[end] - sums[begin]) / length[:, None]) ** 2).sum(axis=1)
    power = (other[end] - other[begin]) / length - middle
    return (squares - 2.0 * product) / length, power


def _refined(ours: Signal, theirs: Signal, near: float, step: float) -> Alignment:
    """The offset by least squares within a step of one, by Gauss and Newton."""
    offset = near
    spline = CubicSpline(ours.time, ours.values)
    slope = spline.derivative()
    for _ in range(STEPS):
        inside = (theirs.time - offset >= ours.time[0]) & (theirs.time - offset <= ours.time[-1])
        time = theirs.time[inside] - offset
        velocity, difference = slope(time), spline(time) - theirs.values[inside]
        power = float((velocity**2).sum())
        change = float((velocity * difference).sum()) / power
        if abs(change) < 1e-9 or abs(offset + change - near) > step:
            break  # there, or away from where nothing agrees
        offset += change
    score = (velocity * difference).sum(axis=1)
    pieces = np.array([piece.sum() for piece in np.array_split(score, BLOCKS)])
    std = float(np.sqrt((pieces**2).sum() * BLOCKS / (BLOCKS - 1)) / power)
    return Alignment(offset, std, np.sqrt((difference**2).mean(axis=0)), float(time[-1] - time[0]))


def _host_time(run: Recording, time: np.ndarray) -> np.ndarray | None:
    """Host's clock at times of a run, beyond its ends too, shape (t,) [ns]."""
    if run.host_time is None or not len(run.host_time):
        return None
    known = run.signals["position"].time
    late = run.host_time - run.host_time[0] - 1e9 * (known - known[0])
    since = 1e9 * (time - known[0]) + np.interp(time, known, late)
    return run.host_time[0] + np.rint(since).astype(np.int64)


def follows_by(command: Signal, position: Signal) -> float:
    """By how much positions are behind commands, in least squares over all joints [s]; NaN where unseen.

    A steady distance, as of a joint that bears a load, does not count.
    """
    if len(command) < 2 or np.nanmax(np.ptp(command.values, axis=0)) < LEAST_WAY:
        return float("nan")
    inside = (position.time >= command.time[0] + LONGEST) & (position.time <= command.time[-1])
    rows = np.flatnonzero(inside & np.isfinite(position.values).all(axis=1))
    rows = rows[:: max(len(rows) // SAMPLES, 1)]
    if len(rows) < 10:
        return float("nan")
    time, values = position.time[rows], position.values[rows]
    latencies = np.arange(0.0, LONGEST + 0.5 * LATENCY_STEP, LATENCY_STEP)
    left = np.array([_distance(command, time - latency, values) for latency in latencies])
    best = int(np.argmin(left))
    if best in (0, len(left) - 1):
        return float(latencies[best]) if best == 0 else float("nan")
    before, here, after = left[best - 1 : best + 2]
    return float(latencies[best] + 0.5 * LATENCY_STEP * (before - after) / (before - 2.0 * here + after))


def _distance(command: Signal, time: np.ndarray, values: np.ndarray) -> float:
    """Sum of squares of positions away from commands at a time, but for the mean of each joint [rad^2]."""
    commanded = np.column_stack([np.interp(time, command.time, joint) for joint in command.values.T])
    away = values - commanded
    return float(np.sum((away - away.mean(axis=0)) ** 2))
