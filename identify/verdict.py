"""The verdict on a fit in plain words."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .fit import Agreement, Fit

NORMAL_95 = 1.96
"""Deviations on each side of a value within which it lies with 95 % probability."""
TO_NOISE = 1.3
"""Residual over noise up to which nothing can be missing but less than the noise itself: what remains
adds in squares, and 1.3 squared is 1 + 0.83 squared."""
MISSING = 1.5
"""Residual over noise above which what is missing (1.1 noises) outweighs the noise itself."""
LISTED = 3
"""Unclear parameters named in the verdict; tables have the rest."""
SURPRISE = 3.0
"""Deviations, of belief and estimate together, from which a belief no longer fits: one in 370 by chance."""


class JointVerdict(NamedTuple):
    """How well one joint is explained in the run in which it is explained worst.

    Attributes:
        joint: Its name.
        run: Where it is explained worst.
        over_noise: Residual over noise floor [-].
        words: What to think of it.
    """

    joint: str
    run: str
    over_noise: float
    words: str


def judged(fit: Fit) -> Sequence[Agreement]:
    """Runs that count: those held out, or else those used."""
    return fit.validation or fit.agreement


def joint_verdicts(fit: Fit) -> list[JointVerdict]:
    """One a joint; none if the fit came without samples."""
    runs = judged(fit)
    if not runs:
        return []
    ratios = np.array([run.over_noise for run in runs])
    worst = np.argmax(ratios, axis=0)
    return [
        JointVerdict(joint, runs[worst[j]].run, float(ratios[worst[j], j]), _words(ratios[worst[j], j]))
        for j, joint in enumerate(fit.model.robot.joints)
    ]


def verdict(fit: Fit) -> list[str]:
    """Sentences, the most important first: the joints, the gains, the parameters, the doubts."""
    return [_joints(fit), gains_sentence(fit), *_parameters(fit), *fit.doubts]


def gains_estimated(fit: Fit) -> bool:
    """Whether the fit found the drive gains, rather than taking them as believed."""
    return bool(np.any(fit.estimate.gain_std > 0.0))


def surprises(fit: Fit) -> list[str]:
    """Base parameters that came out far from what was believed."""
    believed, deviation = fit.believed
    both = np.hypot(deviation, fit.estimate.std)
    far = np.abs(fit.estimate.values - believed) > SURPRISE * both
    return [name for name, is_far in zip(fit.names, far, strict=True) if is_far]


def _words(over_noise: float) -> str:
    if over_noise <= TO_NOISE:
        return "explained to its noise"
    return "a little is missing" if over_noise <= MISSING else "physics is missing"


def _joints(fit: Fit) -> str:
    found = joint_verdicts(fit)
    if not found:
        return (
            "How well the joints are explained cannot be said: this fit was loaded without its samples. "
            "Identify again from the recordings to see it."
        )
    kind = "runs held out" if fit.validation else "runs used (no run was held out: this flatters the fit)"
    open_ones = [
        f"{v.joint} ({v.over_noise:.1f} x noise: {v.words})" for v in found if v.over_noise > TO_NOISE
    ]
    worst = max(found, key=lambda v: v.over_noise)
    if not open_ones:
        return (
            f"All {len(found)} joints are explained to their noise on the {kind}; the worst is "
            f"{worst.joint} with {worst.over_noise:.2f} times its noise."
        )
    fine = len(found) - len(open_ones)
    return (
        f"{fine} of {len(found)} joints are explained to their noise on the {kind}. "
        f"Not so: {', '.join(open_ones)}."
    )


def gains_sentence(fit: Fit) -> str:
    """How well the drive gains are known."""
    if not gains_estimated(fit):
        if np.all(fit.estimate.gain == 1.0):
            return "Drive gains are all taken as 1: what was recorded counts as torque, or none were stated."
        return (
            "Drive gains are as believed, not measured: an error in them is an error of every parameter. "
            "Finding them needs motor currents and a run with a known payload."
        )
    percent = 100.0 * fit.estimate.gain_std / np.abs(fit.estimate.gain)
    worst = int(np.argmax(percent))
    return (
        f"Drive gains are known to {percent.min():.2g} to {percent.max():.2g} % (one standard deviation), "
        f"worst on {fit.model.robot.joints[worst]}."
    )


def _parameters(fit: Fit) -> list[str]:
    lines = [f"{len(fit.names)} base parameters were identified."]
    if fit.dropped:
        lines[0] += f" {len(fit.dropped)} more are not supported by the data and were set to zero."
    if fit.unclear:
        lines.append(f"Unclear (standard deviation; what would settle it): {_unclear(fit)}.")
    else:
        lines.append("None of them is unclear.")
    if far := surprises(fit):
        lines.append(f"Far from what was believed: {', '.join(far)}.")
    return lines


def _unclear(fit: Fit) -> str:
    worst = sorted(fit.unclear, key=lambda u: -u.std_percent)
    shown = [f"{u.name} ({u.std_percent:.0f} %; {u.hint})" for u in worst[:LISTED]]
    more = len(worst) - len(shown)
    return ", ".join(shown) + (f", and {more} more" if more else "")
