"""Verdict: the cause, how much better the model is with it, and what to do next, in three sentences."""

import numpy as np

from ...fit.verdict import TO_NOISE
from ...plausible.suspicion import CHECK_FIRST
from ...text_table import digits, percent
from ..candidates import kind_of
from ..findings.adequacy import Adequacy
from ..findings.diagnosis import Diagnosis
from ..findings.finding import Finding
from ..improved.improved import FOUND
from .importance import Residuals, clearest_joint, important, residuals
from .limits import departure_sentence, suspicion_sentences
from .measures import slides
from .naming import effect_words, joined, joint_words, joints_words, lower, named
from .sentences import dependence, moment_sentence, possible, sentence, span, undecided_sentence

WORSE = 1.02
"""Residual with findings over that without, above which a joint counts as worse; see `search/checks.py`."""
AS_DESCRIBED = "With the bodies as described, "
VALIDATE = "Next: record another motion and give it as --validate RUN"
CHECK = "Next: exidyn init LOG --robot DESCRIPTION, which compares columns, units and signs with the arm."


def verdict(diagnosis: Diagnosis, folder: str = "") -> list[str]:
    """Three sentences: the cause, the improvement on held-out data, and the next step."""
    first = next(iter(important(diagnosis)), None)
    return [_cause(diagnosis, first), _improvement(diagnosis, first), _next(diagnosis, first, folder)]


def _cause(diagnosis: Diagnosis, first: Finding | None) -> str:
    if diagnosis.adequacy is not None and diagnosis.adequacy.failing:
        return _inadequate(diagnosis, diagnosis.adequacy)
    if _doubtful(diagnosis):
        return suspicion_sentences(diagnosis)[0]
    if first is not None:
        return finding_sentence(diagnosis, first)
    if diagnosis.beliefs is not None and diagnosis.beliefs.departures:
        return departure_sentence(diagnosis, diagnosis.beliefs.departures[0])
    if diagnosis.remainders:
        places = [
            f"{lower(joint_words(remainder.joint, diagnosis.joints))} ({dependence(remainder.depends_on)})"
            for remainder in diagnosis.remainders
        ]
        return f"Something is missing that is none of the effects that exidyn knows, on {joined(places)}."
    if diagnosis.moments:
        return moment_sentence(diagnosis.moments[0])
    return _nothing(diagnosis)


def _nothing(diagnosis: Diagnosis) -> str:
    """Sentence for a diagnosis that explains nothing, which may be because nothing is missing."""
    known, cause = residuals(diagnosis), "the residual depends on no recorded quantity"
    if diagnosis.all_findings:
        cause = "no finding explains a part of a joint's residual"
    elif known is not None and known.held_out and diagnosis.noise_measured_at_rest:
        if np.all(known.after <= TO_NOISE * diagnosis.noise):
            within = ", with parameters and drive gains within their tolerances" if diagnosis.beliefs else ""
            return f"Nothing is missing{within}: the residual of every joint is at the noise floor."
    return f"No missing effect is certain: {cause}."


def _doubtful(diagnosis: Diagnosis) -> bool:
    """Whether a mistake in the input is suspected, and adequacy was not asked, which decides otherwise."""
    return bool(diagnosis.suspicions) and diagnosis.adequacy is None


def finding_sentence(diagnosis: Diagnosis, finding: Finding) -> str:
    """A finding as a sentence, with its hypotheses if it is undecided, and its belief if it depends on it."""
    if finding in diagnosis.undecided:
        text = undecided_sentence(finding, diagnosis.joints)
    else:
        text = f"{sentence(finding, diagnosis.joints, slides(diagnosis, finding))}."
    beliefs = diagnosis.beliefs
    conditional = beliefs is not None and diagnosis.all_findings.index(finding) in beliefs.conditional
    return AS_DESCRIBED + lower(text) if conditional else text


def _inadequate(diagnosis: Diagnosis, adequacy: Adequacy) -> str:
    """Joints that do not fit as correct recordings do: an error of the input, or a location."""
    failing = list(adequacy.failing)
    where = joints_words(failing, diagnosis.joints)
    of_torque = joined([percent(share) for share in adequacy.shares[failing]])
    if len(failing) == 1:
        misfits = [m for m in adequacy.misfits if m.joint == failing[0]]
        most = joined([f"{misfit.run} at {span(misfit)}" for misfit in misfits]) if misfits else ""
        located = f", most of it in {most}" if most else ""
        return (
            f"{where[:1].upper()}{where[1:]} does not fit as correct recordings do: its residual is "
            f"{of_torque} of its torque{located}; no effect is named there."
        )
    alone = joined([percent(share) for share in adequacy.shares_alone[failing]])
    apart = np.all(2.0 * adequacy.shares_alone[failing] < adequacy.shares[failing])
    each = f"; each fits by itself ({alone}), together they do not" if apart else ""
    return (
        f"{CHECK_FIRST} (columns, units, description): {where} do not fit as correct recordings do; their "
        f"residuals are {of_torque} of their torques{each}."
    )


