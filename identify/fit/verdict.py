"""The verdict on a fit in plain words, and where the centre of mass of each payload is."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..effects import Effect
from ..notebook import counted as counted
from ..plausible.suspicion import CHECK_FIRST, UNLESS
from ..preparation.prepare import ABOVE, SMOOTHED, SMOOTHED_REST
from ..text_table import NORMAL_95, digits
from .agreement import Agreement, Scores
from .edit_test import edit_sentences
from .fit import Fit
from .fit_warnings import OPEN, unknown_scale
from .settled_gains import cure, open_by_gain, open_gains, settled

TO_NOISE = 1.3
"""Residual over noise up to which nothing can be missing but less than the noise itself: what remains
adds in squares, and 1.3 squared is 1 + 0.83 squared."""
MISSING = 1.5
"""Residual over noise above which what is missing (1.1 noises) outweighs the noise itself."""
TESTED = 0.75
"""R^2 below which a joint was not tested, whatever its noise: the residual is then more than half of what
the torque varies by, root mean square. A model without most of the joint's physics would do nearly as well,
and a residual at the noise floor shows only that there was little else than noise to explain."""
EXPLAINED, ABOVE_NOISE, FAR_ABOVE = "at the noise floor", "a little above noise", "above noise"
UNTESTED = (
    "not distinguished from noise: the motion moves it too little, or the current does not follow the model"
)
UNJUDGED = (
    "not judged: the recordings were smoothed, and neither their noise at rest nor that above the motion is "
    "that of the motion"
)
NO_MOTOR = "no motor"
LISTED_AS = {
    FAR_ABOVE: "More than noise is left on",
    ABOVE_NOISE: "A little more than noise is left on",
    UNTESTED: "Not distinguished from noise on",
    UNJUDGED: "Not judged on",
    NO_MOTOR: "Without a motor:",
}
"""Words about a joint -> how a sentence about several joints begins."""
LISTED = 3
"""Unclear parameters named in the verdict; tables have the rest."""
SURPRISE = 3.0
"""Deviations, of prior and estimate together, from which a prior no longer fits: one in 370 by chance."""


class JointVerdict(NamedTuple):
    """How well one joint is explained in the run in which it is explained worst, and what to think of it."""

    joint: str
    run: str
    over_noise: float
    words: str


def judged(fit: Fit) -> Sequence[Agreement | Scores]:
    """Runs that count: those held out, or else those used; with their samples where there are any."""
    return _held_out(fit) or fit.agreement or fit.scores


def _held_out(fit: Fit) -> Sequence[Agreement | Scores]:
    return fit.validation or tuple(one for one in fit.scores if one.held_out)


def joint_verdicts(fit: Fit) -> list[JointVerdict]:
    """One a joint; none if the fit came without samples."""
    runs = judged(fit)
    if not runs:
        return []
    verdicts = []
    ratios = np.array([run.over_noise for run in runs])
    worst = np.argmax(ratios, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):  # a joint that never slides has no R^2
        tested = np.any([run.r_squared >= TESTED for run in runs], axis=0)
    for j, joint in enumerate(fit.model.robot.joints):
        run, over = runs[worst[j]], float(ratios[worst[j], j])
        passive = joint in fit.model.robot.passive
        words = NO_MOTOR if passive else _words(over, bool(tested[j]), run.noise_source)
        verdicts.append(JointVerdict(joint, run.run, over, words))
    return verdicts


def verdict(fit: Fit) -> list[str]:
    """Sentences, the most important first: doubts about the input, joints, gains, parameters, warnings."""
    joints, gains = _joints(fit), gains_sentence(fit)
    first = (gains, joints) if fit.unscaled else (joints, gains)
    suspicions = [f"{CHECK_FIRST}: {suspicion}. {UNLESS}" for suspicion in fit.suspicions]
    sentences = (
        *suspicions,
        *open_gain_sentences(fit),
        *first,
        *edit_sentences(fit),
        *_noise(fit),
        *_parameters(fit),
        *fit.warnings,
    )
    return list(dict.fromkeys(sentences))  # a warning that is a sentence of its own is not repeated


def _noise(fit: Fit) -> list[str]:
    """Whether the noise floor is one."""
    sources = {run.noise_source for run in judged(fit)}
    if sources & {SMOOTHED, SMOOTHED_REST}:
        level = "its own residual" if SMOOTHED in sources else "the noise of the rest, which is a lower bound"
        return [
            "The recordings were smoothed before they were recorded: their spectrum has no noise near half "
            f"the sample rate. The noise of the motion is not known; the level that is given is {level}. "
            f"They are compared up to {fit.filtering.torque_cutoff or np.nan:.3g} Hz. "
            "Record what the drive measures, without a filter."
        ]
    if ABOVE not in sources:
        return []
    return [
        "The noise floor is a guess from high frequencies, a lower bound: the noise at those of the motion "
        "may be higher, and less be missing than it seems. Let the arm rest a second before it moves."
    ]


def gains_estimated(fit: Fit) -> bool:
    """Whether the fit found the drive gains, rather than taking the nominal ones."""
    return bool(np.any(fit.estimate.gain_estimated))


def surprises(fit: Fit) -> list[str]:
    """Base parameters that came out far from their nominal values; none where units of the two differ."""
    if fit.unscaled:
        return []
    nominal, deviation = fit.prior
    both = np.hypot(deviation, fit.estimate.std)
    far = np.abs(fit.estimate.values - nominal) > SURPRISE * both
    return [name for name, is_far in zip(fit.names, far, strict=True) if is_far]


def _words(over_noise: float, tested: bool, source: str) -> str:
    if source == SMOOTHED or (source == SMOOTHED_REST and over_noise > TO_NOISE):
        return UNJUDGED
    if over_noise <= TO_NOISE:
        return EXPLAINED if tested else UNTESTED
    return ABOVE_NOISE if over_noise <= MISSING else FAR_ABOVE


def _joints(fit: Fit) -> str:
    found = joint_verdicts(fit)
    if not found:
        return (
            "How well the joints are explained is unknown: this fit was loaded without its samples. "
            "Identify again from the recordings to see it."
        )
    kind = "runs held out" if _held_out(fit) else "runs used (no run was held out: this flatters the fit)"
    open_ones = [v for v in found if v.words != EXPLAINED]
    worst = max(found, key=lambda v: np.nan_to_num(v.over_noise))
    if not open_ones:
        every = {1: "the one joint", 2: "both joints"}.get(len(found), f"all {len(found)} joints")
        return (
            f"The residual of {every} is at the noise floor on the {kind}; the largest is that of "
            f"{worst.joint} with {worst.over_noise:.2f} times its noise."
        )
    if all(v.words == UNJUDGED for v in found):
        _, _, why = UNJUDGED.partition(": ")
        return f"Whether the residual of any joint is at the noise floor is not judged: {why}."
    fine = len(found) - len(open_ones)
    which = f"{fine} of {len(found)} joints" if fine else "no joint"
    sentences = [_listed(words, open_ones) for words in LISTED_AS]
    above = bool(sentences[0])
    by_scale = fit.measures == "current" and not gains_estimated(fit) and len(found) > 1
    if by_scale and any(v.words in (FAR_ABOVE, ABOVE_NOISE) for v in open_ones):
        which_gains = "the unknown drive gains" if fit.unscaled else "errors of the nominal drive gains"
        sentences.append(
            f" That may be {which_gains} alone: two joints then feel one link in different scales."
        )
    if above:
        sentences.append(" exidyn diagnose tells whether an effect is missing there.")
    return f"The residual of {which} is at the noise floor on the {kind}." + "".join(sentences)


def _listed(words: str, found: Sequence[JointVerdict]) -> str:
    """One sentence for all joints for which the same holds; empty if there are none."""
    joints = [
        v.joint if words == NO_MOTOR else f"{v.joint} ({v.over_noise:.1f} x noise)"
        for v in found
        if v.words == words
    ]
    _, colon, why = words.partition(":")
    return f" {LISTED_AS[words]} {', '.join(joints)}{colon}{why}." if joints else ""


def gains_sentence(fit: Fit) -> str:
    """How well the drive gains are known."""
    if not gains_estimated(fit):
        if fit.unscaled:
            return unknown_scale(fit)[0]
        if fit.measures == "torque":
            return "Torque was recorded, and taken as measured; there are no drive gains to find."
        return (
            "Drive gains are nominal, not measured: an error in them is an error of every parameter, and "
            "what they are stated to be off by is in every interval. "
            "Finding them needs motor currents and a run with a known payload."
        )
    estimate, free = fit.estimate, open_gains(fit.estimate, fit.model.robot)
    percent = 100.0 * NORMAL_95 * estimate.gain_std / np.abs(estimate.gain)
    if np.all(free):
        return "No drive gain was identified."
    worst = int(np.argmax(np.where(free, 0.0, percent)))
    others = int(np.sum(~free))
    which = f"The other {counted(others, 'drive gain')}" if np.any(free) else "Drive gains"
    verb = "is" if np.any(free) and others == 1 else "are"
    return (
        f"{which} {verb} known to ± {digits(percent[~free].min(), 2)} to {digits(percent[worst], 2)} % "
        f"(95 %), worst on {fit.model.robot.joints[worst]}."
    )


def open_gain_sentences(fit: Fit) -> list[str]:
    """The drive gains that the runs leave open, what is open with each, and what would settle it."""
    robot, estimate = fit.model.robot, fit.estimate
    by_gain, after = open_by_gain(estimate, robot), settled(fit).gain
    sentences = []
    for joint in np.flatnonzero(open_gains(estimate, robot)):
        names = [fit.names[row] for row, of in by_gain.items() if of == joint]
        depending = f", nor are {', '.join(names)}, which depend on it" if names else ""
        taken = f" Export and simulation take {digits(after[joint])}, by its nominal value."
        found, half = digits(estimate.gain[joint]), digits(NORMAL_95 * estimate.gain_std[joint], 2)
        sentences.append(
            f"The drive gain of {robot.joints[joint]} was not identified{depending}: it came out as {found} "
            f"\N{PLUS-MINUS SIGN} {half} {robot.units('N m')[joint]}/A, since the payload makes hardly any "
            f"torque there.{'' if fit.gains_unstated else taken} What would settle it: "
            f"{cure(robot, int(joint))}."
        )
    return sentences


def _parameters(fit: Fit) -> list[str]:
    was = "was" if len(fit.names) == 1 else "were"
    lines = [f"{counted(len(fit.names), 'base parameter')} {was} identified."]
    if more := len(fit.dropped):
        lines[0] += f" {more} more {'is' if more == 1 else 'are'} not supported by the data and set to zero."
    if fit.unclear:
        worst = sorted(fit.unclear, key=lambda u: -u.std_percent)
        shown = ", ".join(f"{u.name} ({u.std_percent:.0f} %; {u.hint})" for u in worst[:LISTED])
        rest = f", and {len(worst) - LISTED} more" if len(worst) > LISTED else ""
        lines.append(f"Unclear (standard deviation; what would settle it): {shown}{rest}.")
    else:
        lines.append(f"The standard deviation of each is at most {OPEN:g} % of its value.")
    lines += _moved_sentences(fit)
    if far := surprises(fit):
        lines.append(f"Far from their nominal values: {', '.join(far)}.")
    return lines


def _moved_sentences(fit: Fit) -> list[str]:
    """Whether export and simulation take other values than the data say, beyond their 95 %, and why."""
    if not fit.moved:
        return []
    farthest = sorted(fit.moved, key=lambda one: -one.deviations)[:LISTED]
    shown = "; ".join(
        f"{one.name} {digits(one.exported)} for {digits(one.value)}, {one.deviations:.1f} deviations away"
        for one in farthest
    )
    more = len(fit.moved) - len(farthest)
    of_gains = (
        " or that go with the drive gains that are taken"
        if np.any(open_gains(fit.estimate, fit.model.robot))
        else ""
    )
    return [
        f"No arm can have the values of {counted(len(fit.moved), 'base parameter')} within their 95 %: "
        "something is in them that is no noise and no part of the model. Export and "
        f"simulation take the nearest values that an arm can have{of_gains}: {shown}"
        f"{f'; and {more} more' if more else ''}."
    ]


def payload_centres(fit: Fit) -> list[str]:
    """A sentence for each body whose mass is known or identified.

    None where first moments are per unit of drive gain: a mass in kilograms does not divide those.
    """
    sentences = []
    for body in () if fit.unscaled else fit.model.payloads.values():
        mass = _value(fit, body, "M")
        if mass is not None and mass > 0.0:
            axes = [f"{axis.lower()} {_coordinate(fit, body, axis, mass)}" for axis in "XYZ"]
            at = ", ".join(axes)
            weight = _mass_words(fit, f"M{body.payload}", mass)
            sentences.append(
                f"payload {body.payload}: {weight}, center of mass in the flange's frame [m]: {at}"
            )
    return sentences


def _mass_words(fit: Fit, name: str, mass: float) -> str:
    """A mass [kg], with half of its 95 % interval where it was estimated."""
    if name not in fit.names:
        return f"{digits(mass)} kg"
    std = float(np.sqrt(fit.estimate.covariance[fit.names.index(name), fit.names.index(name)]))
    return f"{digits(mass)} \N{PLUS-MINUS SIGN} {digits(NORMAL_95 * std, 2)} kg"


def _coordinate(fit: Fit, body: Effect, axis: str, mass: float) -> str:
    """First moment over mass, with its standard deviation where either was estimated."""
    moment = _value(fit, body, f"M{axis}")
    if moment is None:
        return "open"
    if f"M{axis}{body.payload}" in fit.dropped:
        return "0 (dropped)"
    slope = np.zeros(len(fit.names))
    for name, derivative in ((f"M{axis}", 1.0 / mass), ("M", -moment / mass**2)):
        if f"{name}{body.payload}" in fit.names:
            slope[fit.names.index(f"{name}{body.payload}")] = derivative
    std = float(np.sqrt(slope @ fit.estimate.covariance[: len(slope), : len(slope)] @ slope))
    return digits(moment / mass) + (
        f" \N{PLUS-MINUS SIGN} {digits(NORMAL_95 * std, 2)}" if std else " (known)"
    )


def _value(fit: Fit, body: Effect, name: str) -> float | None:
    """A parameter of the body: as known, as identified alone, zero if dropped; None if only in a sum."""
    if name in dict(body.known):
        return dict(body.known)[name]
    own = f"{name}{body.payload}"
    if own in fit.names:
        return float(fit.estimate.values[fit.names.index(own)])
    return 0.0 if own in fit.dropped else None
