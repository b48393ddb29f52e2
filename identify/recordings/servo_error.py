"""Servo error, which replaces the current in a log with commands and positions but without effort.

A position servo produces a torque of its gain times its position error, less its damping, up to a limit. The
error times its gain therefore corresponds to a current times a drive gain. Its damping looks like friction.
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
"""Beginning of the setting that marks the current of a recording as a servo error."""
FEW, SELDOM = 5, 0.01
"""Number and share of samples at the limit of a servo up to which there is no warning."""
LAW = "effort"
"""Setting of a recording whose current is computed; its text describes the computation."""


def servo_of(robot: Robot, gain: float | None, limit: float | None) -> PositionServo:
    """Servos of an arm, with the gain and limit of one run if they are stated."""
    stated = robot.servo or PositionServo(np.ones(robot.dof), np.full(robot.dof, np.inf))
    gains = stated.gain if gain is None else np.full(robot.dof, gain)
    # The limit applies to the amplified error, so it does not depend on the gain.
    return PositionServo(gains, stated.limit if limit is None else np.full(robot.dof, limit))


def lacks_effort(signals: Mapping[str, Signal], robot: Robot) -> bool:
    """Whether the servo error has to replace the effort: commands were recorded, but no effort."""
    # A controller that measures no effort may fill it with zeros.
    nonzero = {name for name, signal in signals.items() if np.any(np.abs(signal.values) > 0.0)}
    return robot.servo is not None and "command" in nonzero and not nonzero.intersection(EFFORT)


def with_servo_error(signals: Mapping[str, Signal], servo: PositionServo, where: str) -> dict[str, Signal]:
    """Signals in which the servo error replaces any effort, as a current.

    Args:
        signals: Signals with position and command.
        servo: Position servos of the arm.
        where: Name of the log in messages.

    Raises:
        RecordingError: There is no command, or its columns are not commands; see `no_commands`.
    """
    if "command" not in signals:
        raise RecordingError(
            f"{where} has no commanded position, which --effort {COMMAND} needs; name its columns by "
            "--columns command=NAME,NAME,..."
        )
    position = signals["position"]
    command = _command_at(position, signals["command"])
    known = np.isfinite(command - position.values).all(axis=1)
    if why := no_commands(command[known], position.values[known]):
        raise RecordingError(f"{where}: {why}")
    return _by_law(signals, servo)


def _command_at(position: Signal, command: Signal) -> np.ndarray:
    """Commands at the times of the positions, shape (t, n)."""
    command = command[np.isfinite(command.values).all(axis=1)]
    return np.stack([np.interp(position.time, command.time, column) for column in command.values.T], axis=1)


def _by_law(signals: Mapping[str, Signal], servo: PositionServo) -> dict[str, Signal]:
    position = signals["position"]
    error = servo.gain * (_command_at(position, signals["command"]) - position.values)
    others = {name: signal for name, signal in signals.items() if name not in EFFORT}
    return others | {"current": Signal(position.time, np.clip(error, -servo.limit, servo.limit))}


def clipped_words(signals: Mapping[str, Signal], servo: PositionServo, joints: Sequence[str]) -> list[str]:
    """Warnings about servo errors that `with_servo_error` clipped at the limit of the servo."""
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
    """Recording in which the command of each servo is delayed by some time, shape (n,) [s].

    The effort is computed from commands and positions, so only commands can be delayed relative to positions.

    Returns:
        None if the effort of the recording is not a servo error.
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
    """Description of the servo error for the settings of a recording."""
    limited = np.isfinite(servo.limit).any()
    return f"{WORDS} [rad] x {_words(servo.gain)}" + f", at most {_words(servo.limit)}" * bool(limited)


def is_servo_error(settings: Mapping[str, str]) -> bool:
    """Whether the current of a recording with these settings is a servo error."""
    return LAW in settings


def _words(values: np.ndarray) -> str:
    """Numbers of all joints as text; a single number if they are equal."""
    alike = np.all(values == values[0])
    return f"{values[0]:g}" if alike else ", ".join(f"{value:g}" for value in values)
