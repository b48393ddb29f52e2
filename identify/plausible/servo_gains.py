"""Check of a file's position servo gains against a log: servo errors compared with torques of the bodies."""

from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from ..model import Model
from ..recordings.recording import Recording
from ..recordings.servo_error import is_servo_error
from ..text_table import digits
from .effort_mistakes import FAR
from .evidence import Reading
from .gains import gains
from .sampled_runs import sampled_run
from .samples import joined
from .weigh import MOST


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
        "exidyn init LOG --mjcf FILE state it"
    ]
