"""Where two recordings of one motion differ behind the same filters, by joint and by region of the motion."""

from collections.abc import Callable, Mapping, Sequence
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
"""Regions of each kind, with as many samples each: low, middle and high."""
SMOOTH = "it was smoothed before it was recorded, so that the noise of the motion is not known"
NAMES = ("low", "middle", "high")
"""Of the regions."""


@dataclass(frozen=True, eq=False)
class Regions:
    """Mismatch of one quantity in thirds of what the recorded arm did.

    Attributes:
        edges: Bounds of the thirds, shape (n, 4); speed [rad/s], position [rad], effort [A] or [N m].
        rms: In each third, shape (n, 3).
    """

    edges: np.ndarray
    rms: np.ndarray


@dataclass(frozen=True, eq=False)
class Mismatch:
    """How far two recordings differ in one quantity, root mean squares.

    Attributes:
        quantity: "position", "velocity", "current" or "torque".
        units: One a joint.
        rms: Root mean square of simulated less recorded, shape (n,).
        mean: Mean of simulated less recorded, shape (n,).
        size: Size of what was recorded, about its mean, shape (n,).
        noise: Noise of both recordings together behind the filter, shape (n,); NaN where it is not known.
        regions: "speed", "position" and "load", the size of the recorded effort.
    """

    quantity: str
    units: tuple[str, ...]
    rms: np.ndarray
    mean: np.ndarray
    size: np.ndarray
    noise: np.ndarray
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
    """Two recordings beside each other.

    Attributes:
        simulated: Name of the first.
        recorded: Name of the second, which is the reference.
        joints: Names.
        offset: What was added to the time of the first [s].
        duration: How long both go on [s].
        filter_hz: Cut-off frequency of the low-pass behind which both are compared [Hz].
        mismatch: Position, velocity, and current or torque, by the name of the quantity.
        warnings: What else differs, in sentences.
    """

    simulated: str
    recorded: str
    joints: tuple[str, ...]
    offset: Number
    duration: SizeNumber
    filter_hz: SizeNumber
    mismatch: Mapping[str, Mismatch]
    warnings: tuple[str, ...] = ()

    @property
    def effort(self) -> Mismatch:
        """That of current or torque."""
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
    """Compare two recordings behind the same filters, those and the noise level of a fit if it is given.

    Effort is compared while a joint slides: what holds one that sticks is unknown. The offset [s] is added to
    the time of the first.

    Raises:
        DifferentRobot: Not the same joints.
        RecordingError: No time in common, or too short for filters.
    """
    effort, theirs, ours = _side_by_side(simulated, recorded, offset, fit)
    unknown = np.full(ours.noise.shape, np.nan)
    smoothed = ours.noise_source in SMOOTHED_SOURCES
    noise = unknown if smoothed else np.hypot(theirs.noise, ours.noise)
    slides = ours.weight > 0
    everywhere = np.ones_like(slides)
    axes = {
        "speed": np.abs(ours.decimation.apply(ours.motion.velocity)),
        "position": ours.decimation.apply(ours.motion.position),
        "load": np.abs(ours.decimated_current),
    }
    series: tuple[tuple[str, Callable[[Prepared], np.ndarray], np.ndarray, np.ndarray], ...] = (
        ("position", lambda run: run.decimation.apply(run.motion.position), everywhere, unknown),
        ("velocity", lambda run: run.decimation.apply(run.motion.velocity), everywhere, unknown),
        (effort, lambda run: run.decimated_current, slides, noise),
    )
    return Comparison(
        simulated=simulated.name,
        recorded=recorded.name,
        joints=recorded.robot.joints,
        offset=offset,
        duration=float(np.ptp(ours.motion.time)),
        filter_hz=ours.decimation.cutoff,
        mismatch={
            name: _mismatch(name, recorded, of(theirs), of(ours), kept, floor, axes)
            for name, of, kept, floor in series
        },
        warnings=(
            *_warnings(simulated, recorded, effort),
            *([f"{recorded.name}: {SMOOTH}"] if smoothed else []),
        ),
    )


def _side_by_side(
    simulated: Recording, recorded: Recording, offset: float, fit: Fit | None
) -> tuple[str, Prepared, Prepared]:
    """Two recordings on the time axis of the second, where both go on, and what effort both have.

    That is "current" where both were recorded with it, else "torque", by nominal drive gains where there is
    only current.
    """
    if simulated.robot.joints != recorded.robot.joints:
        raise DifferentRobot(
            f"{simulated.name} is of {', '.join(simulated.robot.joints)}, {recorded.name} of "
            f"{', '.join(recorded.robot.joints)}; give the joints the same names in the same order"
        )
    common = next((name for name in EFFORT if name in simulated.signals and name in recorded.signals), None)
    effort = common or "torque"
    # Velocities are made from positions, by one filter for both.
    left_out = {"velocity"} | (set(EFFORT) - {common} if common else set())
    runs = [_without(simulated, left_out, offset), _without(recorded, left_out)]
    filtering = fit.filtering if fit else _narrower(runs)
    theirs, ours = (_as_effort(prepare(run, filtering), run, effort) for run in runs)
    if fit and (level := fit.noise_of(effort)) is not None:
        ours = replace(ours, noise=level, noise_source=fit.noise_source)
    return effort, *_together(theirs, ours)


