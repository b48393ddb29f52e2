"""Values sent to an arm and received from it in a cycle, checked before they are used."""

from collections import deque
from dataclasses import dataclass, field, replace
from statistics import median

import numpy as np

from .errors import Unreadable


@dataclass(frozen=True, slots=True)
class Command:
    """Position [rad] and velocity [rad/s] of the next cycle, each (n,); not all drivers use the velocity."""

    position: np.ndarray
    velocity: np.ndarray


SIGNALS = ("position", "velocity", "current", "torque", "temperature")
"""Signals that a sample may have of each joint."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Measurements of one cycle, in joint coordinates; NaN where the controller is silent."""

    host_time: int  # time of arrival by the host's clock [ns since 1970]; it never goes back
    controller_time: int  # time of the controller from its own zero [ns]; the host's if it has no clock
    position: np.ndarray  # joint positions, shape (n,) [rad]
    velocity: np.ndarray  # joint velocities, shape (n,) [rad/s]
    current: np.ndarray  # motor currents, shape (n,) [A]
    torque: np.ndarray  # joint torques, shape (n,) [N m]
    temperature: np.ndarray  # temperatures, shape (n,) [degC]
    lateness: float = 0.0  # delay of the beginning of the cycle, or of its answer [s]
    skipped: int = 0  # number of cycles without an exchange since the last sample
    # Whether a joint sent no new measurement in this cycle, shape (n,); its values are NaN.
    stale: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))
    events: tuple[str, ...] = ()  # messages of the device or the driver in this cycle, a sentence each
    fault: str = ""  # why the arm can no longer be commanded; empty while it can
    # Whether the command was sent; False if a controller that asks for commands did not ask.
    sent: bool = True
    # Controller state, shape (k,), one number per name in `Info.state`; NaN where unknown.
    state: np.ndarray = field(default_factory=lambda: np.zeros(0))


RANGES = {
    "position": (-1e5, 1e5, "rad"),
    "velocity": (-1e4, 1e4, "rad/s"),
    "current": (-1e4, 1e4, "A"),
    "torque": (-1e6, 1e6, "N m"),
    "temperature": (-273.15, 1e3, "degC"),
}
"""Lowest and highest value of each signal, and their unit. No joint, drive or counter reaches them (16,000
turns, 95,000 rpm), so a value outside was never measured."""
LATEST = 1e9
"""Latest time from a controller's zero [s]: 30 years, far within the range of a recording's nanoseconds."""
_LOWER = np.array([[RANGES[name][0]] for name in SIGNALS])
_UPPER = np.array([[RANGES[name][1]] for name in SIGNALS])
_LAST = 1 << 62
"""Latest time in a recording [ns], which has 63 bits."""


def any_of(flags: np.ndarray) -> bool:
    """Whether any of a few flags is set, in a fifth of the time that `flags.any()` takes."""
    return True in flags.ravel().tolist()


def nanoseconds(name: str, seconds: float) -> int:
    """Convert a controller's time [s] to [ns]; `name` is for messages.

    Raises Unreadable for a time that no controller's clock shows.
    """
    if not 0.0 <= seconds <= LATEST:
        raise Unreadable(f"{name} is {seconds:g} s; expected 0 to {LATEST:g} s")
    return round(1e9 * seconds)


def checked(sample: Sample) -> Sample:
    """Return the sample with impossible values replaced by NaN and reported as an event.

    Raises Unreadable for a time that no clock shows, or for arrays of different lengths.
    """
    for name in ("host_time", "controller_time"):
        if not 0 <= getattr(sample, name) < _LAST:
            raise Unreadable(f"{name} is {getattr(sample, name)} ns; expected 0 to {_LAST} ns")
    try:
        values = np.array(
            (sample.position, sample.velocity, sample.current, sample.torque, sample.temperature)
        )
    except ValueError as error:
        raise Unreadable("position, velocity, current, torque and temperature differ in length") from error
    wrong = (values < _LOWER) | (values > _UPPER)  # NaN is neither: a joint may be silent
    return _without(sample, values, wrong) if any_of(wrong) else sample


def _without(sample: Sample, values: np.ndarray, wrong: np.ndarray) -> Sample:
    row, joint = (int(place[0]) for place in np.nonzero(wrong))
    lower, upper, unit = RANGES[SIGNALS[row]]
    text = (
        f"{SIGNALS[row]} of joint {joint + 1} is {values[row, joint]:g} {unit}; expected {lower:g} to "
        f"{upper:g} {unit}: treated as not received"
    )
    values[wrong] = np.nan
    signals = dict(zip(SIGNALS, values, strict=True))
    return replace(sample, events=(*sample.events, text), **signals)


AGREEING = 5
"""Number of consecutive measurements of a resting joint that must agree."""
APART = 0.035
"""Largest difference between them [rad] or [m]: two degrees are an acceptable jump at power-on, and an arm
held by hand moves less in five cycles."""


class Resting:
    """Resting position of each of n joints before power-on, from its last measurements [rad] or [m].

    A drive holds the goal that it has when it is switched on. If a single wrong measurement set this goal,
    the drive would jump there.
    """

    def __init__(self, joints: int) -> None:
        self._seen = [deque[float](maxlen=AGREEING) for _ in range(joints)]

    def add(self, joint: int, position: float) -> None:
        """Add a measurement; NaN discards the earlier ones."""
        if position == position:
            self._seen[joint].append(position)
        else:
            self._seen[joint].clear()

    def known(self, joint: int) -> bool:
        """Whether enough consecutive measurements agree."""
        return len(self._seen[joint]) == AGREEING and self.spread(joint) <= APART

    def position(self, joint: int) -> float:
        """Median of the last measurements."""
        return median(self._seen[joint])

    def spread(self, joint: int) -> float:
        """Largest difference between the last measurements; 0.0 without measurements."""
        seen = self._seen[joint]
        return max(seen) - min(seen) if seen else 0.0

    def doubt(self, joint: int) -> str:
        """Why the position of a joint is not known, in words."""
        if len(self._seen[joint]) < AGREEING:
            return f"it gave {len(self._seen[joint])} positions in a row, {AGREEING} are needed"
        return f"its last {AGREEING} positions differ by {self.spread(joint):.3g} rad, limit {APART:g}"