def _improvement(diagnosis: Diagnosis, first: Finding | None) -> str:
    """Sentence on the residual of the clearest joint, of all joints together, and of those that get worse."""
    if (known := residuals(diagnosis)) is None:
        return "No residual was computed."
    data = "On held-out data" if known.held_out else "No run was held out; in blocks that the others predict"
    if first is None:
        return f"{data}, {_remaining(diagnosis, known)}."
    ratios = known.after / np.maximum(known.before, 1e-300)
    joint, count = clearest_joint(diagnosis, first), len(ratios)
    where = lower(joint_words(joint, diagnosis.joints))
    before, after = digits(known.before[joint], 3), digits(known.after[joint], 3)
    text = (
        f"{data}, the residual of {where} {'falls' if ratios[joint] < 1.0 else 'rises'} from {before} to "
        f"{after} {diagnosis.torque_units[joint]} ({change_words(ratios[joint])})"
    )
    if count > 1:
        text += f"; all joints on average: {change_words(float(np.exp(np.mean(np.log(ratios)))))}"
    worse = [other for other in range(count) if ratios[other] > WORSE]
    if worse:
        text += f"; {joints_words(worse, diagnosis.joints)} up to {change_words(float(np.max(ratios)))}"
    return f"{text}."


def change_words(ratio: float) -> str:
    """Relative change of a residual, such as "92 % less" or "3 % more"."""
    return f"{percent(abs(ratio - 1.0))} {'less' if ratio < 1.0 else 'more'}"


def _remaining(diagnosis: Diagnosis, known: Residuals) -> str:
    """The largest residual over noise if that was measured, else in its unit."""
    over_noise = known.after / diagnosis.noise
    worst = int(np.argmax(over_noise))
    where = f"on {lower(joint_words(worst, diagnosis.joints))}"
    if diagnosis.noise_measured_at_rest:
        return f"the largest residual is {over_noise[worst]:.2f} x noise, {where}"
    size = f"{digits(known.after[worst], 3)} {diagnosis.torque_units[worst]}"
    return f"the largest residual is {size}, {where}; noise was not measured at rest, so it may be noise"


def _next(diagnosis: Diagnosis, first: Finding | None, folder: str) -> str:
    """The command that helps most: check the input, hold out a run, decide, look, or identify."""
    path = f"{folder}/" if folder else ""
    failing = diagnosis.adequacy.failing if diagnosis.adequacy is not None else ()
    if len(failing) > 1 or _doubtful(diagnosis):
        return CHECK
    if failing or (first is None and diagnosis.remainders):
        return f"Next: exidyn view {path}diagnosis.json, which shows where and when the residual is large."
    if not diagnosis.held_out:
        return f"{VALIDATE}: only a run that was not fitted shows whether this holds."
    uncertain = (f for f in important(diagnosis) if f in diagnosis.undecided and f.alternatives)
    if (open_ := next(uncertain, None)) is not None:
        return f"Next: {decides(open_, folder)}."
    if first is None:
        return "Next: exidyn identify RUN --robot ROBOT; the model needs no other effect."
    return f"Next: exidyn identify RUN --robot {path}{FOUND} --validate OTHER; that file has the findings."


def decides(finding: Finding, folder: str) -> str:
    """The run that decides between a finding and its alternatives, as a command if models are written."""
    names = joined([effect_words(hypothesis.effect) for hypothesis in possible(finding)[:2]], "from")
    if folder and (files := [other.file for other in finding.alternatives if other.file]):
        return f"exidyn excite {folder}/{FOUND} --against {folder}/{files[0]} plans a run that tells {names}"
    hypotheses = (finding, *finding.alternatives[:1])
    known = (kind_of(hypothesis.effect).settled_by for hypothesis in hypotheses)
    return f"tell {names} by {next(filter(None, known), 'another motion')}"


def details(diagnosis: Diagnosis, finding: Finding, folder: str = "") -> list[str]:
    """The finding, its probability, what is not excluded, the run that decides, and a remark."""
    parts = [finding_sentence(diagnosis, finding)]
    if finding in diagnosis.findings:
        parts.append(f"Probability {percent(finding.probability, 3)}.")
    if finding.alternatives:
        others = [
            f"{named(other.effect, other.joints, diagnosis.joints)} ({percent(other.probability)})"
            for other in finding.alternatives
        ]
        parts.append(f"Not excluded: {lower(joined(others))}. To decide: {decides(finding, folder)}.")
    if remark := kind_of(finding.effect).remark:
        parts.append(f"{remark}.")
    return parts
