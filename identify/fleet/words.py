"""Words: what changed on an arm, in those of the diagnosis."""

from datetime import UTC, datetime

import numpy as np

from ..diagnosis.words.naming import joined, lower, named
from .causes import Cause
from .compared import Difference
from .drift import CREEP, Found
from .learned import Learned

FEW = 3.0
"""Deviations over which a value is not zero, so that a change may be stated as a share of it."""
DAY = 86400.0


def subject(cause: Cause | Difference, joints: tuple[str, ...]) -> str:
    """What a cause is about: Coulomb friction of joint 3; spring balancer of joint 2, K0."""
    places = [cause.joint] if cause.joint >= 0 else []
    text = named(cause.effect, places, joints)
    detail = cause.effect in ("spring_balancer", "payload", "link_inertia", "joint_spring")
    return f"{text}, {cause.parameter}" if detail else text


def change_words(learned: Learned, found: Found) -> str:
    """A sentence about a change: what, by how much, since when, and what else it may be."""
    frame = learned.frame
    cause, joints = frame.causes[found.cause], frame.kind.model.robot.joints
    amount = amount_words(found.amount, found.std, found.usual, cause.unit)
    when = (
        f"since {date_words(found.day)} ({date_words(found.interval[0])} to {date_words(found.interval[1])})"
    )
    kind = "step or creep" if found.either else "creeping" if found.shape == CREEP else "at once"
    text = f"{subject(cause, joints)}: {amount} {when}, {kind}."
    if found.others:
        others = joined([lower(subject(frame.causes[k], joints)) for k in found.others[:3]], "or")
        text += f" Not excluded: {others}."
    return text


def difference_words(one: Difference, joints: tuple[str, ...]) -> str:
    """A line about what differs between two arms."""
    usual = 1.0 if not one.unit else one.first
    return f"{subject(one, joints)}: {amount_words(one.amount, one.std, usual, one.unit)}"


def amount_words(amount: float, std: float, usual: float, unit: str) -> str:
    """Up 12 ± 3 %; or the amount with its unit where what it is a share of may be zero."""
    way = "up" if amount > 0.0 else "down"
    if np.isfinite(usual) and abs(usual) > FEW * std:
        if usual < 0.0 and unit:  # of a negative value, such as a preload, up is farther from zero
            way = "down" if amount > 0.0 else "up"
        share = 100.0 / abs(usual)
        return f"{way} {share * abs(amount):.2g} ± {_one_digit(share * std)} %"
    return f"{way} {abs(amount):.3g} ± {_one_digit(std)} {unit}".rstrip()


def _one_digit(std: float) -> str:
    """A deviation with one digit that counts, and no exponent while it is of usual size."""
    return f"{float(f'{std:.1g}'):g}"


def date_words(day: float) -> str:
    """A day as 3 May 2026."""
    date = datetime.fromtimestamp(day * DAY, UTC)
    return f"{date.day} {date:%b %Y}"
