"""Optional signals of a recording, from which damaged joints are removed with a warning."""

from dataclasses import replace

import numpy as np

from .recording import EFFORT, Recording, Signal
from .recording_findings import is_number

NEEDED = ("position", *EFFORT)
"""Signals that identification needs; damage in them is an error."""


def without_damaged(recording: Recording) -> Recording:
    """Recording without joints of optional signals that are sometimes not a number, and with warnings."""
    signals, warnings = dict(recording.signals), []
    for name, signal in recording.signals.items():
        if name in NEEDED:
            continue
        damaged = _damaged(signal)
        if not damaged.any():
            continue
        joints = [recording.robot.joints[joint] for joint in np.flatnonzero(damaged)]
        warnings.append(_warning(name, joints, signal, damaged))
        cleaned = Signal(signal.time, np.where(damaged, np.nan, signal.values))
        signals[name] = cleaned
        if np.isnan(cleaned.values).all():
            del signals[name]
    return replace(recording, signals=signals).with_warnings(*warnings)


def _damaged(signal: Signal) -> np.ndarray:
    """Joints with a value that is not a number in samples in which any joint was measured, bool (n,)."""
    measured = ~np.isnan(signal.values).all(axis=1)
    bad = ~is_number(signal.values[measured])
    return bad.any(axis=0) & ~np.isnan(signal.values).all(axis=0)


def _warning(name: str, joints: list[str], signal: Signal, damaged: np.ndarray) -> str:
    bad = ~is_number(signal.values[:, damaged]).all(axis=1) & ~np.isnan(signal.values).all(axis=1)
    first = float(signal.time[bad.argmax()])
    return (
        f"{name} of {', '.join(joints)} is left out: no number in {bad.sum()} of {len(bad)} samples, "
        f"first at {first:.3f} s"
    )
