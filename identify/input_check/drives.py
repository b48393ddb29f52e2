"""Signs and units of efforts, weighed by what described masses and friction say of each drive's gain."""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..proposal.drives import Gain
from ..text_table import digits
from .coupled import Coupled

UNITS = {
    1e-3: "thousandths (mA, mN m)",
    1e-2: "hundredths, or per cent",
    0.0980665: "kgf cm",
    9.80665: "kgf m",
    1e3: "thousands",
    0.11298: "lbf in",
}
"""Torque of a number over that in the unit stated, and that unit as a person calls it. A foot-pound is not
among them: 1.36 N m are as well a gain that is off."""
RIGHT, UNIT, FACTOR, ANOTHER = 0.973, 0.02, 0.002, 0.005
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

NOTHING = ("", "")
"""What is wrong of efforts as stated, and its cure."""
STATE = "state it: [current] or [torque] unit in a preset, or [drive] gain"
TURN = "turn it: sign = -1 in a preset, or the sign of [drive] gain, or the axis of the joint"
GIVE = "give the description of the arm that was recorded"


class Scale(NamedTuple):
    """What all gains may have in common.

    Attributes:
        what: In a clause; empty for as stated.
        cure: What to do about it.
        middle: Logarithm of each gain over the one stated, shape (n,); NaN where it may be any.
        log_prior: Of it.
        strange: Whether signs may be any as well.
    """

    what: str
    cure: str
    middle: np.ndarray
    log_prior: float
    strange: bool = False


def drive_odds(
    robot: Robot, found: Sequence[Gain], stated: np.ndarray, coupled: Coupled
) -> dict[tuple[str, str], float]:
    """Log of prior times likelihood of mistakes of signs and units, by words and cure, and of `NOTHING`.

    Args:
        robot: The arm as described.
        found: What the log tells of each drive.
        stated: Gains, or 1 for torques, with their signs, shape (n,).
        coupled: How one set of bodies explains the efforts times those gains.
    """
    ratio = np.log(np.array([abs(gain.value) for gain in found]) / np.abs(stated))
    width = np.array([gain.relative for gain in found])
    agree = _agreeing(found, stated)
    known = np.exp(ratio[np.isfinite(ratio)])
    off = f" (by masses and friction {', '.join(digits(one, 2) for one in known)} times the torque stated)"
    odds: dict[tuple[str, str], float] = {}
    for scale in _scales(robot, ratio):
        size = scale.log_prior + _size_odds(ratio, width, scale.middle)
        factor = np.exp(np.nan_to_num(scale.middle))
        for words, turned in _signs(robot, scale.strange):
            sign = _sign_odds(agree, turned, scale.strange)
            what = " and ".join(filter(None, [scale.what and scale.what + off, words]))
            cure = "; ".join(filter(None, [scale.cure, TURN if words else ""]))
            odds[what, cure] = size + sign + coupled.odds(np.where(turned, -factor, factor))
    return odds


def as_stated(stated: np.ndarray, found: Sequence[Gain], coupled: Coupled) -> float:
    """Log-likelihood of signs as stated, whatever the sizes, to compare descriptions of an arm by.

    Sizes are left out: under a description of which a log tells fewer gains, fewer of them could be off.
    """
    turned = np.zeros(len(stated), bool)
    return _sign_odds(_agreeing(found, stated), turned, False) + coupled.odds(np.ones(len(stated)))


def _agreeing(found: Sequence[Gain], stated: np.ndarray) -> np.ndarray:
    """Probability, before, that each effort counts as stated, shape (n,)."""
    agree = np.array([gain.positive for gain in found])
    return np.clip(np.where(stated > 0, agree, 1.0 - agree), 1e-12, 1 - 1e-12)


def _scales(robot: Robot, ratio: np.ndarray) -> Iterator[Scale]:
    n = len(ratio)
    yield Scale("", "", np.zeros(n), np.log(RIGHT))
    for factor, name in UNITS.items():
        prior = np.log(UNIT / len(UNITS) / 2)  # half of all logs with a wrong unit have it on one joint
        yield Scale(f"the efforts are in {name}", STATE, np.full(n, np.log(factor)), prior)
        for j, joint in enumerate(robot.joints if n > 1 else ()):
            middle = np.where(np.arange(n) == j, np.log(factor), 0.0)
            yield Scale(f"the effort of {joint} is in {name}", STATE, middle, prior - np.log(n))
    known = ratio[np.isfinite(ratio)]
    if len(known) > 1:
        common = float(np.median(known))
        # Of all factors the one that fits: one part in so many widths.
        prior = np.log(FACTOR * SPREAD / (DECADES * np.log(10.0)))
        words = f"the efforts are in a unit that is not stated, all off by about {digits(np.exp(common), 2)}"
        yield Scale(words, STATE, np.full(n, common), prior)
        words = f"another arm than {robot.name} was recorded"
        yield Scale(words, GIVE, np.full(n, np.nan), np.log(ANOTHER), strange=True)


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


def _signs(robot: Robot, strange: bool) -> Iterator[tuple[str, np.ndarray]]:
    """Which efforts may count the other way, as a clause and shape (n,)."""
    n = robot.dof
    yield "", np.zeros(n, bool)
    if strange:
        return
    for j, joint in enumerate(robot.joints if n > 1 else ()):
        yield f"the effort of {joint} counts against its motion", np.arange(n) == j
    for a, b in combinations(range(n), 2) if n > 2 else ():
        names = f"{robot.joints[a]} and {robot.joints[b]}"
        yield f"the efforts of {names} count against their motion", np.isin(np.arange(n), (a, b))
    yield "all efforts count against their motion", np.ones(n, bool)


def _sign_odds(agree: np.ndarray, turned: np.ndarray, strange: bool) -> float:
    """Log of prior times likelihood of efforts that are turned (n,), by what friction and masses say.

    `agree` (n,) is each joint's probability, before, that its effort counts as stated.
    """
    if strange:
        return float(len(agree) * np.log(0.5))
    each = np.log(np.where(turned, 1 - agree, agree))
    if turned.all():
        return float(np.sum(each) + np.log(ALL_TURNED))
    return float(np.sum(each) + np.sum(np.where(turned, np.log(TURNED), np.log1p(-TURNED))))
