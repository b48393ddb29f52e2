"""Numbers of a file's servos that the identified servos exclude by their intervals."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from ..arm.servo_law import ServoLaw
from ..fit.servo_fit import ServoFit
from ..fit.servo_runs import LONGEST
from ..text_table import NORMAL_95

KP, KV, LIMIT, DELAY = "kp", "kv", "forcerange", "delay"
QUANTITIES = {KP: "stiffness", KV: "damping", LIMIT: "limit", DELAY: "delay"}
"""Attribute of an MJCF -> field of `ServoLaw`."""
UNITS = {KP: "N m/rad", KV: "N m s/rad", LIMIT: "N m", DELAY: "s"}
DETERMINED = 0.1
"""Largest relative standard deviation of a stiffness that counts as determined."""
ACCURACY = 5.0
"""Relative accuracy of gains per sampling period [1/s], 2 % at 4 ms: signals are sampled somewhere within a
cycle, and commands may jump between, so gains are off by some percent whatever their intervals are."""
ALIKE = 0.1
"""Relative standard deviation of the factor by which the gains of an arm's servos differ from the file's."""
CONTRADICTION = 3.29
"""Number of standard deviations that two estimates of one number exceed with a probability of 0.1 %."""
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
    """Numbers of the file's servos that the identified ones exclude."""
    known = determined(fit)
    if not np.any(known):
        return ()
    delay, spread = _delays(fit, known)
    stiffness, of_stiffness, helped = _with_common_factor(fit, file, known)
    # Simulations keep the file's ratio of damping and stiffness.
    kept_ratio = helped & simulated(fit)
    scale = np.where(kept_ratio, stiffness / fit.law.stiffness, 1.0)
    law = replace(fit.law, delay=delay, stiffness=stiffness, damping=scale * fit.law.damping)
    accuracy = 0.5 * ACCURACY * fit.period
    of_damping = accuracy * law.damping + UNIFORM * fit.period * stiffness / 4.0
    std = replace(
        fit.std, delay=spread,
        stiffness=np.hypot(of_stiffness, accuracy * law.stiffness),
        damping=np.hypot(scale * fit.std.damping, of_damping),
    )  # fmt: skip
    rows = zip(helped.tolist(), kept_ratio.tolist(), doubtful(fit).tolist(), strict=True)
    # A limit has no need of gains: the motion at the limit shows it.
    always = (DELAY,) if fit.measured else (DELAY, LIMIT)
    allowed = [
        (*always, *(KP,) * by_others, *(KV,) * (ratio or by_masses)) for by_others, ratio, by_masses in rows
    ]
    return tuple(_changes(law, std, file, known, allowed, fit.measured))


def delay_changes(fit: ServoFit, file: ServoLaw) -> tuple[ServoChange, ...]:
    """Delays that the fit excludes, whether or not it determines gains."""
    halves = NORMAL_95 * np.hypot(fit.std.delay, UNIFORM * fit.period)
    numbers = zip(file.delay.tolist(), fit.law.delay.tolist(), halves.tolist(), strict=True)
    changes = (ServoChange(joint, DELAY, *row) for joint, row in enumerate(numbers))
    return tuple(change for change in changes if abs(change.new - change.old) > change.half)


