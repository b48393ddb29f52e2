"""Verdict on a fit in plain words, and the center of mass of each payload."""

from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple

import numpy as np

from ..effects import Effect
from ..notebook import counted
from ..plausible.suspicion import CHECK_FIRST, UNLESS
from ..preparation.prepare import ABOVE, SMOOTHED, SMOOTHED_REST
from ..text_table import NORMAL_95, digits
from .agreement import Agreement, Scores
from .edit_test import edit_sentences
from .fit import Fit
from .fit_warnings import OPEN, unknown_scale
from .settled_gains import cure, open_by_gain, open_gains, settled

TO_NOISE = 1.3
"""Residual over noise up to which model errors are smaller than the noise: both add in squares, and
1.3 squared is 1 + 0.83 squared."""
MISSING = 1.5
"""Residual over noise above which model errors (1.1 times the noise) outweigh the noise."""
TESTED = 0.75
"""R^2 below which a joint was not tested, regardless of its noise: the residual rms is then more than half of
the torque's standard deviation. A model without most of the joint's physics would fit nearly as well, and a
residual at the noise floor shows only that there was little but noise to explain."""


class JointState(Enum):
    """How the residual of a joint compares with its noise; the value is that in words."""

    EXPLAINED = "at the noise floor"
    ABOVE_NOISE = "a little above noise"
    FAR_ABOVE = "above noise"
    UNTESTED = "not distinguished from noise"
    UNJUDGED = "not judged"
    NO_MOTOR = "no motor"


REASONS = {
    JointState.UNTESTED: "the motion moves it too little, or the current does not follow the model",
    JointState.UNJUDGED: (
        "the recordings were smoothed, so neither the noise at rest nor the noise at high frequencies "
        "represents the noise during motion"
    ),
}
"""Why a joint is in a state; a verdict states it once for all joints."""
LISTED_AS = {
    JointState.FAR_ABOVE: "More than noise is left on",
    JointState.ABOVE_NOISE: "A little more than noise is left on",
    JointState.UNTESTED: "Not distinguished from noise on",
    JointState.UNJUDGED: "Not judged on",
    JointState.NO_MOTOR: "Without a motor:",
}
"""State of a joint -> beginning of a sentence about several joints in it."""
LISTED = 3
"""Number of unclear parameters named in the verdict; tables list all of them."""
SURPRISE = 3.0
"""Combined standard deviations of prior and estimate beyond which the prior is contradicted: 1 in 370 by
chance."""


class JointVerdict(NamedTuple):
    """Residual over noise of one joint in its worst run, and how that compares with its noise."""

    joint: str
    run: str
    over_noise: float
    state: JointState

    @property
    def words(self) -> str:
        """Its state in words, with the reason if there is one."""
        return ": ".join(filter(None, (self.state.value, REASONS.get(self.state, ""))))


def judged(fit: Fit) -> Sequence[Agreement | Scores]:
    """Runs by which the fit is judged: held-out runs, or else the runs used, with samples if available."""
    return _held_out(fit) or fit.agreement or fit.scores


def _held_out(fit: Fit) -> Sequence[Agreement | Scores]:
    return fit.validation or tuple(run for run in fit.scores if run.held_out)


def joint_verdicts(fit: Fit) -> list[JointVerdict]:
    """One verdict per joint; none if the fit has no comparison with runs."""
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
        state = JointState.NO_MOTOR if passive else _state(over, bool(tested[j]), run.noise_source)
        verdicts.append(JointVerdict(joint, run.run, over, state))
    return verdicts


def verdict(fit: Fit) -> list[str]:
    """Sentences, most important first: doubts about the input, joints, gains, warnings, parameters."""
    joints, gains = _joints(fit), gains_sentence(fit)
    first = (gains, joints) if fit.unscaled else (joints, gains)
    suspicions = [f"{CHECK_FIRST}: {suspicion}. {UNLESS}" for suspicion in fit.suspicions]
    sentences = (
        *suspicions,
        *open_gain_sentences(fit),
        *first,
        *fit.warnings,
        *edit_sentences(fit),
        *_noise(fit),
        *_parameters(fit),
    )
    return list(dict.fromkeys(sentences))  # some are warnings, too


def _noise(fit: Fit) -> list[str]:
    """A sentence if the noise floor is unreliable."""
    sources = {run.noise_source for run in judged(fit)}
    if sources & {SMOOTHED, SMOOTHED_REST}:
        level = "the residual of the fit" if SMOOTHED in sources else "the noise at rest, a lower bound"
        return [
            "The signals were smoothed before they were recorded: their spectrum has no noise near half the "
            f"sampling rate. The noise during motion is unknown; the level shown is {level}. "
            f"Model and runs are compared up to {fit.filtering.torque_cutoff or np.nan:.3g} Hz. "
            "Record unfiltered signals of the drive."
        ]
    if ABOVE not in sources:
        return []
    return [
        "The noise floor is a guess from high frequencies, a lower bound: the noise at the frequencies of "
        "the motion may be higher, and model errors smaller than they seem. Let the arm rest for a second "
        "before it moves."
    ]


