"""Differences between two recordings of one motion after the same filters, by joint and region."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from ..errors import DifferentRobot, RecordingError
from ..fit.fit import Fit
from ..preparation.prepare import SMOOTHED_SOURCES, Filtering, Prepared, choose, prepare
from ..recordings.recording import EFFORT, SIGNALS, Recording
from ..schema import Number, check, check_different, check_length, check_rows
from ..schema import Size as SizeNumber

THIRDS = 3
"""Number of regions along each axis, low, middle and high, with equal numbers of samples."""
SMOOTH = "the signal was smoothed before recording, so its noise is unknown"
NAMES = ("low", "middle", "high")
"""Names of the regions."""


@dataclass(frozen=True, eq=False)
class Regions:
    """Mismatch of one quantity in thirds of the recorded motion."""

    # Bounds of the thirds, shape (n, 4); speed [rad/s], position [rad], effort [A] or [N m].
    edges: np.ndarray
    rms: np.ndarray  # RMS difference in each third, shape (n, 3)


@dataclass(frozen=True, eq=False)
class Mismatch:
    """Difference between two recordings in one quantity."""

    quantity: str  # "position", "velocity", "current" or "torque"
    units: tuple[str, ...]  # unit of each joint
    rms: np.ndarray  # RMS of simulated minus recorded, shape (n,)
    mean: np.ndarray  # mean of simulated minus recorded, shape (n,)
    size: np.ndarray  # standard deviation of the recorded quantity over time, shape (n,)
    # Combined noise of both recordings after the filter, shape (n,); NaN where it is unknown.
    noise: np.ndarray
    # Mismatch by "speed", "position" and "load", the magnitude of the recorded effort.
    regions: Mapping[str, Regions]

    def check(self, where: str, joints: int) -> None:
        """Raise `Disagreement` with the first field of another shape."""
        for name in ("units", "rms", "mean", "size", "noise"):
            check_length(getattr(self, name), f"{where}.{name}", joints, "one a joint")
        for kind, regions in self.regions.items():
            for name, count in (("edges", THIRDS + 1), ("rms", THIRDS)):
                rows = getattr(regions, name)
                check_length(rows, f"{where}.regions.{kind}.{name}", joints, "one a joint")
                check_rows([*rows], f"{where}.regions.{kind}.{name}", count, f"of {THIRDS} regions")


@dataclass(frozen=True, eq=False)
class Comparison:
    """Comparison of two recordings."""

    simulated: str  # name of the simulated recording
    recorded: str  # name of the real recording, which is the reference
    joints: tuple[str, ...]  # joint names
    offset: Number  # offset added to the time of the simulated recording [s]
    duration: SizeNumber  # duration of the overlap [s]
    filter_hz: SizeNumber  # cut-off frequency of the low-pass filter applied to both [Hz]
    # Differences in position, velocity, and current or torque, by the name of the quantity.
    mismatch: Mapping[str, Mismatch]
    warnings: tuple[str, ...] = ()  # other differences, in sentences

    @property
    def effort(self) -> Mismatch:
        """Mismatch of current or torque."""
        return [*self.mismatch.values()][-1]

    def __post_init__(self) -> None:
        check_different(self.joints, "joints")
        check(
            len(self.mismatch) == 3, "mismatch", [*self.mismatch], "position, velocity, and current or torque"
        )
        for name, mismatch in self.mismatch.items():
            mismatch.check(f"mismatch.{name}", len(self.joints))


def compare(
    simulated: Recording, recorded: Recording, offset: float = 0.0, fit: Fit | None = None
) -> Comparison:
    """Compare two recordings after the same filters, using those and the noise level of a fit if passed.

    Effort is compared only while a joint slides, since static friction at rest is unknown. The offset [s] is
    added to the time of the simulated recording.

    Raises:
        DifferentRobot: If the recordings have different joints.
        RecordingError: If they do not overlap, or the overlap is too short for the filters.
    """
    effort, simulated_run, recorded_run = _side_by_side(simulated, recorded, offset, fit)
    unknown = np.full(recorded_run.noise.shape, np.nan)
    smoothed = recorded_run.noise_source in SMOOTHED_SOURCES
    noise = unknown if smoothed else np.hypot(simulated_run.noise, recorded_run.noise)
    sliding = recorded_run.weight > 0
    everywhere = np.ones_like(sliding)
    axes = {
        "speed": np.abs(recorded_run.decimation.apply(recorded_run.motion.velocity)),
        "position": recorded_run.decimation.apply(recorded_run.motion.position),
        "load": np.abs(recorded_run.decimated_current),
    }
    series: tuple[tuple[str, Callable[[Prepared], np.ndarray], np.ndarray, np.ndarray], ...] = (
        ("position", lambda run: run.decimation.apply(run.motion.position), everywhere, unknown),
        ("velocity", lambda run: run.decimation.apply(run.motion.velocity), everywhere, unknown),
        (effort, lambda run: run.decimated_current, sliding, noise),
    )
    return Comparison(
        simulated=simulated.name,
        recorded=recorded.name,
        joints=recorded.robot.joints,
        offset=offset,
        duration=float(np.ptp(recorded_run.motion.time)),
        filter_hz=recorded_run.decimation.cutoff,
        mismatch={
            name: _mismatch(
                name, recorded, values_of(simulated_run), values_of(recorded_run), mask, level, axes
            )
            for name, values_of, mask, level in series
        },
        warnings=(
            *_warnings(simulated, recorded, effort),
            *([f"{recorded.name}: {SMOOTH}"] if smoothed else []),
        ),
    )


def _side_by_side(
    simulated: Recording, recorded: Recording, offset: float, fit: Fit | None
) -> tuple[str, Prepared, Prepared]:
    """The effort to compare, and two recordings in their overlap on the time axis of the recorded one.

    The effort is "current" if both recordings have it, else "torque", computed with nominal drive gains if
    there is only current.
    """
    if simulated.robot.joints != recorded.robot.joints:
        raise DifferentRobot(
            f"{simulated.name} has joints {', '.join(simulated.robot.joints)}, {recorded.name} has "
            f"{', '.join(recorded.robot.joints)}; give the joints the same names in the same order"
        )
    common = next((name for name in EFFORT if name in simulated.signals and name in recorded.signals), None)
    effort = common or "torque"
    # Velocities are differentiated from positions with the same filter for both.
    excluded = {"velocity"} | (set(EFFORT) - {common} if common else set())
    runs = [_without(simulated, excluded, offset), _without(recorded, excluded)]
    if fit:
        filtering = fit.filtering
    else:  # frequencies beyond the sampling of one run are no mismatch
        chosen = [choose(run, Filtering()) for run in runs]
        filtering = Filtering(
            position_cutoff=min(each.position_cutoff or np.inf for each in chosen),
            torque_cutoff=min(each.torque_cutoff or np.inf for each in chosen),
        )
    simulated_run, recorded_run = (_as_effort(prepare(run, filtering), run, effort) for run in runs)
    if fit and (level := fit.noise_of(effort)) is not None:
        recorded_run = replace(recorded_run, noise=level, noise_source=fit.noise_source)
    return effort, *_overlapping(simulated_run, recorded_run)


def _without(recording: Recording, names: set[str], offset: float = 0.0) -> Recording:
    """The recording without some signals, delayed by an offset [s]."""
    signals = {
        name: replace(signal, time=signal.time + offset)
        for name, signal in recording.signals.items()
        if name not in names
    }
    return replace(recording, signals=signals, host_time=None if offset else recording.host_time)


def _as_effort(run: Prepared, recording: Recording, effort: str) -> Prepared:
    """The run, with its current converted to joint torque [N m] if torque is compared."""
    if run.measures == effort:
        return run
    torque = (run.current * run.gain) @ recording.robot.coupling
    return replace(run, current=torque, noise=np.abs(run.gain) * run.noise, measures=effort)


def _overlapping(simulated: Prepared, recorded: Prepared) -> tuple[Prepared, Prepared]:
    """Both runs in their overlap, on the time axis of the recorded one."""
    time = recorded.motion.time
    first, last = simulated.motion.time[[0, -1]]
    overlap = (time >= first) & (time <= last)
    rate = recorded.decimation.rate
    if np.count_nonzero(overlap) < 2 * len(recorded.decimation.taps):
        raise RecordingError(
            f"{simulated.name} and {recorded.name} overlap for {np.count_nonzero(overlap) / rate:.2f} s, but "
            f"filters at {recorded.decimation.cutoff:.3g} Hz need "
            f"{2 * len(recorded.decimation.taps) / rate:.1f} s; state the offset "
            "between their clocks with --offset"
        )
    recorded = replace(
        recorded,
        motion=recorded.motion[overlap],
        current=recorded.current[overlap],
        sliding=recorded.sliding[overlap],
    )

    def interpolate(values: np.ndarray) -> np.ndarray:
        return CubicSpline(simulated.motion.time, values)(time[overlap])

    motion = replace(
        recorded.motion,
        position=interpolate(simulated.motion.position),
        velocity=interpolate(simulated.motion.velocity),
    )
    current = interpolate(simulated.current)
    return replace(
        recorded, name=simulated.name, motion=motion, current=current, noise=simulated.noise
    ), recorded


def _mismatch(
    quantity: str,
    recording: Recording,
    simulated: np.ndarray,
    reference: np.ndarray,
    mask: np.ndarray,
    noise: np.ndarray,
    axes: Mapping[str, np.ndarray],
) -> Mismatch:
    difference = np.where(mask, simulated - reference, np.nan)
    reference = np.where(mask, reference, np.nan)
    return Mismatch(
        quantity=quantity,
        units=recording.robot.units(SIGNALS[quantity]),
        rms=_rms(difference),
        mean=_mean(difference),
        size=_rms(reference - _mean(reference)),
        noise=noise,
        regions={name: _regions(difference, axis) for name, axis in axes.items()},
    )


def _regions(difference: np.ndarray, axis: np.ndarray) -> Regions:
    """Thirds of an axis (r, n), and the RMS of a difference (r, n) in each."""
    n = difference.shape[1]
    edges, rms = np.full((n, THIRDS + 1), np.nan), np.full((n, THIRDS), np.nan)
    for joint in range(n):
        known = np.isfinite(difference[:, joint]) & np.isfinite(axis[:, joint])
        if np.count_nonzero(known) < THIRDS:
            continue
        values, coordinates = difference[known, joint, None], axis[known, joint]
        edges[joint] = np.quantile(coordinates, np.linspace(0.0, 1.0, THIRDS + 1))
        region = np.searchsorted(edges[joint, 1:-1], coordinates, side="right")
        rms[joint] = [_rms(values[region == third])[0] for third in range(THIRDS)]
    return Regions(edges, rms)


def _mean(values: np.ndarray) -> np.ndarray:
    """Mean of the finite values, shape (n,); NaN where there are none."""
    finite = np.isfinite(values)
    count = finite.sum(axis=0)
    return np.where(count, np.where(finite, values, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan)


def _rms(values: np.ndarray) -> np.ndarray:
    return np.sqrt(_mean(values**2))


def _warnings(simulated: Recording, recorded: Recording, effort: str) -> list[str]:
    """Warnings about other differences."""
    warnings = []
    if simulated.payload != recorded.payload:
        words = [
            "no payload"
            if run.payload is None
            else ", ".join([run.payload.name, *(f"{name} {value:g}" for name, value in run.payload.known)])
            for run in (simulated, recorded)
        ]
        warnings.append(f"{simulated.name} carries {words[0]}, but {recorded.name} carries {words[1]}")
    for run in (simulated, recorded):
        if effort == "torque" and "torque" not in run.signals and np.all(run.robot.drive_gain == 1.0):
            warnings.append(f"{run.name} has currents, but no drive gain that converts them to torque")
    return warnings
