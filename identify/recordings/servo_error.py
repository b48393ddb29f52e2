"""Servo error, which replaces the current in a log with commands and positions but without effort.

A position servo produces a torque of its gain times its position error, less its damping, up to a limit. The
error times its gain therefore corresponds to a current times a drive gain. Its damping looks like friction.
Columns that are copies of positions, even of later samples, or their steps are no commands.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..arm.robot import PositionServo, Robot
from ..errors import RecordingError
from .recording import EFFORT, Recording, Signal, interpolated

COMMAND = "command"
"""Kind of effort of such logs."""
WORDS = "servo error"
"""Beginning of the setting that marks the current of a recording as a servo error."""
FEW, SELDOM = 5, 0.01
"""Number and share of samples at the limit of a servo up to which there is no warning."""
LAW = "effort"
"""Setting of a recording whose current is computed; its text describes the computation."""
LATEST = 10
"""Maximum shift of copied positions in samples."""
EXACT = 1e-5
"""Maximum difference from a copy, over a joint's range, due to rounding. No servo meets every command."""
ALMOST = 0.98
"""Minimum share of the samples in motion that match in a copy; a run may end with a repeated sample."""
FEWEST = 20
"""Minimum number of samples in motion to detect a copy."""
FOLLOWS = 0.5
"""Correlation of commands and positions below which a joint does not follow."""
STEPS = 0.8
"""Correlation of commands with the steps of positions above which they are these steps."""
SMALL = 0.2
"""Ratio of the spread of commands to that of positions below which commands are not goals."""
CHANGING = 0.5
"""Share of the samples in which commands change above which they are a motion."""
PROPORTIONAL = 0.98
"""Correlation above which commands are the steps times a rate or unit: no lag of a joint is so exact."""
ALIKE = 3.0
"""Maximum ratio of commands to the steps that they are, or its inverse. A joint that lags by a quarter of a
period follows the derivative of the commands too, but its steps are far smaller."""
NO_EFFORT = "with no error of the servo there is no effort. Record the positions that the servos were sent"


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
    """Signals in which the servo error, of positions and commands, replaces any effort as a current."""
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
    return command[np.isfinite(command.values).all(axis=1)].at(position.time)


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
    values = interpolated(command.time[:, None] - seconds, command.time, command.values)
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


def no_commands(command: np.ndarray, position: np.ndarray) -> str:
    """Why commands (t, n) for positions (t, n) in the same unit are not commands; empty if they may be.

    The sampling rate is constant, and joints at rest count as following.
    """
    if np.array_equal(command, position):
        return f"commands are the positions: {NO_EFFORT}"
    reach = np.ptp(position, axis=0)
    moving = np.flatnonzero(reach > 0.0)
    command, position, reach = command[:, moving], position[:, moving], reach[moving]
    if not len(moving) or len(position) < 2 * LATEST:
        return ""
    moved = np.abs(np.diff(position, axis=0)) > EXACT * reach
    for shift in range(LATEST + 1):
        later = position[shift:]
        exact = np.abs(command[: len(later)] - later) <= EXACT * reach
        in_motion = moved[: len(later)]
        if in_motion.sum() >= FEWEST and np.mean(exact[: len(in_motion)][in_motion]) >= ALMOST:
            source = {0: "positions", 1: "positions of the next sample"}
            return f"commands are the {source.get(shift, f'positions {shift} samples later')}: {NO_EFFORT}"
    if np.any(_correlation(command, position) > FOLLOWS):
        return ""
    # Commands that are mostly constant may hold a falling joint.
    changing = np.mean(np.any(np.diff(command, axis=0) != 0.0, axis=1)) > CHANGING
    if changing and np.median(command.std(axis=0) / position.std(axis=0)) < SMALL:
        return (
            "commands do not follow the positions, and move far less: they look like steps, or like goals "
            "relative to the position. If so, add to each the position from which it starts"
        )
    steps = np.diff(position, axis=0)
    alike = max(float(np.median(_correlation(command[k : len(steps) + k], steps))) for k in (0, 1))
    larger = float(np.median(command.std(axis=0) / np.maximum(steps.std(axis=0), 1e-300)))
    if alike > PROPORTIONAL or (alike > STEPS and 1 / ALIKE < larger < ALIKE):
        return (
            "commands do not follow the positions: they look like steps to the next position. If these were "
            "the goals of the servos, add to each the position from which it starts"
        )
    return ""


def _correlation(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Correlation of columns (t, n), shape (n,); zero if a column is constant."""
    first, second = first - first.mean(axis=0), second - second.mean(axis=0)
    size = np.linalg.norm(first, axis=0) * np.linalg.norm(second, axis=0)
    return np.asarray(np.sum(first * second, axis=0) / np.where(size > 0.0, size, 1.0))
