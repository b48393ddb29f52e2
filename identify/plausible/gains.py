"""Sign and approximate size of drive gains from efforts and the torque of the described bodies."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from ..arm.robot import Robot
from ..model import Model
from ..recordings.recording import Recording
from ..text_table import NORMAL_95, digits
from .described_bodies import ANY, KINDS, Likelihood, mean_of_logs
from .evidence import Reading
from .samples import MOST, joined, sampled_torques
from .suspicion import DECIDED, Guess

TELLS = 0.35
"""Standard deviation of the logarithm up to which a size counts as known: a factor of two is two of them."""
UNDECIDED = 1.0
"""Relative standard deviation of an undecided gain: zero and twice the value are one of it away. A gain that
the log determines less well is not proposed."""
EXACT = 0.1
"""Standard deviation of the log ratio of measured and true torque: sensors are calibrated."""
UNLIKE = float(np.log(0.05))
"""Lower limit of one joint's evidence against torques: the description may lack a spring or a tool."""
GAIN_OF = "gain of "
"""Beginning of the question that a guess of gains answers."""
UNITS = np.linspace(-3.0, 3.0, 61)
"""Possible units of an effort, as powers of ten in N m."""


TORQUE, AGAINST, NOT_TORQUE = "N m of the joint", "N m against the joint", "not N m: needs gain"
"""Possible meanings of efforts."""
NAMED = 0.99
"""Probability that efforts called torques or currents are what the name says."""
BACKWARD = 0.02
"""Probability that the torques of all joints in a log have the opposite sign of the positions."""


class Gain(NamedTuple):
    """Estimate of one drive gain from a log."""

    value: float = np.nan  # torque per unit of effort, with its sign; NaN if the log does not determine it
    relative: float = np.inf  # standard deviation of its logarithm [-]
    positive: float = 0.5  # probability that the effort has the sign of the joint torque
    torque: float = 0.0  # log odds that the effort is the joint torque [N m], over any other unit and sign
    against: float = 0.0  # log odds that the effort is the joint torque with the opposite sign

    @property
    def known(self) -> bool:
        """Whether both sign and size are certain enough to be written to a file."""
        return self.proposed and self.relative <= TELLS

    @property
    def proposed(self) -> bool:
        """Whether the sign is certain enough, and the size known to within its standard deviation."""
        sure = max(self.positive, 1 - self.positive) >= DECIDED
        return bool(np.isfinite(self.value) and self.relative <= UNDECIDED and sure)


def gains(reading: Reading) -> list[Gain]:
    """Gain of each drive."""
    return [gain_of(likely) for likely in reading.likelihoods]


def gains_by_masses(runs: Sequence[Recording], model: Model) -> list[Gain]:
    """Gains that the described masses make likely for currents; empty if stated or if none is likely."""
    _, logs, stated = sampled_torques(runs, model.robot)
    if stated or not logs:
        return []
    drives = gains(Reading(model, joined(logs).thinned(MOST), stated))
    return drives if any(gain.proposed for gain in drives) else []


def masses_sentence(drives: Sequence[Gain], robot: Robot) -> str:
    """A sentence on gains that the described masses make likely."""
    rows = zip(robot.joints, drives, robot.units("N m/A"), strict=True)
    likely = [
        f"{joint} {digits(gain.value, 3)} {unit} ± {digits(100 * NORMAL_95 * gain.relative, 2)} %"
        for joint, gain, unit in rows
        if gain.proposed
    ]
    return f"gains by the described masses (95 %): {', '.join(likely)}"


def stated_gains(gains: Sequence[Gain]) -> tuple[list[float], list[float]]:
    """Gains and their relative standard deviations; those that are not proposed have `UNDECIDED`.

    A gain that is not proposed is the geometric mean of the others: its own size in the log is too large
    rather than too small, since friction explains most of such an effort.
    """
    proposed = [gain.value for gain in gains if gain.proposed]
    usual, majority = (
        float(np.exp(np.mean(np.log(np.abs(proposed))))),
        float(np.sign(np.sum(np.sign(proposed)))),
    )
    signs = [np.sign(gain.positive - 0.5) or majority or 1.0 for gain in gains]
    values = [gain.value if gain.proposed else sign * usual for gain, sign in zip(gains, signs, strict=True)]
    spread = [max(gain.relative, 0.01) if gain.proposed else UNDECIDED for gain in gains]
    return [float(f"{value:.4g}") for value in values], [float(f"{share:.2f}") for share in spread]