def gains_estimated(fit: Fit) -> bool:
    """Whether the fit estimated drive gains rather than using nominal ones."""
    return bool(np.any(fit.estimate.gain_estimated))


def surprises(fit: Fit) -> list[str]:
    """Base parameters far from their nominal values; none if the units of the two differ."""
    if fit.unscaled:
        return []
    nominal, deviation = fit.prior
    combined = np.hypot(deviation, fit.estimate.std)
    far = np.abs(fit.estimate.values - nominal) > SURPRISE * combined
    return [name for name, is_far in zip(fit.names, far, strict=True) if is_far]


def _state(over_noise: float, tested: bool, source: str) -> JointState:
    if source == SMOOTHED or (source == SMOOTHED_REST and over_noise > TO_NOISE):
        return JointState.UNJUDGED
    if over_noise <= TO_NOISE:
        return JointState.EXPLAINED if tested else JointState.UNTESTED
    return JointState.ABOVE_NOISE if over_noise <= MISSING else JointState.FAR_ABOVE


def _joints(fit: Fit) -> str:
    verdicts = joint_verdicts(fit)
    if not verdicts:
        return (
            "The residuals of the joints are unknown: the fit was loaded without samples. "
            "Identify again from the recordings to see them."
        )
    kind = (
        "held-out runs"
        if _held_out(fit)
        else "runs used (no run was held out, so the fit looks better than it is)"
    )
    not_explained = [v for v in verdicts if v.state != JointState.EXPLAINED]
    worst = max(verdicts, key=lambda v: np.nan_to_num(v.over_noise))
    if not not_explained:
        all_joints = {1: "the only joint", 2: "both joints"}.get(len(verdicts), f"all {len(verdicts)} joints")
        return (
            f"The residual of {all_joints} is at the noise floor on the {kind}; the largest is that of "
            f"{worst.joint}, {worst.over_noise:.2f} times its noise."
        )
    if all(v.state == JointState.UNJUDGED for v in verdicts):
        why = REASONS[JointState.UNJUDGED]
        return f"Whether the residual of any joint is at the noise floor is not judged: {why}."
    explained = len(verdicts) - len(not_explained)
    joints = f"{explained} of {len(verdicts)} joints" if explained else "no joint"
    sentences = [_listed(state, not_explained) for state in LISTED_AS]
    above = bool(sentences[0])
    by_scale = fit.measures == "current" and not gains_estimated(fit) and len(verdicts) > 1
    if by_scale and any(v.state in (JointState.FAR_ABOVE, JointState.ABOVE_NOISE) for v in not_explained):
        gains = "The unknown drive gains" if fit.unscaled else "Errors of the nominal drive gains"
        sentences.append(
            f" {gains} alone could cause this: two joints then measure the same link in different scales."
        )
    if above and not fit.unscaled:
        sentences.append(" exidyn diagnose tells whether an effect is missing there.")
    return f"The residual of {joints} is at the noise floor on the {kind}." + "".join(sentences)


def _listed(state: JointState, verdicts: Sequence[JointVerdict]) -> str:
    """One sentence about all joints in a state; empty if there are none."""
    joints = [
        v.joint if state == JointState.NO_MOTOR else f"{v.joint} ({v.over_noise:.1f} x noise)"
        for v in verdicts
        if v.state == state
    ]
    why = f": {REASONS[state]}" if state in REASONS else ""
    return f" {LISTED_AS[state]} {', '.join(joints)}{why}." if joints else ""


def gains_sentence(fit: Fit) -> str:
    """A sentence on the accuracy of the drive gains."""
    if not gains_estimated(fit):
        if fit.unscaled:
            return unknown_scale(fit)[0]
        if fit.measures == "torque":
            return "Torque was recorded and taken as measured, so there are no drive gains to identify."
        return (
            "Drive gains were not identified; the nominal ones were used. An error in a gain scales every "
            "parameter, and every interval includes their stated tolerance. "
            "To identify them, record motor currents and a run with a known payload."
        )
    estimate, free = fit.estimate, open_gains(fit.estimate, fit.model.robot)
    percent = 100.0 * NORMAL_95 * estimate.gain_std / np.abs(estimate.gain)
    if np.all(free):
        return "No drive gain was identified."
    worst = int(np.argmax(np.where(free, 0.0, percent)))
    others = int(np.sum(~free))
    subject = f"The other {counted(others, 'drive gain')}" if np.any(free) else "Drive gains"
    verb = "is" if np.any(free) and others == 1 else "are"
    return (
        f"{subject} {verb} known to ± {digits(percent[~free].min(), 2)} to {digits(percent[worst], 2)} % "
        f"(95 %), worst on {fit.model.robot.joints[worst]}."
    )