def _without(recording: Recording, names: set[str], offset: float = 0.0) -> Recording:
    """The recording without some signals, later by an offset [s]."""
    signals = {
        name: replace(signal, time=signal.time + offset)
        for name, signal in recording.signals.items()
        if name not in names
    }
    return replace(recording, signals=signals, host_time=None if offset else recording.host_time)


def _narrower(runs: Sequence[Recording]) -> Filtering:
    """Cut-offs that all can have: what one of them is too slow for is no mismatch."""
    chosen = [choose(run, Filtering()) for run in runs]
    return Filtering(
        position_cutoff=min(one.position_cutoff or np.inf for one in chosen),
        torque_cutoff=min(one.torque_cutoff or np.inf for one in chosen),
    )


def _as_effort(run: Prepared, recording: Recording, effort: str) -> Prepared:
    """The run with joint torque [N m] in place of its current, where torque is asked for."""
    if run.measures == effort:
        return run
    torque = (run.current * run.gain) @ recording.robot.coupling
    return replace(run, current=torque, noise=np.abs(run.gain) * run.noise, measures=effort)


def _together(theirs: Prepared, ours: Prepared) -> tuple[Prepared, Prepared]:
    """Both on our time axis, where both go on."""
    time = ours.motion.time
    first, last = theirs.motion.time[[0, -1]]
    both = (time >= first) & (time <= last)
    if np.count_nonzero(both) < 2 * len(ours.decimation.taps):
        raise RecordingError(
            f"{theirs.name} and {ours.name} have {np.count_nonzero(both) / ours.decimation.rate:.2f} s in "
            f"common, filters at {ours.decimation.cutoff:.3g} Hz need "
            f"{2 * len(ours.decimation.taps) / ours.decimation.rate:.1f} s; state how far apart their clocks "
            "are (--offset)"
        )
    ours = replace(ours, motion=ours.motion[both], current=ours.current[both], sliding=ours.sliding[both])

    def there(values: np.ndarray) -> np.ndarray:
        return CubicSpline(theirs.motion.time, values)(time[both])

    motion = replace(
        ours.motion, position=there(theirs.motion.position), velocity=there(theirs.motion.velocity)
    )
    current = there(theirs.current)
    return replace(ours, name=theirs.name, motion=motion, current=current, noise=theirs.noise), ours


def _mismatch(
    quantity: str,
    recording: Recording,
    theirs: np.ndarray,
    ours: np.ndarray,
    kept: np.ndarray,
    noise: np.ndarray,
    axes: Mapping[str, np.ndarray],
) -> Mismatch:
    difference = np.where(kept, theirs - ours, np.nan)
    ours = np.where(kept, ours, np.nan)
    return Mismatch(
        quantity=quantity,
        units=recording.robot.units(SIGNALS[quantity]),
        rms=_rms(difference),
        mean=_mean(difference),
        size=_rms(ours - _mean(ours)),
        noise=noise,
        regions={name: _regions(difference, axis) for name, axis in axes.items()},
    )


def _regions(difference: np.ndarray, axis: np.ndarray) -> Regions:
    """Thirds of an axis (r, n), and the root mean square of a difference (r, n) in each."""
    n = difference.shape[1]
    edges, rms = np.full((n, THIRDS + 1), np.nan), np.full((n, THIRDS), np.nan)
    for joint in range(n):
        known = np.isfinite(difference[:, joint]) & np.isfinite(axis[:, joint])
        if np.count_nonzero(known) < THIRDS:
            continue
        values, along = difference[known, joint, None], axis[known, joint]
        edges[joint] = np.quantile(along, np.linspace(0.0, 1.0, THIRDS + 1))
        place = np.searchsorted(edges[joint, 1:-1], along, side="right")
        rms[joint] = [_rms(values[place == third])[0] for third in range(THIRDS)]
    return Regions(edges, rms)


def _mean(values: np.ndarray) -> np.ndarray:
    """Mean of what is known, shape (n,); NaN where nothing is."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    return np.where(count, np.where(known, values, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan)


def _rms(values: np.ndarray) -> np.ndarray:
    return np.sqrt(_mean(values**2))


def _warnings(simulated: Recording, recorded: Recording, effort: str) -> list[str]:
    """What else differs."""
    warnings = []
    if simulated.payload != recorded.payload:
        words = [
            "nothing"
            if run.payload is None
            else ", ".join([run.payload.name, *(f"{name} {value:g}" for name, value in run.payload.known)])
            for run in (simulated, recorded)
        ]
        warnings.append(f"{simulated.name} carries {words[0]}, {recorded.name} carries {words[1]}")
    for run in (simulated, recorded):
        if effort == "torque" and "torque" not in run.signals and np.all(run.robot.drive_gain == 1.0):
            warnings.append(f"{run.name} has currents, and no drive gain that converts them to torque")
    return warnings
