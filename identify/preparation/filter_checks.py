"""Filters asked for that no recording can have: one sentence with option, value and limit."""

import numpy as np

from ..errors import RecordingError


def check_positive(option: str, value: float | None, unit: str) -> None:
    """Refuse what is not above zero.

    Raises:
        RecordingError: It is not.
    """
    if value is not None and not value > 0.0:
        raise RecordingError(
            f"{option} is {value:g} {unit}; it must be above 0; leave it out to have it chosen from the data"
        )


def check_cutoff(option: str, cutoff: float | None, rate: float, run: str) -> None:
    """Refuse a cut-off [Hz] that no filter of a run at this rate can have.

    Raises:
        RecordingError: Not below half the sample rate.
    """
    if cutoff is not None and not cutoff < 0.5 * rate:
        raise RecordingError(
            f"{option} is {cutoff:g} Hz; it must lie below {0.5 * rate:g} Hz, half the sample "
            f"rate of {run}; leave it out to have it chosen from the data"
        )


def check_standstill(standstill: float | None, velocity: np.ndarray, run: str) -> None:
    """Refuse a standstill [rad/s] that leaves nothing of velocities, shape (t, n) [rad/s].

    Raises:
        RecordingError: Above the speed of every joint.
    """
    if standstill is None:
        return
    fastest = float(np.max(np.abs(velocity)))
    if not standstill <= fastest:
        raise RecordingError(
            f"--standstill is {standstill:g} rad/s; it must lie below {fastest:.3g} rad/s, the "
            f"highest speed of any joint in {run}; leave it out to have it chosen from the data"
        )
