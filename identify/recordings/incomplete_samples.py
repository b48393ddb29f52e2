"""Samples that lack a joint, a number or a valid time: they are left out, with a warning.

Dynamics couples the joints, so a sample that lacks a joint is of no use, and a sample that was filled in
would pretend to have been measured. Of signals that identification does not need, damaged joints are left
out.
"""

from dataclasses import replace

import numpy as np

from ..errors import NotFinite
from .recording import EFFORT, Recording, Signal

NEEDED = ("position", *EFFORT)
"""Signals that identification needs; damage in them is an error."""
TAKEN_SLOWLY = ("temperature",)
"""Signals that change over minutes: controllers ask one motor after another, and what is asked in the next
tenth of a second may be taken for now."""
LARGEST = 1e15
"""Maximum magnitude of any signal in any unit, whose square is still finite."""


def finite(column: np.ndarray) -> np.ndarray:
    """Values of a column that are numbers."""
    return column[is_number(column)]


def is_number(values: np.ndarray) -> np.ndarray:
    """Whether values are finite numbers below `LARGEST`, bool of the same shape."""
    return np.abs(values) < LARGEST  # false for NaN and infinity


def without_silence(recording: Recording) -> Recording:
    """Drop samples in which a signal is NaN on all joints: the controller sent nothing then."""
    return recording.keeping(
        {name: ~np.isnan(signal.values).all(axis=1) for name, signal in recording.signals.items()}
    )


def without_impossible(recording: Recording) -> Recording:
    """Drop samples in which a joint is not a number, if it is one elsewhere, or whose time goes back."""
    valid, warnings = {}, []
    for name, signal in recording.signals.items():
        known = is_number(signal.values)
        known[:, ~known.any(axis=0)] = True
        last_time = np.maximum.accumulate(np.concatenate([[-np.inf], signal.time]))[:-1]
        used = valid[name] = known.all(axis=1) & (signal.time > last_time)
        if not used.all():
            warnings.append(
                f"{name}: {np.sum(~used)} of {len(used)} samples have a joint that is not a number or a time "
                "that goes back; they are left out"
            )
    return recording.keeping(valid).with_warnings(*warnings)


def without_repeats(recording: Recording) -> Recording:
    """Recording without samples that repeat time and values of the one before, and with a warning."""
    new, warnings = {}, []
    for name, signal in recording.signals.items():
        same = (np.diff(signal.time) == 0.0) & np.all(np.diff(signal.values, axis=0) == 0.0, axis=1)
        new[name] = np.concatenate([[True], ~same]) if len(signal) else np.ones(0, bool)
        if same.any():
            warnings.append(f"{name}: {same.sum()} of {len(signal)} samples are written twice; one is used")
    return recording.keeping(new).with_warnings(*warnings)


def without_incomplete(recording: Recording, where: str) -> Recording:
    """The recording without samples of positions and efforts that lack a joint; a warning counts them.

    A joint without any number is handled by the checks. `where` is the name of the log in messages.
    """
    complete, warnings = {}, []
    for name in (name for name in NEEDED if name in recording.signals):
        values = recording.signals[name].values
        lost = np.isnan(values)
        lost &= ~lost.all(axis=0) & ~lost.all(axis=1)[:, None]
        complete[name] = ~lost.any(axis=1)
        if complete[name].all():
            continue
        count = int(np.sum(complete[name] & ~np.isnan(values).all(axis=1)))
        facts = f"{name}: no number for {_by_joint(recording, lost)} of {len(values)} rows"
        if count < 2:
            raise NotFinite(
                f"{where}: {facts}, and {count} with all joints; a sample needs all joints in one row"
            )
        warnings.append(f"{facts}; these {np.sum(~complete[name])} rows are left out")
    return recording.keeping(complete).with_warnings(*warnings)


def without_stale(recording: Recording) -> Recording:
    """The recording without samples in which a joint was silent, and with a warning that counts them.

    A joint that never sent a value is handled by the checks.
    """
    filled, fresh, warnings = {}, {}, []
    for name, signal in recording.signals.items():
        silent = np.isnan(signal.values)
        silent[:, silent.all(axis=0)] = False
        stale = silent.any(axis=1)
        if name in TAKEN_SLOWLY:
            filled[name] = _filled(signal) if stale.any() else signal
            continue
        fresh[name] = ~stale
        if np.isfinite(signal.values[stale]).any():
            warnings.append(
                f"{name}: a joint was silent in {stale.sum()} of {len(stale)} samples "
                f"({_by_joint(recording, silent)}); they are left out"
            )
    complete = replace(recording, signals={**recording.signals, **filled})
    return complete.keeping(fresh).with_warnings(*warnings)


def _filled(signal: Signal) -> Signal:
    """A straight line between the samples of a joint before and after."""
    values = np.array(signal.values)
    for column in values.T:
        known = np.isfinite(column)
        if known.any():
            column[:] = np.interp(signal.time, signal.time[known], column[known])
    return Signal(signal.time, values)


def _by_joint(recording: Recording, lost: np.ndarray) -> str:
    """Joints that some samples lack, bool (t, n), and their number of such samples."""
    counts = zip(recording.robot.joints, lost.sum(axis=0), strict=True)
    return ", ".join(f"{joint} in {count}" for joint, count in counts if count)


def without_damaged(recording: Recording) -> Recording:
    """Recording without joints of optional signals that are sometimes not a number, and with warnings."""
    signals, warnings = dict(recording.signals), []
    for name, signal in recording.signals.items():
        if name in NEEDED:
            continue
        silent = np.isnan(signal.values)
        bad = ~is_number(signal.values) & ~silent.all(axis=1)[:, None]
        damaged = bad.any(axis=0) & ~silent.all(axis=0)
        if not damaged.any():
            continue
        joints = [recording.robot.joints[joint] for joint in np.flatnonzero(damaged)]
        rows = bad[:, damaged].any(axis=1)
        warnings.append(
            f"{name} of {', '.join(joints)} is left out: no number in {rows.sum()} of {len(rows)} samples, "
            f"first at {float(signal.time[rows.argmax()]):.3f} s"
        )
        cleaned = Signal(signal.time, np.where(damaged, np.nan, signal.values))
        signals[name] = cleaned
        if np.isnan(cleaned.values).all():
            del signals[name]
    return replace(recording, signals=signals).with_warnings(*warnings)
