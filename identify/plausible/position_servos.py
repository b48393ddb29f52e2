"""Position servos: logs without current, in which the position error takes its place, and gains of a file."""

from collections.abc import Mapping, Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import RecordingError
from ..model import Model
from ..recordings.recording import EFFORT, Recording
from ..recordings.servo_error import is_servo_error, no_commands
from ..recordings.tables.column_names import Family
from ..text_table import digits
from .effort_mistakes import FAR
from .evidence import Reading
from .gains import Gain, gain_guesses, gains
from .samples import joined, sampled_run
from .suspicion import Guess
from .weigh import MOST

ERROR = "position error"
BY_SERVO = f"no effort: the {ERROR} takes its place, as for position servos with gain kp [N m/rad]"
"""Note on such a log."""


def only_commanded(chosen: Mapping[str, Family]) -> bool:
    """Whether a log has positions and commands, and no effort."""
    return {"position", "command"} <= set(chosen) and not any(signal in chosen for signal in EFFORT)


def with_error(
    names: Sequence[str], values: np.ndarray, chosen: Mapping[str, Family]
) -> tuple[list[str], np.ndarray, dict[str, Family]]:
    """Names and values (t, c) of the columns, and families by signal, with the position error as current."""
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


def servo_gain_doubts(runs: Sequence[Recording], model: Model, stiffness: np.ndarray) -> list[str]:
    """A sentence if the stated servo stiffness (n,) [N m/rad] contradicts runs that have only commands."""
    errors = [run for run in runs if is_servo_error(run.settings)]
    logs = [log for log in map(sampled_run, errors) if log is not None]
    if not logs:
        return []
    with threadpool_limits(limits=1):
        each = gains(Reading(model, joined(logs).thinned(MOST), False))
    known = [
        (joint, gain.value, stated)
        for joint, gain, stated in zip(model.robot.joints, each, stiffness.tolist(), strict=True)
        if gain.known and gain.value > 0 and stated > 0
    ]
    if not known or abs(np.median([np.log(value / stated) for _, value, stated in known])) < FAR:
        return []
    said = ", ".join(f"{digits(value, 3)} ({joint})" for joint, value, _ in known)
    stated = digits(float(np.median(stiffness)), 4)
    return [
        f"kp of the file is {stated} N m/rad, but bodies and log require {said}: correct kp, or let "
        "exidyn init LOG --robot FILE state it"
    ]
