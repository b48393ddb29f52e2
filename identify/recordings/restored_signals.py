"""Restoration of the signals of a recording: lost turns and signs, repeated samples, saturated positions."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from scipy.integrate import cumulative_trapezoid

from .incomplete_samples import is_number
from .misread_columns import GRIPPERS, Restored, in_ticks, signed, signed_like, unwrapped
from .recording import EFFORT, Recording, Signal

REPEATED = 0.3
"""Share of samples that repeat the previous one in all joints above which a log outpaces its sensor."""
REGULAR = 0.8
"""Minimum share of the stretches of repeats with the usual length: unlike rest, a sensor has a rate."""
DERIVED = 0.9
"""Minimum correlation of a velocity with the derivative of its position; filters reduce it only slightly."""
SCALED = 0.1
"""Relative error of their ratio above which their units differ."""
FEWEST = 100
"""Minimum number of samples to detect repeated samples, and to compare a velocity."""
HELD = 3
"""Minimum number of consecutive samples at exactly the extreme value; a crest is approached slowly."""
ABRUPT = 4.0
"""Change of speed within one sample, over the joint's usual changes, that no motor can cause."""
APART = (1, 2, 5)
"""Numbers of samples over which speeds are computed: many average noise, few resolve an abrupt stop."""
USUAL = 99.0
"""Percentile of the usual changes of speed."""


def restored(recording: Recording) -> Recording:
    """Recording with restored signals, and a warning about each restoration."""
    signals, warnings = dict(recording.signals), []
    for name in ("position", "velocity", *EFFORT):
        if name in signals:
            eligible = recording.robot.revolute if name == "position" else np.ones(recording.robot.dof, bool)
            restore = _position if name == "position" else signed
            signals[name], facts = _restored(signals[name], recording.robot.joints, eligible, restore)
            warnings += [f"{name} of {fact}" for fact in facts]
    for name in ("position", *EFFORT):
        if name in signals and (new := _new_samples(signals[name])) is not None:
            rate = 1.0 / np.median(np.diff(signals[name].time[new]))
            warnings.append(
                f"{name}: {100 * np.mean(~new):.0f} % of the samples repeat the one before; only new ones "
                f"are used, at {rate:.3g} Hz"
            )
            signals[name] = Signal(signals[name].time[new], signals[name].values[new])
    complete = replace(recording, signals=signals)
    return complete.with_warnings(*warnings, *_velocity(complete))


def _restored(
    signal: Signal,
    joints: tuple[str, ...],
    eligible: np.ndarray,
    restore: Callable[..., Restored | None],
) -> tuple[Signal, list[str]]:
    """Signal with the eligible joints (n,) restored, and the facts about them."""
    values, facts = np.array(signal.values), list[str]()
    tried = {j: restore(values[:, j]) for j in np.flatnonzero(eligible).tolist()}
    for turn in {restored.turn for restored in tried.values() if restored is not None}:
        tried = {j: restored or signed_like(values[:, j], turn) for j, restored in tried.items()}
    better = {j: restored for j, restored in tried.items() if restored is not None}
    for fact in dict.fromkeys(restored.fact for restored in better.values()):
        alike = [j for j in better if better[j].fact == fact]
        values[:, alike] = np.stack([better[j].values for j in alike], axis=1)
        facts.append(f"{', '.join(joints[j] for j in alike)} {fact}")
    return (Signal(signal.time, values), facts) if facts else (signal, facts)


def _position(values: np.ndarray) -> Restored | None:
    """Positions (t,) without jumps by a turn, or with the sign of their register; None if nothing was lost.

    Counts of an encoder stay unchanged, and are reported as a wrong unit.
    """
    return unwrapped(values) or (None if in_ticks(values) else signed(values))


def _new_samples(signal: Signal) -> np.ndarray | None:
    """Whether samples (t,) are new, if many repeat the previous one at a regular rate; else None."""
    if len(signal) < FEWEST:
        return None
    changed = np.any(np.diff(signal.values, axis=0) != 0.0, axis=1)
    new = np.concatenate([[True], changed])
    if np.mean(~new) < REPEATED or new.sum() < FEWEST:
        return None
    lengths = np.diff(np.flatnonzero(new))
    usual = int(np.median(lengths))
    return new if usual > 1 and np.mean(np.abs(lengths - usual) <= 1) >= REGULAR else None


