"""Checks of efforts: whether they were measured at all, in every sample, and up to their extreme values."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..errors import NotRecorded
from ..schema import LARGEST
from .incomplete_samples import finite, is_number
from .recording import EFFORT, Recording, Signal
from .servo_error import is_servo_error

CLIPPED_SAMPLES = 20
"""Samples at exactly the extreme value from which on it is worth asking, 40 ms at 500 Hz."""
CLIPPED_CROWD = 10.0
"""How many times more samples lie at the extreme than at the values next to it. At the crest of a smooth
quantised signal it is at most five; a limiter collects everything that would have been beyond."""
UNREAD = 0.5
"""Share of samples in motion at one value from which on the value is the median, whatever the joint does."""
UNMEASURED = "efforts at one value in most samples in which their joint moves, as if they were not measured"
NO_MOTOR = "state the joint in robot.toml, [drive] passive"
WINDOW = 0.1
"""Time over which a joint's motion is looked at [s]; over less, the steps of an encoder look like rest."""
FEWEST = 50
"""Samples in motion, at least: of a few, most may well be alike."""
SLOW = 0.03
"""Share of a joint's usual speed below which it may as well rest."""


def effort_warnings(recording: Recording) -> Iterator[str]:
    """Warnings about efforts that were not measured, are clipped, or were not measured in every sample."""
    for name, signal in _efforts(recording):
        yield from _constant(recording, name, signal)
        if not is_servo_error(recording.settings):  # which is compared with the limit of the servo
            yield from _clipped(recording, name, signal)
        yield from _unread(recording, name, signal)


def check_alive(recording: Recording) -> Recording:
    """The recording, if every motor's current changes; a constant one would mean a weightless joint."""
    constant = [warning for effort in _efforts(recording) for warning in _constant(recording, *effort)]
    if constant:
        raise NotRecorded(
            f"{recording.name}: {'; '.join(constant)}. Identify from runs in which all are measured"
        )
    return recording


def _efforts(recording: Recording) -> list[tuple[str, Signal]]:
    """Names and signals of the efforts with at least two samples."""
    return [(name, recording.signals[name]) for name in EFFORT if len(recording.signals.get(name, ())) > 1]


def _constant(recording: Recording, name: str, signal: Signal) -> list[str]:
    """Warnings about motors whose effort does not change: one if it is so for all of them."""
    robot = recording.robot
    motors = ~np.isin(robot.joints, robot.passive)  # the effort of a joint without motor need not change
    if motors.any() and (words := unmeasured_words(signal.values[:, motors])):
        return [f"{name}: {words}"]
    warnings = []
    for joint, value in zip(robot.joints, still_at(signal.values), strict=True):
        if np.isfinite(value) and (value != 0.0 or joint not in robot.passive):
            cure = "" if value else f". If it has no motor: {NO_MOTOR}"
            warnings.append(
                f"{name}: {joint} is constant at {value + 0.0:g}; it was not measured, or the motor was off"
                f"{cure}"
            )
    return warnings


def still_at(values: np.ndarray) -> np.ndarray:
    """The value of each column (t, n) in all samples, shape (n,); NaN where it changes, or has none."""
    known = is_number(values)
    lowest = np.min(values, axis=0, where=known, initial=np.inf)
    highest = np.max(values, axis=0, where=known, initial=-np.inf)
    return np.where(lowest == highest, lowest, np.nan)


def unmeasured_words(values: np.ndarray) -> str:
    """That efforts (t, n) were not measured, as none of them ever changes; empty where any does."""
    still = still_at(values)
    if not len(still) or np.isnan(still).any():
        return ""
    how = f"{still[0] + 0.0:g}" if np.all(still == still[0]) else "constant"
    return f"no effort was measured: all efforts are {how} throughout"


def without_unmeasured(recording: Recording) -> Recording:
    """Recording without an effort that never changes beside another effort that does, and with a warning."""
    words = {name: unmeasured_words(signal.values) for name, signal in _efforts(recording)}
    if len(words) < 2 or all(words.values()) or not any(words.values()):
        return recording
    [silent] = [name for name, why in words.items() if why]
    signals = {name: signal for name, signal in recording.signals.items() if name != silent}
    return replace(recording, signals=signals).with_warnings(f"{silent} is left out: {words[silent]}")


def _clipped(recording: Recording, name: str, signal: Signal) -> Iterator[str]:
    """Warnings about efforts that stop at a limit."""
    for joint, values in zip(recording.robot.joints, signal.values.T, strict=True):
        column = finite(values)
        for extreme in (column.min(), column.max()) if len(column) and np.ptp(column) > 0 else ():
            if count := _clipped_samples(column, extreme):
                yield (
                    f"{name}: {joint} is at exactly {extreme:g} in {count} samples, more than "
                    f"{CLIPPED_CROWD:g} times as often as near it: it is clipped there"
                )


def _clipped_samples(column: np.ndarray, extreme: float) -> int:
    """Samples at an extreme value if they crowd there, else zero."""
    at = int((column == extreme).sum())
    if at < CLIPPED_SAMPLES:
        return 0
    order = np.sort(np.abs(column[column != extreme] - extreme))
    neighbours = np.unique(order[: 10 * at], return_counts=True)[1][:10]
    return at if at > CLIPPED_CROWD * neighbours.mean() else 0


def _unread(recording: Recording, name: str, signal: Signal) -> Iterator[str]:
    """Warning about efforts that stay at one value while their joint moves."""
    position = recording.signals["position"]
    if len(position) < 2:
        return
    shares = unread(signal.time, position.at(signal.time), signal.values)
    held = [
        f"{joint} in {100 * share:.0f} %"
        for joint, share in zip(recording.robot.joints, shares, strict=True)
        if 0.0 < share < 1.0
    ]
    if held:
        yield f"{name}: {UNMEASURED}: {', '.join(held)}"


def unread(time: np.ndarray, position: np.ndarray, effort: np.ndarray) -> np.ndarray:
    """Share of the samples in motion at which each effort has its most frequent value, shape (n,).

    It is zero for a joint that does not move, and up to `UNREAD`. Time (t,) is in seconds; positions and
    efforts (t, n) may be in any unit.
    """
    shares = [_share(time, column, measured) for column, measured in zip(position.T, effort.T, strict=True)]
    return np.where(np.array(shares) > UNREAD, shares, 0.0)


def _share(time: np.ndarray, position: np.ndarray, effort: np.ndarray) -> float:
    known = np.abs(position) < LARGEST
    if known.sum() < FEWEST:
        return 0.0
    later, before = (np.interp(time + x * WINDOW / 2, time[known], position[known]) for x in (1, -1))
    moved = np.abs(later - before)
    in_motion = (moved > SLOW * np.percentile(moved, 90)) & np.isfinite(effort)
    if in_motion.sum() < FEWEST:
        return 0.0
    return float(np.unique(effort[in_motion], return_counts=True)[1].max() / in_motion.sum())
