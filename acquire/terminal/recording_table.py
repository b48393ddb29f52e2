"""What is inside a recording as a plain table, for JSON."""

from typing import Any

import numpy as np

from exidyn.identify.effects import EFFECTS
from exidyn.identify.recordings.recording import SIGNALS, Recording, Signal
from exidyn.identify.recordings.run_log import Timing

from .json_output import plain


def recording_table(recording: Recording) -> dict[str, Any]:
    """Robot, signals, payload, settings, course and doubts; what is no number is None."""
    names = {kind: name for name, kind in EFFECTS.items()}
    payload, effects = recording.payload, recording.model.effects
    return plain(
        {
            "name": recording.name,
            "robot": recording.robot.name,
            "joints": list(recording.robot.joints),
            "effects": list(dict.fromkeys(names[type(effect)] for effect in effects)),
            "duration": recording.duration,
            "payload": payload and {"name": payload.name, "known": dict(payload.known)},
            "trajectory": bool(recording.trajectory),
            "settings": dict(recording.settings),
            "signals": {name: _signal(name, signal) for name, signal in recording.signals.items()},
            "cycles": None if recording.timing is None else _cycles(recording.timing),
            "events": [
                {"time": event.time, "kind": event.kind, "text": event.text} for event in recording.events
            ],
            "outcome": dict(recording.outcome),
            "warnings": list(recording.warnings),
        }
    )


def _signal(name: str, signal: Signal) -> dict[str, Any]:
    """Unit, samples, rate, and the range of each joint."""
    known = [column[np.isfinite(column)] for column in signal.values.T]
    return {
        "unit": SIGNALS[name],
        "samples": len(signal),
        "rate_hz": float(signal.rate),
        "lower": [np.min(column, initial=np.inf) for column in known],
        "upper": [np.max(column, initial=-np.inf) for column in known],
    }


def _cycles(timing: Timing) -> dict[str, Any]:
    """How the clock of the run was kept; times in [s]."""
    late = np.percentile(timing.lateness, [50, 99, 100]) if len(timing) else np.full(3, np.nan)
    return {
        "cycles": len(timing),
        "skipped": int(timing.skipped.sum()),
        "lateness_p50": late[0],
        "lateness_p99": late[1],
        "lateness_max": late[2],
    }