def with_gains(model: Model, drives: Sequence[Gain]) -> Model:
    """Model with these drive gains and their tolerances."""
    gain, tolerance = (np.array(numbers) for numbers in stated_gains(drives))
    return replace(model, robot=replace(model.robot, drive_gain=gain, drive_gain_tolerance=tolerance))


def gain_of(likely: Likelihood) -> Gain:
    """Gain of one drive from the likelihood of its joint."""
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
    if int(np.argmax(better)) in (0, len(better) - 1):  # the maximum is outside the range of gains
        return Gain(positive=positive, torque=torque, against=against)
    return Gain(float(np.sign(odds) * np.exp(middle)), relative, positive, torque, against)


def _by_masses(likely: Likelihood, sign: float) -> np.ndarray:
    """Log-likelihood of typical gains with a given sign, for masses that are informative, shape (g,)."""
    if not likely.described:
        return likely.at(likely.gains, sign, ANY)
    kinds = [
        np.log(kind.probability) + likely.at(likely.gains, sign, kind) for kind in KINDS if kind.described
    ]
    return np.asarray(np.logaddexp.reduce(kinds))


def effort_odds(drives: Sequence[Gain], called: str) -> dict[str, float]:
    """Log odds of each meaning of efforts; `called` is "torque", "current", or another name."""
    sign = {"torque": 1.0, "current": -1.0}.get(called, 0.0)
    prior = sign * float(np.log(NAMED / (1 - NAMED)))
    return {
        TORQUE: prior + float(np.log1p(-BACKWARD)) + sum(gain.torque for gain in drives),
        AGAINST: prior + float(np.log(BACKWARD)) + sum(gain.against for gain in drives),
        NOT_TORQUE: 0.0,
    }


STATED_BY = "[drive] gain, or a run with a known payload"
DATA_SHEET = (
    "[drive] gain, the torque constant of the motor [N m/A] times the gear ratio, both on their data sheets; "
    "or a run with a known payload"
)
"""How a person states a drive gain that is proposed, and one that is not."""


def gain_guesses(joints: Sequence[str], drives: Sequence[Gain]) -> list[Guess]:
    """Guesses of known gains, of proposed ones, and one for all others; none if efforts are torques."""
    named = list(zip(joints, drives, strict=True)) if drives else []
    guesses = [_size_guess(joint, gain) for joint, gain in named if gain.known]
    guesses += [_size_guess(joint, gain) for joint, gain in named if gain.proposed and not gain.known]
    if unknown := [joint for joint, gain in named if not gain.proposed]:
        guesses.append(Guess(f"{GAIN_OF}{', '.join(unknown)}", "", 0.0, "", DATA_SHEET))
    return guesses


def _size_guess(joint: str, gain: Gain) -> Guess:
    """Guess of a gain: of its sign if its size is known, else that it is within a factor of two."""
    why, size = "of its sign; size ± 95 %: bodies, friction", digits(gain.value)
    sign = max(gain.positive, 1 - gain.positive)
    if gain.known:
        half = digits(100 * NORMAL_95 * gain.relative, 2)
        return Guess(f"{GAIN_OF}{joint}", f"{size} N m ± {half} %", sign, why, STATED_BY)
    within = float(2.0 * norm.cdf(np.log(2.0) / gain.relative) - 1.0)
    words = f"{size} N m within a factor of 2, by the described masses"
    return Guess(f"{GAIN_OF}{joint}", words, min(sign * within, DECIDED), why, STATED_BY)


def _as_torque(likely: Likelihood, sign: float) -> float:
    """Log odds that an effort is a torque [N m] with a given sign, over any unit and sign."""
    exact = mean_of_logs(likely.at(np.exp(EXACT * np.array([-1.0, 0.0, 1.0])), sign))
    others = mean_of_logs(np.concatenate([likely.at(10.0**UNITS, side) for side in (1.0, -1.0)]))
    return max(exact - others, UNLIKE)
