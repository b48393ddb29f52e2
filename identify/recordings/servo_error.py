"""Servo error: what stands for the current where a log has commands and positions, and no effort.

A position servo makes torque by its gain times what is left to its command, less its own damping, up to what
it can. So its error is to its gain what a current is to a drive gain. Its damping looks like friction.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..arm.robot import PositionServo, Robot
from ..errors import RecordingError
from .no_commands import no_commands
from .recording import EFFORT, Recording, Signal

COMMAND = "command"
"""Kind of effort of such logs."""
WORDS = "servo error"
"""By which the settings of a recording say that its current is that."""
FEW, SELDOM = 5, 0.01
"""Samples, and share of them, that a servo may be at its limit without a word."""
LAW = "effort"
"""Setting of a recording whose current is none; its text is how that was made."""


def servo_of(robot: Robot, gain: float | None, limit: float | None) -> PositionServo:
    """The law of an arm's servos, with gain and limit of one run where these are given."""
    stated = robot.servo or PositionServo(np.ones(robot.dof), np.full(robot.dof, np.inf))
    gains = stated.gain if gain is None else np.full(robot.dof, gain)
    # The limit is that of the amplified error, and as much whatever amplifies it.
    return PositionServo(gains, stated.limit if limit is None else np.full(robot.dof, limit))


def lacks_effort(signals: Mapping[str, Signal], robot: Robot) -> bool:
    """Whether an arm's servos have to tell the effort: none was measured, and commands were recorded."""
    # A controller that measures no effort may fill it with zeros.
    there = {name for name, signal in signals.items() if np.any(np.abs(signal.values) > 0.0)}
    return robot.servo is not None and "command" in there and not there.intersection(EFFORT)


def with_servo_error(signals: Mapping[str, Signal], servo: PositionServo, where: str) -> dict[str, Signal]:
    """Signals with the servo error in place of any effort, as if it were a current.

    Args:
        signals: With position and command.
        servo: The law of the drives.
        where: What errors call the log.

    Raises:
        RecordingError: No command, or columns that hold none; see `no_commands`.
    """
    if "command" not in signals:
        raise RecordingError(
            f"{where} has no commanded position, which --effort {COMMAND} needs; name its columns by "
            "--columns command=NAME,NAME,..."
        )
    position = signals["position"]
    asked = _asked(position, signals["command"])
    known = np.isfinite(asked - position.values).all(axis=1)
    if why := no_commands(asked[known], position.values[known]):
        raise RecordingError(f"{where}: {why}")
    return _by_law(signals, servo)


def _asked(position: Signal, command: Signal) -> np.ndarray:
    """Commands at the times of the positions, shape (t, n)."""
    command = command[np.isfinite(command.values).all(axis=1)]
    return np.stack([np.interp(position.time, command.time, column) for column in command.values.T], axis=1)


def _by_law(signals: Mapping[str, Signal], servo: PositionServo) -> dict[str, Signal]:
    position = signals["position"]
    error = servo.gain * (_asked(position, signals["command"]) - position.values)
    kept = {name: signal for name, signal in signals.items() if name not in EFFORT}
    return kept | {"current": Signal(position.time, np.clip(error, -servo.limit, servo.limit))}


def clipped_words(signals: Mapping[str, Signal], servo: PositionServo, joints: Sequence[str]) -> list[str]:
    """Warnings about servo errors that `with_servo_error` clipped at the law's limit."""
    error, warnings = signals["current"].values, []
    for joint, column, limit, gain in zip(joints, error.T, servo.limit, servo.gain, strict=True):
        clipped = int(np.sum(np.abs(column) >= limit))
        if clipped > max(FEW, SELDOM * len(column)):
            warnings.append(
                f"current: the error of {joint}'s servo is clipped at its limit, {limit:g}, in {clipped} of "
                f"{len(column)} samples: {limit / gain:.3g} rad from the command. Are its gain and "
                "limit those of the robot (servo_gain, servo_limit)?"
            )
    return warnings


def delayed_command(recording: Recording, seconds: np.ndarray) -> Recording | None:
    """A run in which servos had their commands later by some time each, shape (n,) [s].

    None where the run has no servo's error.

    Of such a run nothing but commands can come at another time than positions: its effort is made of both.
    """
    servo, command = recording.robot.servo, recording.signals.get("command")
    if servo is None or command is None or recording.settings.get(LAW) != servo_words(servo):
        return None
    values = np.array(command.values)
    for joint, later in enumerate(seconds):
        values[:, joint] = np.interp(command.time - later, command.time, command.values[:, joint])
    signals = {**recording.signals, "command": Signal(command.time, values)}
    return replace(recording, signals=_by_law(signals, servo))


def servo_words(servo: PositionServo) -> str:
    """How it was made, for the settings of a recording."""
    limited = np.isfinite(servo.limit).any()
    return f"{WORDS} [rad] x {_words(servo.gain)}" + f", at most {_words(servo.limit)}" * bool(limited)


def is_servo_error(settings: Mapping[str, str]) -> bool:
    """Whether the current of a recording with these settings is the error of servos."""
    return settings.get(LAW, "").startswith(WORDS)


def _words(values: np.ndarray) -> str:
    """One number where all joints have the same."""
    alike = np.all(values == values[0])
    return f"{values[0]:g}" if alike else ", ".join(f"{value:g}" for value in values)
