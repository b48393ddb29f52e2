"""Values: what goes to an arm and comes from it in a cycle, checked before anything is computed with it."""

from dataclasses import dataclass, field, replace

import numpy as np

from .errors import Unreadable


@dataclass(frozen=True, slots=True)
class Command:
    """Position [rad] and velocity [rad/s] of the next cycle, each (n,); the latter for those who take it."""

    position: np.ndarray
    velocity: np.ndarray


SIGNALS = ("position", "velocity", "current", "torque", "temperature")
"""What a sample may hold of each joint."""


@dataclass(frozen=True, slots=True)
class Sample:
    """What was measured in one cycle, in joint coordinates; NaN where the controller is silent.

    Attributes:
        host_time: Host's clock when the measurement came in [ns since 1970]; it never goes back.
        controller_time: Controller's clock, from its own zero; the host's where it has none [ns].
        position: Shape (n,) [rad].
        velocity: Shape (n,) [rad/s].
        current: Shape (n,) [A].
        torque: Shape (n,) [N m].
        temperature: Shape (n,) [degC].
        lateness: By how much the cycle began, or was answered, too late [s].
        skipped: Cycles that went by without an exchange since the last sample.
        stale: Whether no fresh measurement came from a joint in this cycle, shape (n,); its values are NaN.
        events: Messages of the device or the driver in this cycle, a sentence each.
        fault: Why the arm can no longer be commanded; empty while it can.
        sent: Whether the command went out; where the controller asks and did not, it has not.
        state: The controller's own state, shape (k,), a number a name of `Info.state`; NaN where unknown.
    """

    host_time: int
    controller_time: int
    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    torque: np.ndarray
    temperature: np.ndarray
    lateness: float = 0.0
    skipped: int = 0
    stale: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))
    events: tuple[str, ...] = ()
    fault: str = ""
    sent: bool = True
    state: np.ndarray = field(default_factory=lambda: np.zeros(0))


RANGES = {
    "position": (-1e5, 1e5, "rad"),
    "velocity": (-1e4, 1e4, "rad/s"),
    "current": (-1e4, 1e4, "A"),
    "torque": (-1e6, 1e6, "N m"),
    "temperature": (-273.15, 1e3, "degC"),
}
"""Of each signal, lowest and highest value and their unit: beyond what any joint, drive or counter has
(16,000 turns, 95,000 rpm), so that what is outside was never measured."""
LATEST = 1e9
"""Time from a controller's zero [s]: 30 years, which fit into the recording's nanoseconds many times."""
_LOWER = np.array([[RANGES[name][0]] for name in SIGNALS])
_UPPER = np.array([[RANGES[name][1]] for name in SIGNALS])
_LAST = 1 << 62
"""Of times in a recording [ns]; it has 63 bits."""


def any_of(flags: np.ndarray) -> bool:
    """Whether any of a few flags is set, in a fifth of the time that `flags.any()` takes."""
    return True in flags.ravel().tolist()


def nanoseconds(name: str, seconds: float) -> int:
    """A controller's time [ns] of that name. Raises Unreadable for what no controller's clock shows."""
    if not 0.0 <= seconds <= LATEST:
        raise Unreadable(f"{name} is {seconds:g} s; expected 0 to {LATEST:g} s")
    return round(1e9 * seconds)


def checked(sample: Sample) -> Sample:
    """The sample, with NaN and an event in place of values that nothing can have.

    Raises Unreadable for a time that no clock shows, or arrays of another shape.
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
        f"{upper:g} {unit}: taken as not received"
    )
    values[wrong] = np.nan
    signals = dict(zip(SIGNALS, values, strict=True))
    return replace(sample, events=(*sample.events, text), **signals)
