"""Sign and rough size of drive gains: efforts against the torque that the described bodies need."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..text_table import NORMAL_95, digits
from .described_bodies import ANY, KINDS, Likelihood, mean_of_logs
from .evidence import Reading
from .guess import DECIDED, Guess

TELLS = 0.35
"""Standard deviation of a logarithm up to which a size is known: twice or half is two of them away."""
EXACT = 0.1
"""Standard deviation of the logarithm of a measured torque over the true one: sensors are calibrated."""
UNLIKE = float(np.log(0.05))
"""What one joint may say against torques, at most: a spring or a tool that the description leaves out."""
GAIN_OF = "gain of "
"""Beginning of what a guess of gains asks."""
UNITS = np.linspace(-3.0, 3.0, 61)
"""Units that an effort may have, as powers of ten of N m."""


TORQUE, AGAINST, NOT_TORQUE = "N m of the joint", "N m against the joint", "not N m: needs gain"
"""What efforts may be."""
NAMED = 0.99
"""Probability that efforts which are called torques or currents are that."""
BACKWARD = 0.02
"""Probability that a log counts torques in N m against the positions, which it does of all joints alike."""


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
        return bool(np.isfinite(self.value) and self.relative <= TELLS and sure)


def gains(reading: Reading) -> list[Gain]:
    """Gain of each drive."""
    return [gain_of(likely) for likely in reading.likelihoods]


def gain_of(likely: Likelihood) -> Gain:
    """What one joint's likelihood tells of its drive."""
    if not likely.known:
        return Gain()
    usual = likely.gains
    forward, backward = (_by_masses(likely, sign) for sign in (1.0, -1.0))
    odds = mean_of_logs(forward) - mean_of_logs(backward)
    positive = float(1 / (1 + np.exp(-np.clip(odds, -99, 99))))
    if not likely.described:
        return Gain(positive=positive)
    better = forward if odds > 0 else backward
    weight = np.exp(better - better.max())
    weight /= weight.sum()
    middle = float(weight @ np.log(usual))
    relative = float(np.sqrt(weight @ (np.log(usual) - middle) ** 2))
    torque, against = (_as_torque(likely, sign) for sign in (1.0, -1.0))
    if int(np.argmax(better)) in (0, len(better) - 1):  # the best lies beyond: what is weighed is no answer
        return Gain(positive=positive, torque=torque, against=against)
    return Gain(float(np.sign(odds) * np.exp(middle)), relative, positive, torque, against)


def _by_masses(likely: Likelihood, sign: float) -> np.ndarray:
    """Log-likelihood of the usual gains of a sign, by masses that are a drawing's or rough, (g,)."""
    if not likely.described:
        return likely.at(likely.gains, sign, ANY)
    kinds = [
        np.log(kind.probability) + likely.at(likely.gains, sign, kind) for kind in KINDS if kind.described
    ]
    return np.asarray(np.logaddexp.reduce(kinds))


def effort_odds(every: Sequence[Gain], called: str) -> dict[str, float]:
    """Log odds of what efforts are that are called "torque", "current" or nothing that says it."""
    sign = {"torque": 1.0, "current": -1.0}.get(called, 0.0)
    prior = sign * float(np.log(NAMED / (1 - NAMED)))
    return {
        TORQUE: prior + float(np.log1p(-BACKWARD)) + sum(gain.torque for gain in every),
        AGAINST: prior + float(np.log(BACKWARD)) + sum(gain.against for gain in every),
        NOT_TORQUE: 0.0,
    }


def gain_guesses(joints: Sequence[str], every: Sequence[Gain]) -> list[Guess]:
    """Each gain that is known, and those that are not together; none where efforts are torques."""
    why, option = "of its sign; size ± 95 %: bodies, friction", "[drive] gain, or a run with a known payload"
    guesses, unknown = [], []
    for joint, gain in zip(joints, every, strict=True) if every else ():
        if not gain.known:
            unknown.append(joint)
            continue
        size = f"{digits(gain.value)} N m ± {digits(100 * NORMAL_95 * gain.relative, 2)} %"
        guesses.append(Guess(f"{GAIN_OF}{joint}", size, max(gain.positive, 1 - gain.positive), why, option))
    if unknown:
        guesses.append(Guess(f"{GAIN_OF}{', '.join(unknown)}", "", 0.0, why, option))
    return guesses


def _as_torque(likely: Likelihood, sign: float) -> float:
    """Log odds that an effort is a torque of a sign, over one of any unit and either sign."""
    exact = mean_of_logs(likely.at(np.exp(EXACT * np.array([-1.0, 0.0, 1.0])), sign))
    others = mean_of_logs(np.concatenate([likely.at(10.0**UNITS, side) for side in (1.0, -1.0)]))
    return max(exact - others, UNLIKE)
