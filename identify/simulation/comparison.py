"""Comparison: where two recordings of one motion differ, by joint and by region of the motion."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..fit.fit import Fit
from ..preparation.prepare import SMOOTHED_SOURCES, Prepared
from ..recordings.recording import SIGNALS, Recording
from .side_by_side import side_by_side

THIRDS = 3
"""Regions of each kind, with as many samples each: low, middle and high."""
SMOOTH = "it was smoothed before it was recorded, so that the noise of the motion is not known"
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
        recorded: Name of the second, which is the reference.
        joints: Names.
        offset: What was added to the time of the first [s].
        duration: How long both go on [s].
        cutoff: Of the low-pass behind which both are compared [Hz].
        mismatches: Position, velocity, and current or torque.
        warnings: What else differs, in sentences.
    """

    simulated: str
    recorded: str
    joints: tuple[str, ...]
    offset: float
    duration: float
    cutoff: float
    mismatches: tuple[Mismatch, ...]
    warnings: tuple[str, ...] = ()

    @property
    def effort(self) -> Mismatch:
        """That of current or torque."""
        return self.mismatches[-1]


def compare(
    simulated: Recording, recorded: Recording, offset: float = 0.0, fit: Fit | None = None
) -> Comparison:
    """Compare two recordings behind the same filters.

    Effort is compared while a joint slides: what holds one that sticks is unknown.

    Args:
        simulated: Of any simulator, or another run.
        recorded: Of the same joints.
        offset: To be added to the time of the first [s].
        fit: Whose filters and noise level are taken; by default those of the two.

    Raises:
        DifferentRobot: Not the same joints.
        RecordingError: No time in common, or too short for filters.
    """
    effort, theirs, ours = side_by_side(simulated, recorded, offset, fit)
    noise = np.hypot(theirs.noise, ours.noise)
    unknown_noise = ours.noise_source in SMOOTHED_SOURCES
    smooth = [f"{recorded.name}: {SMOOTH}"] if unknown_noise else []
    if unknown_noise:
        noise = np.full(noise.shape, np.nan)
    slides = ours.weight > 0
    everywhere = np.ones_like(slides)
    axes = _axes(ours)
    unknown = np.full(noise.shape, np.nan)
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
        cutoff=ours.decimation.cutoff,
        mismatches=tuple(
            _mismatch(name, recorded, of(theirs), of(ours), kept, floor, axes)
            for name, of, kept, floor in series
        ),
        warnings=(*_warnings(simulated, recorded, effort), *smooth),
    )


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
