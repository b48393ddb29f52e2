"""Position servos: logs without current, in which the position error takes its place, and gains of a file."""

from collections.abc import Mapping, Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from ..model import Model
from ..recordings.recording import EFFORT, Recording
from ..recordings.servo_error import is_servo_error
from ..recordings.tables.column_names import Family
from ..text_table import digits
from .evidence import Reading
from .gains import Gain, gain_guesses, gains
from .samples import joined, sampled_run
from .search import MOST
from .size_mistakes import FAR
from .suspicion import Guess

ERROR = "position error"
BY_SERVO = f"no effort: the {ERROR} takes its place, as for position servos with gain kp [N m/rad]"
"""Note on such a log."""


def only_commanded(chosen: Mapping[str, Family]) -> bool:
    """Whether a log has positions and commands, and no effort."""
    return {"position", "command"} <= set(chosen) and not any(signal in chosen for signal in EFFORT)


def error_of(position: Family) -> Family:
    """Name of the position errors, which import computes, as if they were columns of currents."""
    return position._replace(pattern=ERROR, names=tuple(f"{ERROR} of {name}" for name in position.names))


def servo_gains(
    chosen: Mapping[str, Family], reading: Reading
) -> tuple[dict[str, Family], tuple[Gain, ...], list[Guess]]:
    """Signals of the log, gains of the servos [N m/rad], and guesses."""
    servos = gains(reading)
    recorded = {signal: family for signal, family in chosen.items() if signal not in EFFORT}
    return recorded, tuple(servos), gain_guesses(reading.model.robot.joints, servos)


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
