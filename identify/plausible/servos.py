"""Logs of position servos without current: the position error takes its place."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..errors import RecordingError
from ..recordings.no_commands import no_commands
from ..recordings.recording import EFFORT
from .column_names import Family
from .evidence import Reading
from .gains import Gain, gain_guesses, gains
from .guess import Guess

ERROR = "position error"
BY_SERVO = f"no effort: the {ERROR} takes its place, as for position servos with gain kp [N m/rad]"
"""Note on such a log."""


def only_commanded(chosen: Mapping[str, Family]) -> bool:
    """Whether a log has positions and commands, and no effort."""
    return {"position", "command"} <= set(chosen) and not any(signal in chosen for signal in EFFORT)


def with_error(
    names: Sequence[str], values: np.ndarray, chosen: Mapping[str, Family]
) -> tuple[list[str], np.ndarray, dict[str, Family]]:
    """Names and values (t, c) of the columns, and families by signal, with the position error as current.

    Raises:
        RecordingError: The command columns do not contain commands.
    """
    position, command = chosen["position"], chosen["command"]
    known = np.isfinite(values[:, [*position.places, *command.places]]).all(axis=1)
    if why := no_commands(values[known][:, command.places], values[known][:, position.places]):
        raise RecordingError(f"{command.pattern}: {why}")
    error = values[:, command.places] - values[:, position.places]
    places = tuple(range(values.shape[1], values.shape[1] + error.shape[1]))
    made = tuple(f"{ERROR} of {name}" for name in position.names)
    family = Family(ERROR, places, made, position.by_name, "current", "")
    return [*names, *made], np.column_stack([values, error]), {**chosen, "current": family}


def servo_gains(
    chosen: Mapping[str, Family], reading: Reading, scale: np.ndarray
) -> tuple[dict[str, Family], tuple[Gain, ...], list[Guess]]:
    """Signals of the log, gains of the servos [N m/rad], and guesses.

    `scale` (n,) is the number of radians or meters per unit of the errors.
    """
    pairs = zip(gains(reading), scale.tolist(), strict=True)
    servos = tuple(gain._replace(value=gain.value / unit) for gain, unit in pairs)
    recorded = {signal: family for signal, family in chosen.items() if signal not in EFFORT}
    return recorded, servos, gain_guesses(reading.model.robot.joints, servos)
