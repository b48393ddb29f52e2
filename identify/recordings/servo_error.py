"""Servo error: what stands for the current where a log has commands and positions, and no effort.

A position servo makes torque by its gain times what is left to its command, less its own damping, up to what
it can. So its error is to its gain what a current is to a drive gain. Its damping looks like friction.
"""

from collections.abc import Mapping

import numpy as np

from ..errors import RecordingError
from .recording import Signal

COMMAND = "command"
"""Kind of effort of such logs."""
WORDS = "servo error"
"""By which the settings of a recording say that its current is that."""


def with_servo_error(
    signals: Mapping[str, Signal], gain: float, limit: float, where: str
) -> dict[str, Signal]:
    """Signals with the servo error in place of any effort, as if it were a current.

    Args:
        signals: With position and command.
        gain: Of this run, over that of runs it goes together with, such as a register of the servo.
        limit: At which its torque is at its limit, `gain` included, either way; infinite for none.
        where: What errors call the log.

    Raises:
        RecordingError: No command, or one that never differs from the position.
    """
    if "command" not in signals:
        raise RecordingError(
            f"{where} has no commanded position, which --effort {COMMAND} needs; name its columns by "
            "--columns command=NAME,NAME,..."
        )
    position, command = signals["position"], signals["command"]
    asked = np.stack([np.interp(position.time, command.time, column) for column in command.values.T], axis=1)
    error = gain * (asked - position.values)
    if not np.any(np.abs(error) > 0.0):
        raise RecordingError(
            f"{where}: commands are the positions; with no error of the servo it has no effort"
        )
    kept = {name: signal for name, signal in signals.items() if name not in ("current", "torque")}
    return kept | {"current": Signal(position.time, np.clip(error, -limit, limit))}


def servo_words(gain: float, limit: float) -> str:
    """How it was made, for the settings of a recording."""
    most = f", at most {limit:g}" if np.isfinite(limit) else ""
    return f"{WORDS} [rad] x {gain:g}{most}"


def is_servo_error(settings: Mapping[str, str]) -> bool:
    """Whether the current of a recording with these settings is the error of servos."""
    return settings.get("effort", "").startswith(WORDS)
