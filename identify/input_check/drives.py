"""Signs and units of efforts, weighed by what described masses and friction say of each drive's gain."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..proposal.agreement import posterior
from ..proposal.drives import Gain
from ..text_table import digits
from .suspicion import Suspicion

UNITS = {
    1e-3: "thousandths (mA, mN m)",
    1e-2: "hundredths, or per cent",
    0.0980665: "kgf cm",
    9.80665: "kgf m",
    1e3: "thousands",
    1.3558: "lbf ft",
    0.11298: "lbf in",
}
"""Torque of a number over that in the unit stated, and that unit as a person calls it."""
RIGHT, UNIT, FACTOR, ANOTHER = 0.975, 0.01, 0.005, 0.01
"""Probabilities of a log: units as stated, one of `UNITS`, any other factor of all joints, another arm."""
TURNED, ALL_TURNED = 0.005, 0.01
"""Probability that one joint's effort counts the other way, and that all do."""
SPREAD = 0.4
"""Standard deviation of the logarithm of a gain, of masses that are off by a third and a tool."""
ASTRAY, WIDE = 0.05, 1.5
"""Share of joints whose masses say less: a balancer holds them, or the drawing has a wrong mass; and the
standard deviation of the logarithm there."""
DECADES = 6.0
"""Decades over which the factor of a unit that nobody knows may lie."""


class Scale(NamedTuple):
    """What all gains may have in common.

    Attributes:
        what: In a clause; empty for as stated.
        middle: Logarithm of each gain over the one stated, shape (n,); NaN where it may be any.
        log_prior: Of it.
        strange: Whether signs may be any as well.
    """

    what: str
    middle: np.ndarray
    log_prior: float
    strange: bool = False


def suspect_drives(robot: Robot, found: Sequence[Gain], stated: np.ndarray) -> Suspicion | None:
    """The likeliest mistake of signs and units, if one is likelier than none.

    Args:
        robot: The arm as described.
        found: What the log tells of each drive.
        stated: Gains, or 1 for torques, with their signs, shape (n,).
    """
    ratio = np.log(np.array([abs(gain.value) for gain in found]) / np.abs(stated))
    width = np.array([gain.relative for gain in found])
    agree = np.array([gain.positive for gain in found])
    agree = np.clip(np.where(stated > 0, agree, 1.0 - agree), 1e-12, 1 - 1e-12)
    odds: dict[tuple[str, str], float] = {}
    for scale in _scales(robot, ratio):
        size = scale.log_prior + _size_odds(ratio, width, scale.middle)
        for words, sign in _signs(robot, agree, scale.strange):
            odds[scale.what, words] = size + sign
    (what, words), probability = next(iter(posterior(odds).items()))
    if not what and not words:
        return None
    known = ratio[np.isfinite(ratio)]
    off = (
        f"by masses and friction {', '.join(digits(one, 2) for one in np.exp(known))} times the torque stated"
    )
    cures = ["state it: [current] or [torque] unit in a preset, or [drive] gain"] if what else []
    cures += (
        ["turn it: sign = -1 in a preset, or the sign of [drive] gain, or the axis of the joint"]
        if words
        else []
    )
    if what.startswith("another"):
        cures = ["give the description of the arm that was recorded"]
    return Suspicion(
        " and ".join(filter(None, [what and f"{what} ({off})", words])), "; ".join(cures), probability
    )


def _scales(robot: Robot, ratio: np.ndarray) -> Iterator[Scale]:
    n = len(ratio)
    yield Scale("", np.zeros(n), np.log(RIGHT))
    for factor, name in UNITS.items():
        prior = np.log(UNIT / len(UNITS) / (n + 1))
        yield Scale(f"the efforts are in {name}", np.full(n, np.log(factor)), prior)
        for j, joint in enumerate(robot.joints if n > 1 else ()):
            middle = np.where(np.arange(n) == j, np.log(factor), 0.0)
            yield Scale(f"the effort of {joint} is in {name}", middle, prior)
    known = ratio[np.isfinite(ratio)]
    if len(known) > 1:
        common = float(np.median(known))
        # Of all factors the one that fits: one part in so many widths.
        prior = np.log(FACTOR * SPREAD / (DECADES * np.log(10.0)))
        words = f"the efforts are in a unit that is not stated, all off by about {digits(np.exp(common), 2)}"
        yield Scale(words, np.full(n, common), prior)
        words = f"another arm than {robot.name} was recorded"
        yield Scale(words, np.full(n, np.nan), np.log(ANOTHER), strange=True)


def _size_odds(ratio: np.ndarray, width: np.ndarray, middle: np.ndarray) -> float:
    """Log-likelihood of the logarithms of gains over those stated (n,), of those that are known."""
    known = np.isfinite(ratio) & np.isfinite(width)
    if np.isnan(middle).any():
        return float(-np.sum(known) * np.log(DECADES * np.log(10.0)))
    miss, spread = (ratio - middle)[known], np.hypot(SPREAD, width[known])
    wide = np.hypot(WIDE, width[known])
    density = (1 - ASTRAY) * _normal(miss, spread) + ASTRAY * _normal(miss, wide)
    return float(np.sum(np.log(np.maximum(density, 1e-300))))


def _normal(miss: np.ndarray, spread: np.ndarray) -> np.ndarray:
    return np.exp(-0.5 * (miss / spread) ** 2) / (spread * np.sqrt(2 * np.pi))


def _signs(robot: Robot, agree: np.ndarray, strange: bool) -> Iterator[tuple[str, float]]:
    """Which efforts may count the other way, and log of prior times likelihood of that.

    `agree` (n,) is each joint's probability, before, that its effort counts as stated.
    """
    if strange:
        yield "", float(len(agree) * np.log(0.5))
        return
    right, turned = np.log(agree), np.log(1 - agree)
    stay = np.log((1 - TURNED) * (1 - ALL_TURNED / max(len(agree), 1)))
    yield "", float(np.sum(right + stay))
    likely = (turned + np.log(TURNED)) > (right + stay)
    if likely.any() and not likely.all():
        names = ", ".join(joint for joint, one in zip(robot.joints, likely, strict=True) if one)
        odds = np.where(likely, turned + np.log(TURNED), right + stay)
        yield f"the effort of {names} counts against its motion", float(np.sum(odds))
    yield "all efforts count against their motion", float(np.sum(turned) + np.log(ALL_TURNED))
