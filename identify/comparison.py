"""Comparison: where two recordings of one motion differ, by joint and by region of the motion."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from .errors import DifferentRobot, RecordingError
from .prepare import Filtering, Prepared, choose, prepare
from .recording import EFFORT, Recording

THIRDS = 3
"""Regions of each kind, with as many samples each: low, middle and high are told apart at a glance."""
NAMES = ("low", "middle", "high")
"""Of the regions."""


class Regions(NamedTuple):
    """Mismatch of one quantity in thirds of what the recorded arm did.

    Attributes:
        edges: Of the thirds, shape (n, 4); speed [rad/s], position [rad], size of the effort [A] or [N m].
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
        rms: Of simulated less recorded, shape (n,).
        mean: Of the same, shape (n,).
        size: Of what was recorded, about its mean, shape (n,).
        noise: Of both together behind the filter, shape (n,); NaN where it is not known.
        regions: "speed", "position" and "load", the size of the recorded effort.
    """

    quantity: str
    units: tuple[str, ...]
    rms: np.ndarray
    mean: np.ndarray
    size: np.ndarray
    noise: np.ndarray
    regions: Mapping[str, Regions]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Two recordings beside each other.

    Attributes:
        simulated: Name of the first.
        recorded: Name of the second, which is believed.
        joints: Names.
        offset: What was added to the time of the first [s].
        duration: How long both go on [s].
        cutoff: Of the low-pass behind which both are compared [Hz].
        mismatches: Position, velocity, and current or torque.
        doubts: What else differs, in sentences.
    """

    simulated: str
    recorded: str
    joints: tuple[str, ...]
    offset: float
    duration: float
    cutoff: float
    mismatches: tuple[Mismatch, ...]
    doubts: tuple[str, ...] = ()

    @property
    def effort(self) -> Mismatch:
        """That of current or torque."""
        return self.mismatches[-1]


def compare(simulated: Recording, recorded: Recording, offset: float = 0.0) -> Comparison:
    """Compare two recordings behind the same filters.

    Effort is compared while a joint slides: what holds one that sticks is anybody's guess. It is current
    where both have that, else torque, by believed drive gains where one has only current.

    Args:
        simulated: Of any simulator, or another run.
        recorded: Of the same joints.
        offset: To be added to the time of the first [s].

    Raises:
        DifferentRobot: Not the same joints.
        RecordingError: No time in common, or too short for filters.
    """
    if simulated.robot.joints != recorded.robot.joints:
        raise DifferentRobot(
            f"{simulated.name} is of {', '.join(simulated.robot.joints)}, {recorded.name} of "
            f"{', '.join(recorded.robot.joints)}; give the joints the same names in the same order"
        )
    effort, runs = _alike(_shifted(simulated, offset), recorded)
    filtering = _narrower(runs)
    theirs, ours = (_as_effort(prepare(run, filtering), run, effort) for run in runs)
    theirs, ours = _together(theirs, ours)
    noise = np.hypot(theirs.noise, ours.noise)
    slides = ours.weight > 0
    everywhere = np.ones_like(slides)
    axes = _axes(ours)
    series: tuple[tuple[str, Callable[[Prepared], np.ndarray], np.ndarray], ...] = (
        ("position", lambda run: run.decimation.apply(run.motion.position), everywhere),
        ("velocity", lambda run: run.decimation.apply(run.motion.velocity), everywhere),
        (effort, lambda run: run.decimated_current, slides),
    )
    return Comparison(
        simulated=simulated.name,
        recorded=recorded.name,
        joints=recorded.robot.joints,
        offset=offset,
        duration=float(np.ptp(ours.motion.time)),
        cutoff=ours.decimation.cutoff,
        mismatches=tuple(
            _mismatch(
                name,
                recorded,
                of(theirs),
                of(ours),
                kept,
                noise if name == effort else np.full(noise.shape, np.nan),
                axes,
            )
            for name, of, kept in series
        ),
        doubts=tuple(_doubts(simulated, recorded, effort)),
    )


def _shifted(recording: Recording, offset: float) -> Recording:
    signals = {name: replace(signal, time=signal.time + offset) for name, signal in recording.signals.items()}
    return replace(recording, signals=signals, host_time=None)


def _alike(first: Recording, second: Recording) -> tuple[str, tuple[Recording, Recording]]:
    """What effort is compared, and both recordings without the other kind where both have this one."""
    common = next((name for name in EFFORT if name in first.signals and name in second.signals), None)
    left_out = {"velocity"} | (set(EFFORT) - {common} if common else set())
    return common or "torque", (_without(first, left_out), _without(second, left_out))


def _without(recording: Recording, names: set[str]) -> Recording:
    """The recording without some signals; velocities are made from positions, by one filter for both."""
    kept = {name: signal for name, signal in recording.signals.items() if name not in names}
    return replace(recording, signals=kept)


def _narrower(runs: tuple[Recording, Recording]) -> Filtering:
    """Cut-offs that both can have: what one of them is too slow for is no mismatch."""
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
    """Both on our time axis, where both go on.

    Raises:
        RecordingError: That is nowhere, or too short for the filter.
    """
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
        return _spline(theirs.motion.time, values, time[both])

    motion = replace(
        ours.motion, position=there(theirs.motion.position), velocity=there(theirs.motion.velocity)
    )
    current = there(theirs.current)
    return replace(ours, name=theirs.name, motion=motion, current=current, noise=theirs.noise), ours


def _spline(time: np.ndarray, values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """A cubic spline through each column (t, n); NaN for one that was not measured."""
    known = np.isfinite(values).all(axis=0)
    found = np.full((len(at), values.shape[1]), np.nan)
    if known.any():
        found[:, known] = CubicSpline(time, values[:, known])(at)
    return found


def _axes(run: Prepared) -> dict[str, np.ndarray]:
    """What regions are made of, each (r, n)."""
    return {
        "speed": np.abs(run.decimation.apply(run.motion.velocity)),
        "position": run.decimation.apply(run.motion.position),
        "load": np.abs(run.decimated_current),
    }


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
        units=_units(quantity, recording),
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


def _units(quantity: str, recording: Recording) -> tuple[str, ...]:
    """The unit of each joint; those that slide have their own."""
    turning = {"position": "rad", "velocity": "rad/s", "current": "A", "torque": "N m"}[quantity]
    sliding = {"position": "m", "velocity": "m/s", "current": "A", "torque": "N"}[quantity]
    return tuple(turning if turns else sliding for turns in recording.robot.revolute)


def _doubts(simulated: Recording, recorded: Recording, effort: str) -> list[str]:
    """What else differs."""
    doubts = []
    if simulated.payload != recorded.payload:
        words = [
            "nothing"
            if run.payload is None
            else ", ".join([run.payload.name, *(f"{name} {value:g}" for name, value in run.payload.known)])
            for run in (simulated, recorded)
        ]
        doubts.append(f"{simulated.name} carries {words[0]}, {recorded.name} carries {words[1]}")
    for run in (simulated, recorded):
        if effort == "torque" and "torque" not in run.signals and np.all(run.robot.drive_gain == 1.0):
            doubts.append(f"{run.name} has currents, and no drive gain says what torque they give")
    return doubts
