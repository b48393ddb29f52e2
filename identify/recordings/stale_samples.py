"""Samples in which a joint was silent, left out or filled in: what identification takes has no holes."""

from dataclasses import replace

import numpy as np

from .recording import Recording, Signal

SLOW = ("temperature",)
"""Signals that change over minutes: controllers ask one motor after another, and what is asked in the next
tenth of a second may be taken for now."""


def without_stale(recording: Recording) -> Recording:
    """The recording without samples that lack a joint, and with a warning that gives their number and joints.

    What the other joints sent in the same cycle is left out with them: dynamics couples the joints, so that a
    row with a hole is of no use, and one that was filled in would pretend to have been measured. A joint
    that never sent a value is left for `recording_checks.check` to judge.
    """
    filled, fresh, warnings = {}, {}, []
    for name, signal in recording.signals.items():
        silent = np.isnan(signal.values)
        silent[:, silent.all(axis=0)] = False
        stale = silent.any(axis=1)
        if name in SLOW:
            filled[name] = _filled(signal) if stale.any() else signal
            continue
        fresh[name] = ~stale
        if np.isfinite(signal.values[stale]).any():
            warnings.append(_warning(recording, name, silent, stale))
    whole = replace(recording, signals={**recording.signals, **filled})
    return whole.keeping(fresh).with_warnings(*warnings)


def _filled(signal: Signal) -> Signal:
    """A straight line between the samples of a joint before and after."""
    values = np.array(signal.values)
    for column in values.T:
        known = np.isfinite(column)
        if known.any():
            column[:] = np.interp(signal.time, signal.time[known], column[known])
    return Signal(signal.time, values)


def _warning(recording: Recording, name: str, silent: np.ndarray, stale: np.ndarray) -> str:
    joints = [
        f"{joint} in {count}"
        for joint, count in zip(recording.robot.joints, silent.sum(axis=0), strict=True)
        if count
    ]
    return (
        f"{name}: a joint was silent in {stale.sum()} of {len(stale)} samples ({', '.join(joints)}); they "
        "are left out"
    )
