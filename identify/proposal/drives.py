"""Sign and rough size of drive gains: efforts against the torque that the described bodies need."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from ..arm.robot import Robot
from ..text_table import NORMAL_95, digits
from .agreement import DECIDED, RIDGE, Guess, Sampled, friction_columns, independent
from .described_bodies import Bodies, Stated, bodies_of, log_likelihood, sliding_rows

TOLD = 0.35
"""Standard deviation of a logarithm up to which a size is known: twice or half is two of them away."""
GAINS = np.logspace(-3, 3, 121)
"""Gains against which a gain of 1, of an effort that is the joint's torque, is weighed [N m per unit]."""
UNLIKE = float(np.log(0.05))
"""What one joint may say against torques, at most: a spring or a tool that the description leaves out."""


GAIN_OF = "gain of "
"""Beginning of what a guess of gains asks."""


class Gain(NamedTuple):
    """What a log tells of one drive.

    Attributes:
        value: Torque per unit of effort, with its sign; NaN where the log does not tell.
        relative: Standard deviation of its logarithm [-].
        positive: Probability that effort counts as torque does: with the joint.
        torque: Log odds that the effort is the joint's torque [N m], over any other unit and sign.
        against: Log odds that it is that torque with the other sign.
    """

    value: float = np.nan
    relative: float = np.inf
    positive: float = 0.5
    torque: float = 0.0
    against: float = 0.0

    @property
    def known(self) -> bool:
        """Whether both sign and size are known well enough to be written down."""
        sure = max(self.positive, 1 - self.positive) >= DECIDED
        return bool(np.isfinite(self.value) and self.relative <= TOLD and sure)


def agreed(torque: np.ndarray, log: Sampled) -> float:
    """Log-likelihood of efforts by described torque (t, n) and friction, each drive of the likelier sign."""
    total = 0.0
    for j in range(torque.shape[1]):
        rows = sliding_rows(log, j)
        if len(rows):
            effort = log.effort[rows, j]
            signed = np.column_stack([torque[rows, j], friction_columns(log.motion, j)[rows]])
            least = min(_left(signed, sign * effort) for sign in (1.0, -1.0))
            total -= 0.5 * independent(effort) * float(np.log(max(least, 1e-3)))
    return total


def gains(robot: Robot, log: Sampled, stated: Stated | None = None) -> list[Gain]:
    """Gain of each drive; `stated` is what a description states beside bodies.

    Effort = torque of the bodies / gain + rotor, drag and dry friction, which all have the sign of the gain,
    + offset. Size: by `log_likelihood`. Sign: which of both fits better when no term may have the other one.
    """
    return [_gain(bodies, log, j) for j, bodies in enumerate(bodies_of(robot, log, stated=stated))]


def gain_guesses(joints: Sequence[str], found: Sequence[Gain]) -> list[Guess]:
    """Each gain that is known, and those that are not together; none where efforts are torques."""
    why, option, unknown = (
        "of its sign; size ± 95 %: bodies, friction",
        "[drive] gain, or a run with a known payload",
        [],
    )
    guesses = []
    for joint, gain in zip(joints, found, strict=True) if found else ():
        if not gain.known:
            unknown.append(joint)
            continue
        size = f"{digits(gain.value)} N m ± {digits(100 * NORMAL_95 * gain.relative, 2)} %"
        guesses.append(Guess(f"{GAIN_OF}{joint}", size, max(gain.positive, 1 - gain.positive), why, option))
    if unknown:
        guesses.append(Guess(f"{GAIN_OF}{', '.join(unknown)}", "", 0.0, why, option))
    return guesses


def _gain(bodies: Bodies, log: Sampled, joint: int) -> Gain:
    rows = sliding_rows(log, joint)
    if not len(rows):
        return Gain()
    bodies, effort = bodies.at(rows), log.effort[rows, joint]
    signed = np.column_stack([bodies.torque, bodies.friction])
    forward, backward = (_left(signed, sign * effort) for sign in (1.0, -1.0))
    odds = 0.5 * independent(effort) * np.log(backward / forward)
    positive = float(1 / (1 + np.exp(-np.clip(odds, -99, 99))))
    if not np.any(bodies.torque):
        return Gain(positive=positive)
    noise = max(min(forward, backward), 0.01) * effort.var() * len(rows) / independent(effort)
    sign = 1.0 if positive > 0.5 else -1.0
    weighed = bodies.gains(effort)
    likely = log_likelihood(sign * effort, bodies, noise, np.array([1.0, *GAINS, *weighed]))
    one, others, likely = likely[0], likely[1 : 1 + len(GAINS)], likely[1 + len(GAINS) :]
    weight = np.exp(likely - likely.max())
    weight /= weight.sum()
    middle = float(weight @ np.log(weighed))
    relative = float(np.sqrt(weight @ (np.log(weighed) - middle) ** 2))
    as_torque = one - others.max() - np.log(np.exp(others - others.max()).mean())
    both = np.maximum(as_torque - np.logaddexp(0.0, [-odds, odds]) - np.log(0.5), UNLIKE)
    if int(np.argmax(likely)) in (0, len(likely) - 1):  # the best lies beyond: what is weighed is no answer
        return Gain(positive=positive, torque=both[0], against=both[1])
    return Gain(float(sign * np.exp(middle)), relative, positive, *both.tolist())


def _left(columns: np.ndarray, effort: np.ndarray) -> float:
    """Share of the variance left by coefficients that are not negative, beside a free offset."""
    scaled = (columns - columns.mean(axis=0)) / np.maximum(columns.std(axis=0), 1e-12)
    left = nnls(scaled, effort - effort.mean())[1]
    return max(float(left**2 / ((effort - effort.mean()) ** 2).sum()), 1e-6)


def braking_odds(bodies: Bodies, effort: np.ndarray) -> float:
    """Log odds that effort (t,) counts with the joint, by rotor and friction beside bodies of any mass."""
    free = np.column_stack([bodies.errors, np.ones(len(effort))])
    free /= np.maximum(np.sqrt((free**2).mean(axis=0)), 1e-12)
    normal = free.T @ free + RIDGE * len(free) * np.eye(free.shape[1])
    both = np.column_stack([bodies.friction, effort])
    rest = both - free @ np.linalg.solve(normal, free.T @ both)
    forward, backward = (nnls(rest[:, :3], sign * rest[:, 3])[1] ** 2 for sign in (1.0, -1.0))
    least = 1e-3 * float(((effort - effort.mean()) ** 2).sum())
    return 0.5 * independent(effort) * float(np.log(max(backward, least) / max(forward, least)))