def open_gain_sentences(fit: Fit) -> list[str]:
    """Sentences on drive gains that the runs do not determine, what depends on each, and the remedy."""
    robot, estimate = fit.model.robot, fit.estimate
    by_gain, after = open_by_gain(estimate, robot), settled(fit).gain
    sentences = []
    for joint in np.flatnonzero(open_gains(estimate, robot)):
        names = [fit.names[row] for row, gain_joint in by_gain.items() if gain_joint == joint]
        depending = f", nor were {', '.join(names)}, which depend on it" if names else ""
        exported = f" Export and simulation use {digits(after[joint])}, based on its nominal value."
        value, half = digits(estimate.gain[joint]), digits(NORMAL_95 * estimate.gain_std[joint], 2)
        sentences.append(
            f"The drive gain of {robot.joints[joint]} was not identified{depending}: its estimate is {value} "
            f"\N{PLUS-MINUS SIGN} {half} {robot.units('N m')[joint]}/A, because the payload causes hardly "
            f"any torque there.{'' if fit.gains_unstated else exported} What would settle it: "
            f"{cure(robot, int(joint))}."
        )
    return sentences


def _parameters(fit: Fit) -> list[str]:
    was = "was" if len(fit.names) == 1 else "were"
    lines = [f"{counted(len(fit.names), 'base parameter')} {was} identified."]
    if more := len(fit.dropped):
        verb, was = ("is", "was") if more == 1 else ("are", "were")
        lines[0] += f" {more} more {verb} indistinguishable from zero and {was} set to 0."
    if fit.unclear:
        worst = sorted(fit.unclear, key=lambda u: -u.std_percent)
        shown = ", ".join(f"{u.name} ({u.std_percent:.0f} %; {u.hint})" for u in worst[:LISTED])
        more_unclear = f", and {len(worst) - LISTED} more" if len(worst) > LISTED else ""
        lines.append(
            f"Uncertain (relative standard deviation; what would determine it): {shown}{more_unclear}."
        )
    else:
        lines.append(f"The standard deviation of each is at most {OPEN:g} % of its value.")
    lines += _moved_sentences(fit)
    if far := surprises(fit):
        lines.append(f"Far from their nominal values: {', '.join(far)}.")
    return lines


def _moved_sentences(fit: Fit) -> list[str]:
    """A sentence on values that export and simulation change beyond their 95 % interval, and why."""
    if not fit.moved:
        return []
    farthest = sorted(fit.moved, key=lambda moved: -moved.deviations)[:LISTED]
    shown = "; ".join(
        f"{moved.name} {digits(moved.exported)} instead of {digits(moved.value)}, "
        f"{moved.deviations:.1f} standard deviations away"
        for moved in farthest
    )
    more = len(fit.moved) - len(farthest)
    of_gains = " at the drive gains they use" if np.any(open_gains(fit.estimate, fit.model.robot)) else ""
    return [
        f"{counted(len(fit.moved), 'base parameter')} {'is' if len(fit.moved) == 1 else 'are'} physically "
        f"inconsistent, even within the 95 % interval: {_cause(fit)}. Export and simulation use the nearest "
        f"consistent values{of_gains}: {shown}{f'; and {more} more' if more else ''}."
    ]


def _cause(fit: Fit) -> str:
    """What the residuals say about the cause of inconsistent values."""
    above = [
        v.joint for v in joint_verdicts(fit) if v.state in (JointState.FAR_ABOVE, JointState.ABOVE_NOISE)
    ]
    if above:
        return f"the runs contain an effect that the model lacks, as the residual of {', '.join(above)} shows"
    return "no residual shows a missing effect; check geometry and gravity of the description"


def payload_centres(fit: Fit) -> list[str]:
    """A sentence for each payload whose mass is known or identified.

    There is none if drive gains are unknown: first moments in amperes cannot be divided by a mass in
    kilograms.
    """
    sentences = []
    for body in () if fit.unscaled else fit.model.payloads.values():
        mass = _value(fit, body, "M")
        if mass is not None and mass > 0.0:
            axes = [f"{axis.lower()} {_coordinate(fit, body, axis, mass)}" for axis in "XYZ"]
            at = ", ".join(axes)
            weight = _mass_words(fit, f"M{body.payload}", mass)
            sentences.append(
                f"payload {body.payload}: {weight}, center of mass in the flange frame [m]: {at}"
            )
    return sentences


def _mass_words(fit: Fit, name: str, mass: float) -> str:
    """A mass [kg], with half of its 95 % interval if it was estimated."""
    if name not in fit.names:
        return f"{digits(mass)} kg"
    std = float(np.sqrt(fit.estimate.covariance[fit.names.index(name), fit.names.index(name)]))
    return f"{digits(mass)} \N{PLUS-MINUS SIGN} {digits(NORMAL_95 * std, 2)} kg"


def _coordinate(fit: Fit, body: Effect, axis: str, mass: float) -> str:
    """First moment over mass [m], with half of its 95 % interval if either was estimated."""
    moment = _value(fit, body, f"M{axis}")
    if moment is None:
        return "not determined"
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
    """Value of a payload's parameter: known, identified, or zero if dropped; None if known only in a sum."""
    if name in dict(body.known):
        return dict(body.known)[name]
    full_name = f"{name}{body.payload}"
    if full_name in fit.names:
        return float(fit.estimate.values[fit.names.index(full_name)])
    return 0.0 if full_name in fit.dropped else None
