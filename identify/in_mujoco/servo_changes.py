"""Numbers of a file's servos that the identified servos exclude by their intervals."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from ..arm.robot import ServoLaw
from ..fit.servo_fit import LONGEST, ServoFit
from ..text_table import NORMAL_95

KP, KV, LIMIT, DELAY = "kp", "kv", "forcerange", "delay"
QUANTITIES = {KP: "stiffness", KV: "damping", LIMIT: "limit", DELAY: "delay"}
"""Attribute of an MJCF -> field of `ServoLaw`."""
BY_TORQUE = (KP, KV, LIMIT)
"""What measured torque states; delays are those of simulations, since torque is sampled within a cycle."""
UNITS = {KP: "N m/rad", KV: "N m s/rad", LIMIT: "N m", DELAY: "s"}
DETERMINED = 0.1
"""Largest relative standard deviation of a stiffness that counts as determined."""
ACCURACY = 5.0
"""Relative accuracy of gains per sampling period [1/s], 2 % at 4 ms: signals are sampled somewhere within a
cycle, and commands may jump between, so gains are off by some percent whatever their intervals are."""
UNIFORM = 1.0 / np.sqrt(12.0)
"""Standard deviation of a moment within a cycle, over its duration."""


@dataclass(frozen=True)
class ServoChange:
    """A number of a servo that differs from the file's."""

    joint: int  # index of the joint, from 0
    quantity: str  # "kp", "kv", "forcerange" or "delay"
    old: float  # number of the file, at the joint; infinite for a servo without a limit
    new: float  # identified number
    half: float  # half of its 95 % interval


def servo_changes(fit: ServoFit, file: ServoLaw) -> tuple[ServoChange, ...]:
    """Numbers of the file's servos that servos identified by measured torque exclude."""
    known = determined(fit)
    if not np.any(known):
        return ()
    law, accuracy = fit.law, 0.5 * ACCURACY * fit.period
    of_damping = accuracy * law.damping + UNIFORM * fit.period * law.stiffness / 4.0
    std = replace(
        fit.std,
        stiffness=np.hypot(fit.std.stiffness, accuracy * law.stiffness),
        damping=np.hypot(fit.std.damping, of_damping),
    )  # fmt: skip
    return tuple(_changes(law, std, file, known))


def determined(fit: ServoFit) -> np.ndarray:
    """Whether the runs determine the gains of each joint's servo, shape (n,)."""
    stiffness, std = fit.law.stiffness, fit.std.stiffness
    physical = np.isfinite(stiffness) & (stiffness > 0.0) & (fit.law.damping > -3.0 * fit.std.damping)
    physical &= fit.law.delay < LONGEST  # what fits best beyond that is no delay
    return np.asarray(physical & (std < DETERMINED * np.abs(stiffness)))


def _changes(law: ServoLaw, std: ServoLaw, file: ServoLaw, known: np.ndarray) -> Iterator[ServoChange]:
    # Standard deviations that no number of all servos exceeds by chance, with 95 % confidence.
    sure = float(norm.ppf(1.0 - 0.025 / (len(known) * len(BY_TORQUE))))
    for joint in np.flatnonzero(known).tolist():
        for quantity in BY_TORQUE:
            name = QUANTITIES[quantity]
            new, old, spread = (float(getattr(of, name)[joint]) for of in (law, file, std))
            if np.isfinite(new) and abs(new - old) > sure * spread:
                yield ServoChange(joint, quantity, old, max(new, 0.0), NORMAL_95 * spread)


def changed_law(file: ServoLaw, changes: tuple[ServoChange, ...]) -> ServoLaw:
    """The law of the file with the changes."""
    values = {name: np.array(getattr(file, name)) for name in QUANTITIES.values()}
    for change in changes:
        values[QUANTITIES[change.quantity]][change.joint] = change.new
    return replace(file, **values)