def _with_common_factor(
    fit: ServoFit, file: ServoLaw, known: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stiffness, its standard deviation, and whether others of the arm help to determine it, (n,) each.

    If the gains of at least two joints differ from the file's by the same factor, so do those of the other
    joints, to `ALIKE`, unless their own estimates contradict.
    """
    stiffness, std, helped = fit.law.stiffness.copy(), fit.std.stiffness.copy(), np.zeros(len(known), bool)
    if not _alike(fit, file, known):
        return stiffness, std, helped
    common = file.stiffness * common_factor(fit, file)
    for joint in np.flatnonzero(~known & ~doubtful(fit) & np.isfinite(stiffness) & np.isfinite(std)):
        spread = ALIKE * common[joint]
        if abs(stiffness[joint] - common[joint]) < CONTRADICTION * np.hypot(std[joint], spread):
            weights = np.array([std[joint], spread]) ** -2.0
            stiffness[joint] = weights @ [stiffness[joint], common[joint]] / weights.sum()
            std[joint], helped[joint] = weights.sum() ** -0.5, True
    return stiffness, std, helped


def simulated(fit: ServoFit) -> np.ndarray:
    """Whether the gains of each joint come from simulations, shape (n,)."""
    return fit.simulated if len(fit.simulated) else np.zeros(len(fit.law.stiffness), bool)


def common_factor(fit: ServoFit, file: ServoLaw) -> float:
    """Factor by which gains that a fit determines differ from those of the file; 1 if not alike."""
    known = determined(fit)
    ratios = np.log(fit.law.stiffness[known] / file.stiffness[known])
    return float(np.exp(np.mean(ratios))) if _alike(fit, file, known) else 1.0


def _alike(fit: ServoFit, file: ServoLaw, known: np.ndarray) -> bool:
    """Whether gains of at least two joints differ from the file's by one factor."""
    ratios = np.log(fit.law.stiffness[known] / file.stiffness[known])
    return len(ratios) > 1 and float(np.std(ratios)) <= ALIKE


def doubtful(fit: ServoFit) -> np.ndarray:
    """Whether other masses explain the motion of each joint as well as other gains, shape (n,)."""
    return fit.doubtful if len(fit.doubtful) else np.zeros(len(fit.law.stiffness), bool)


def determined(fit: ServoFit) -> np.ndarray:
    """Whether the runs determine the gains of each joint's servo, shape (n,)."""
    stiffness, std = fit.law.stiffness, fit.std.stiffness
    physical = np.isfinite(stiffness) & (stiffness > 0.0) & (fit.law.damping > -3.0 * fit.std.damping)
    physical &= fit.law.delay < LONGEST  # what fits best beyond that is no delay
    return np.asarray(physical & ~doubtful(fit) & (std < DETERMINED * np.abs(stiffness)))


def _delays(fit: ServoFit, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Delay of each joint and its standard deviation; one delay for all if they agree, as on one bus."""
    delay, std = fit.law.delay, np.hypot(fit.std.delay, UNIFORM * fit.period)
    weight = known / std**2
    common = float(np.sum(weight * delay) / np.sum(weight))
    sure = _sure(len(delay))
    if np.all(np.abs(delay - common)[known] <= sure * std[known]):
        scatter = float(np.std(delay[known]))
        return np.full(len(delay), common), np.full(len(delay), np.hypot(scatter, UNIFORM * fit.period))
    return np.where(known, delay, np.median(delay[known])), std


def _sure(joints: int) -> float:
    """Standard deviations that no number of all servos exceeds by chance, with 95 % confidence."""
    return float(norm.ppf(1.0 - 0.025 / (joints * len(QUANTITIES))))


def _changes(
    law: ServoLaw,
    std: ServoLaw,
    file: ServoLaw,
    known: np.ndarray,
    allowed: Sequence[tuple[str, ...]],
    measured: bool,
) -> Iterator[ServoChange]:
    sure = _sure(len(known))
    for joint in range(len(known)):
        for quantity, name in QUANTITIES.items():
            new, old, spread = (float(getattr(of, name)[joint]) for of in (law, file, std))
            needed = NORMAL_95 if quantity == DELAY else sure
            possible = known[joint] or quantity in allowed[joint]
            if not possible or not np.isfinite(new):
                continue
            # Without measured torque, damping includes viscous friction: only a lack of it is the servo's.
            differs = old - new if quantity == KV and not measured else abs(new - old)
            if differs > needed * spread:
                yield ServoChange(joint, quantity, old, max(new, 0.0), NORMAL_95 * spread)


def changed_law(file: ServoLaw, changes: tuple[ServoChange, ...]) -> ServoLaw:
    """The law of the file with the changes."""
    values = {name: np.array(getattr(file, name)) for name in QUANTITIES.values()}
    for change in changes:
        values[QUANTITIES[change.quantity]][change.joint] = change.new
    return replace(file, **values)
