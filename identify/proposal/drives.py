"""Sign and rough size of drive gains: efforts against the torque that the described bodies need."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from ..arm.rigid_regressor import rigid_regressor
from ..arm.robot import Robot
from ..effects.rigid_body import inertial_parameters, inertial_priors
from ..text_table import NORMAL_95, digits
from .agreement import DECIDED, FEWEST, Guess, Sampled, friction_columns, independent

DRAWN = 0.3
"""Relative error of the torque that a description's masses give: a tool, cables, a drawing."""
TOOL_MASS, TOOL_LEVER = 0.05, 0.1
"""What an arm carries unsaid, over its own mass; and how far out, over its own length."""
HEAVY, BALANCED = 300.0, 1.0
"""Mass of an arm [kg] from which on a spring or gas cylinder may hold it against gravity, which no URDF has;
and its torque over that of the bodies, standard deviation."""
TOLD = 0.35
"""Standard deviation of a logarithm up to which a size is known: twice or half is two of them away."""
GAINS = np.logspace(-3, 3, 121)
"""Gains against which a gain of 1, of an effort that is the joint's torque, is weighed [N m per unit]."""
DECADES = np.linspace(-3.0, 3.0, 121)
"""Gains that are weighed where nothing is known of the unit, as powers of ten about the described torque over
the effort, both as standard deviations: that is the gain of a drive that carries nothing but the described
bodies. A gain a thousand times as far is that of another arm."""
WIDE = 3.0
"""Standard deviation of what friction may be, over the effort's own."""
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


def described(robot: Robot) -> bool:
    """Whether the masses of a description are a drawing's, and not one number for all."""
    masses = np.array([inertia.mass for inertia in list(robot.kinematics.inertias)[1:]])
    return bool(masses.sum() > 0 and (len(masses) == 1 or np.ptp(masses) > 0))


def described_values(robot: Robot) -> np.ndarray:
    """Inertial parameters of all links as described, shape (10 n,); zero where masses are one number."""
    values = [inertial_parameters(body) for body in list(robot.kinematics.inertias)[1:]]
    return np.concatenate(values) * described(robot)


def agreed(torque: np.ndarray, log: Sampled) -> float:
    """Log-likelihood of efforts by described torque (t, n) and friction, each drive of the likelier sign."""
    found = 0.0
    for j in range(torque.shape[1]):
        rows = np.flatnonzero(log.sliding[:, j])
        effort = log.effort[rows, j]
        if len(rows) < FEWEST or np.ptp(effort) == 0.0:
            continue
        signed = np.column_stack([torque[rows, j], friction_columns(log.motion, j)[rows]])
        least = min(_left(signed, sign * effort) for sign in (1.0, -1.0))
        found -= 0.5 * independent(effort) * float(np.log(max(least, 1e-3)))
    return found


def gains(robot: Robot, log: Sampled) -> list[Gain]:
    """Gain of each drive.

    Effort = torque of the bodies / gain + rotor, drag and dry friction, which all have the sign of the gain,
    + offset. Size: the bodies are as described but for `DRAWN`, a tool and a balancer. Sign: which of both
    fits better when no term may have the other one.
    """
    bodies = list(robot.kinematics.inertias)[1:]
    values = described_values(robot)
    spread = np.array([prior.std for body in bodies for prior in inertial_priors(body, DRAWN).values()])
    spread[-10:] = np.hypot(spread[-10:], tool(robot))
    rigid = rigid_regressor(robot.kinematics, log.motion)
    heavy = sum(body.mass for body in bodies) > HEAVY
    found = []
    for j in range(robot.dof):
        torque, errors = rigid[:, j] @ values, rigid[:, j] * spread
        if heavy:
            angle = log.motion.position[:, j]
            balancer = BALANCED * torque.std() * np.stack([np.sin(angle), np.cos(angle)], axis=1)
            errors = np.hstack([errors, balancer])
        found.append(_gain(torque, errors, log, j))
    return found


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


def tool(robot: Robot) -> np.ndarray:
    """Standard deviations of what the flange may carry and no description has, in order of `INERTIAL`."""
    bodies, places = list(robot.kinematics.inertias)[1:], list(robot.kinematics.jointPlacements)[2:]
    mass = TOOL_MASS * sum(body.mass for body in bodies)
    lever = TOOL_LEVER * sum(float(np.linalg.norm(place.translation)) for place in places)
    return mass * np.array([lever**2] * 6 + [lever] * 3 + [1.0])


def _gain(torque: np.ndarray, errors: np.ndarray, log: Sampled, joint: int) -> Gain:
    """Gain of a joint from its described torque (t,), and a standard deviation each of its errors (t, k)."""
    rows = np.flatnonzero(log.sliding[:, joint])
    effort = log.effort[rows, joint]
    if len(rows) < FEWEST or np.ptp(effort) == 0.0:
        return Gain()
    torque, errors, friction = torque[rows], errors[rows], friction_columns(log.motion, joint)[rows]
    signed = np.column_stack([torque, friction])
    forward, backward = (_left(signed, sign * effort) for sign in (1.0, -1.0))
    odds = 0.5 * independent(effort) * np.log(backward / forward)
    positive = float(1 / (1 + np.exp(-np.clip(odds, -99, 99))))
    if not np.any(torque):
        return Gain(positive=positive)
    noise = max(min(forward, backward), 0.01) * effort.var() * len(rows) / independent(effort)
    sign = 1.0 if positive > 0.5 else -1.0
    weighed = torque.std() / effort.std() * 10.0**DECADES
    likely = _log_likelihood(sign * effort, torque, errors, friction, noise, [1.0, *GAINS, *weighed])
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


def _log_likelihood(
    effort: np.ndarray,
    torque: np.ndarray,
    errors: np.ndarray,
    friction: np.ndarray,
    noise: float,
    weighed: Sequence[float],
) -> np.ndarray:
    """Log-likelihood of each of the gains `weighed`, up to a constant.

    Args:
        effort: Shape (t,).
        torque: Torque of the bodies as described, shape (t,).
        errors: Torque of one standard deviation of each of their parameters, shape (t, k).
        friction: Shape (t, 3).
        noise: Variance of a sample, as if samples were independent.
        weighed: Gains [N m per unit].
    """
    free = np.column_stack([friction, np.ones(len(effort))])
    free *= WIDE * effort.std() / np.maximum(np.sqrt((free**2).mean(axis=0)), 1e-12)
    reduced = np.asarray(np.linalg.qr(np.column_stack([errors, free, torque, effort]), mode="r"))
    k = errors.shape[1]
    bodies, wide = reduced[:, :k] @ reduced[:, :k].T, reduced[:, k:-2] @ reduced[:, k:-2].T
    found = []
    for gain in weighed:
        covariance = noise * np.eye(len(reduced)) + wide + bodies / gain**2
        miss = reduced[:, -1] - reduced[:, -2] / gain
        _, size = np.linalg.slogdet(covariance)
        found.append(-0.5 * (size + miss @ np.linalg.solve(covariance, miss)))
    return np.array(found)


def _left(columns: np.ndarray, effort: np.ndarray) -> float:
    """Share of the variance left by coefficients that are not negative, beside a free offset."""
    scaled = (columns - columns.mean(axis=0)) / np.maximum(columns.std(axis=0), 1e-12)
    left = nnls(scaled, effort - effort.mean())[1]
    return max(float(left**2 / ((effort - effort.mean()) ** 2).sum()), 1e-6)