def _velocity(recording: Recording) -> Iterator[str]:
    """Warnings about velocities that are not the derivative of their position."""
    position, velocity = recording.signals["position"], recording.signals.get("velocity")
    if velocity is None or min(len(position), len(velocity)) < FEWEST:
        return
    for j, joint in enumerate(recording.robot.joints):
        if not np.isfinite(velocity.values[:, j]).all():
            continue
        ratio, correlation = _slope(position, velocity, j)
        if abs(correlation) < DERIVED:
            yield f"velocity of {joint} is not the derivative of its position (correlation {correlation:.2g})"
        elif abs(ratio - 1.0) > SCALED:
            degrees = abs(ratio * np.pi / 180 - 1.0) < SCALED
            unit = ": in deg/s? Give [velocity] unit" if degrees else ""
            yield f"velocity of {joint} is {ratio:.3g} times the derivative of its position{unit}"


def _slope(position: Signal, velocity: Signal, joint: int) -> tuple[float, float]:
    """Velocity over the derivative of position, and their correlation; (1, 1) if the joint rests.

    Both are means over a twentieth of a second or some samples, since single derivatives are noise.
    """
    span = max(0.05, 8 * position.period)
    edges = np.arange(position.time[0], position.time[-1], span)
    if len(edges) < 20:
        return 1.0, 1.0
    derivative = np.diff(np.interp(edges, position.time, position.values[:, joint])) / span
    area = cumulative_trapezoid(velocity.values[:, joint], velocity.time, initial=0.0)
    mean = np.diff(np.interp(edges, velocity.time, area)) / span
    size = np.sqrt(derivative @ derivative * (mean @ mean))
    if not np.ptp(position.values[:, joint]) > 0.01 or size == 0.0:
        return 1.0, 1.0
    return float(mean @ derivative / (derivative @ derivative)), float(mean @ derivative / size)


def without_saturated(recording: Recording) -> Recording:
    """Recording without samples whose position saturates, and with a warning about each such joint."""
    position = recording.signals["position"]
    valid, warnings = np.ones(len(position), bool), []
    for joint, column in zip(recording.robot.joints, position.values.T, strict=True):
        if GRIPPERS.search(joint):
            continue  # it stops abruptly at its ends
        held = saturated(column)
        for extreme in np.unique(column[held]):
            count = int(np.sum(column[held] == extreme))
            warnings.append(
                f"position: {joint} is held at exactly {extreme:g} in {count} samples, "
                "though it moves fast before and after them: it is clipped there; they are left out"
            )
        valid &= ~held
    if not warnings:
        return recording
    rows = {
        name: valid
        for name, signal in recording.signals.items()
        if np.array_equal(signal.time, position.time)
    }
    return recording.keeping(rows).with_warnings(*warnings)


def saturated(column: np.ndarray) -> np.ndarray:
    """Whether positions (t,) are held at their highest or lowest value by a register and not by a drive."""
    held = np.zeros(len(column), bool)
    if len(column) < 10 * HELD or not is_number(column).all():
        return held
    runs = [run for extreme in (column.min(), column.max()) for run in _runs(column == extreme)]
    for apart in APART if runs else ():
        turns = np.abs(column[2 * apart :] - 2 * column[apart:-apart] + column[: -2 * apart])
        for start, stop in runs:  # excludes the stops in question
            turns[max(start - 2 * apart, 0) : stop + 1] = np.nan
        usual = float(np.nanpercentile(turns, USUAL)) if np.isfinite(turns).any() else np.inf
        for start, stop in runs:
            if apart <= start - 1 and stop + apart < len(column):
                steps = column[start - 1] - column[start - 1 - apart], column[stop + apart] - column[stop]
                held[start:stop] |= min(np.abs(steps)) > ABRUPT * usual > 0.0
    return np.isin(column, np.unique(column[held]))  # other samples at that value are clipped too


def _runs(extreme: np.ndarray) -> list[tuple[int, int]]:
    """Beginnings and ends of stretches that are extreme, bool (t,), and long enough."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], extreme, [0]])))
    pairs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return [(start, stop) for start, stop in pairs if stop - start >= HELD]
