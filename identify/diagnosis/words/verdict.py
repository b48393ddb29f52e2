"""Verdict: what was found, how surely, and what it might be instead, the most important first."""

from collections.abc import Sequence

import numpy as np

from ...fit.verdict import TO_NOISE
from ...plausible.suspicion import CHECK_FIRST, UNLESS
from ...text_table import digits, percent
from ..candidates import kind_of, kinds
from ..findings.diagnosis import Diagnosis, Remainder
from ..findings.finding import Finding, Hypothesis
from ..improved.improved import FOUND
from ..results.remainder import MATERIAL
from ..search.selected import EXCLUDED
from .measures import slides
from .naming import capital, effect_words, joined, joint_words, lower, named
from .sentences import dependence, hint_sentence, moment_sentence, sentence, undecided_sentence
from .size_words import left_out_words, size_words


def verdict(diagnosis: Diagnosis, folder: str = "") -> list[str]:
    """Sentences for people: what is missing, or that nothing is; then certainty, then limits of the data.

    A mistake suspected in the input comes before all: what follows holds only without it.

    Args:
        diagnosis: What was found.
        folder: Where the models of the findings and their rivals are written; empty if they are not.
    """
    headlines = [headline(diagnosis, finding) for finding in diagnosis.findings]
    details = [certainty(diagnosis, finding, folder) for finding in diagnosis.findings]
    open_ = [undecided(diagnosis, finding, folder) for finding in diagnosis.undecided]
    if explained(diagnosis):
        headlines = [_nothing(diagnosis)]
    moments = [moment_sentence(moment) for moment in diagnosis.moments]
    hints = [hint_sentence(hint, diagnosis.joints) for hint in diagnosis.hints]
    lines = [*headlines, *open_, *hints, *_unexplained(diagnosis), *moments, *details, _left(diagnosis)]
    runs = (*diagnosis.runs, *diagnosis.held_out)
    suspected = [f"{CHECK_FIRST}: {_full(words, runs)} {UNLESS}" for words in diagnosis.suspicions]
    warnings = [_full(warning, runs) for warning in diagnosis.warnings]
    return [line for line in (*suspected, *lines, *warnings) if line]


def undecided(diagnosis: Diagnosis, finding: Finding, folder: str) -> str:
    """What an undecided finding may be, and the run that would settle it."""
    run = _command(finding, folder) or _run_that_decides(finding)
    return undecided_sentence(finding, diagnosis.joints, run)


def explained(diagnosis: Diagnosis) -> bool:
    """Whether nothing is missing: no finding, with a certain name or not, no hint, remainder or moment."""
    found = (*diagnosis.findings, *diagnosis.undecided, *diagnosis.hints)
    return not (found or diagnosis.remainders or diagnosis.moments)


def headline(diagnosis: Diagnosis, finding: Finding) -> str:
    """What is missing, how much of the misfit it explains, and what the runs held out show."""
    text = f"{sized(diagnosis, finding)}."
    joint = clearest_joint(diagnosis, finding)
    parts = [text, _share(diagnosis, finding, joint), _held_out_residual(diagnosis, joint)]
    return " ".join(part for part in parts if part)


def sized(diagnosis: Diagnosis, finding: Finding) -> str:
    """The finding as a sentence, without a full stop; with its torque where numbers are not determined."""
    text = sentence(finding, diagnosis.joints, slides(diagnosis, finding))
    shown = finding.left_out and finding.size is not None
    return f"{text}; {size_words(finding.size, diagnosis)}" if shown and finding.size else text


def _share(diagnosis: Diagnosis, finding: Finding, joint: int) -> str:
    """Its part of the budget on the joint on which it is seen best."""
    [share] = [shares[joint] for shares in _shares(diagnosis, finding)] or [np.nan]
    if not np.isfinite(share):
        return ""
    where = lower(joint_words(joint, diagnosis.joints))
    if share <= 0.0:
        return f"It explains nothing of what the model misses on {where}."
    said = percent(share).replace("above", "more than").replace("below", "less than")
    return f"It explains {said} of what the model misses on {where}."


def _shares(diagnosis: Diagnosis, finding: Finding) -> list[np.ndarray]:
    """Its shares of the budget, (n,); none where it has none."""
    if diagnosis.budget is None:
        return []
    place = next(place for place, other in enumerate(diagnosis.findings) if other is finding)
    return [share.percent / 100.0 for share in diagnosis.budget.shares if share.finding == place]


def before_and_after(diagnosis: Diagnosis) -> tuple[np.ndarray, np.ndarray] | None:
    """Held-out residual of the model fitted without and with findings, (n,) each; None without such runs."""
    before, after, budget = diagnosis.torque_rms_before, diagnosis.torque_rms_after, diagnosis.budget
    if before is None or after is None:
        return None
    return (
        (budget.before_rms, budget.after_rms) if budget is not None and budget.held_out else (before, after)
    )


def _held_out_residual(diagnosis: Diagnosis, joint: int) -> str:
    if (residuals := before_and_after(diagnosis)) is None:
        return ""
    unit, noise = diagnosis.torque_units[joint], float(diagnosis.noise[joint])
    where = lower(joint_words(joint, diagnosis.joints))
    before, after = (float(rms[joint]) for rms in residuals)
    over = f" ({digits(before / noise, 3)} -> {digits(after / noise, 3)} x noise)"
    ratio = over if diagnosis.noise_measured_at_rest else ""
    every = " with all findings" if len(diagnosis.findings) > 1 else ""
    return f"Held-out residual of {where}{every}: {digits(before, 3)} -> {digits(after, 3)} {unit}{ratio}."


def clearest_joint(diagnosis: Diagnosis, finding: Finding) -> int:
    """The joint on which the finding is seen best: of those that feel it, where it explains most.

    Without a budget, where its torque is most over the noise.
    """
    for shares in _shares(diagnosis, finding):
        return int(np.argmax(np.where(finding.torque_rms > 0.0, shares, -1.0)))
    return int(np.argmax(finding.torque_rms / diagnosis.noise))


def _nothing(diagnosis: Diagnosis) -> str:
    unknown = "Nothing was found to be missing: what is left{} depends on nothing that was recorded"
    if (after := diagnosis.torque_rms_after) is None:
        if diagnosis.budget is None or diagnosis.noise_measured_at_rest:
            return (
                "Nothing is missing, as far as the fitted runs show, with parameters and drive gains moved "
                "within their tolerances; no run was held out."
            )
        return unknown.format("") + _may_be_noise(diagnosis, diagnosis.budget.after_rms)
    unknown = unknown.format(" on runs held out")
    if not diagnosis.noise_measured_at_rest:
        return unknown + _may_be_noise(diagnosis, after, diagnosis.noise)
    ratio = after / diagnosis.noise
    worst = int(np.argmax(ratio))
    where = f"{lower(joint_words(worst, diagnosis.joints))} with {ratio[worst]:.2f} x noise"
    if ratio[worst] <= TO_NOISE:
        return (
            "Nothing is missing. With parameters and gains moved within their tolerances, the residual of "
            f"every joint is at the noise floor on runs held out; the largest is that of {where}."
        )
    return f"{unknown}. But it is more than noise; the worst is {where}."


def _may_be_noise(diagnosis: Diagnosis, after: np.ndarray, noise: np.ndarray | float = 1.0) -> str:
    worst = int(np.argmax(after / noise))
    left = f"{digits(after[worst], 3)} {diagnosis.torque_units[worst]}"
    where = lower(joint_words(worst, diagnosis.joints))
    return f". It is {left} on {where}; noise was not measured at rest, so that it may be noise."


def _unexplained(diagnosis: Diagnosis) -> list[str]:
    if not diagnosis.remainders:
        return []
    more = (
        "Something more is missing" if diagnosis.findings or diagnosis.undecided else "Something is missing"
    )
    places = "; ".join(_place(remainder, diagnosis) for remainder in diagnosis.remainders)
    return [f"{more}, and it is none of the effects that exidyn knows: {places}."]


def _place(remainder: Remainder, diagnosis: Diagnosis) -> str:
    where = lower(joint_words(remainder.joint, diagnosis.joints))
    return f"{where} keeps {left_on(remainder, diagnosis)}, and {dependence(remainder.depends_on)}"


def left_on(remainder: Remainder, diagnosis: Diagnosis) -> str:
    """How much is left on a joint, with its unit; as a multiple of noise besides where that was measured."""
    joint, budget = remainder.joint, diagnosis.budget
    noise = float(diagnosis.noise[joint])
    size = remainder.over_noise * noise if budget is None else float(budget.after_rms[joint])
    text = f"{digits(size, 3)} {diagnosis.torque_units[joint]}"
    return f"{text} ({size / noise:.2f} x its noise)" if diagnosis.noise_measured_at_rest else text


def _left(diagnosis: Diagnosis) -> str:
    """Joints that keep more than noise and are not named otherwise."""
    after = diagnosis.torque_rms_after
    if after is None or explained(diagnosis) or not diagnosis.noise_measured_at_rest:
        return ""
    ratio = after / diagnosis.noise
    named_ = {remainder.joint for remainder in diagnosis.remainders}
    joints = [joint for joint in range(len(ratio)) if ratio[joint] > TO_NOISE and joint not in named_]
    if not joints:
        return ""
    places = joined([f"{lower(joint_words(j, diagnosis.joints))} ({ratio[j]:.2f} x noise)" for j in joints])
    return f"More than noise is left on {places}; it depends on no recorded quantity with certainty."


def certainty(diagnosis: Diagnosis, finding: Finding, folder: str) -> str:
    """How surely it is this, what is excluded, what is not, and the run that would decide."""
    parts = [
        f"{named(finding.effect, finding.joints, diagnosis.joints)}: {_probability(finding.probability)}."
    ]
    parts += [_small(diagnosis, finding), _held_out(finding), _excluded(diagnosis, finding)]
    remark = kind_of(finding.effect).remark
    parts += [*left_out_words(finding.left_out).values(), _open(diagnosis, finding, folder)]
    parts.append(f"{remark}." if remark else "")
    return " ".join(part for part in parts if part)


def _probability(probability: float) -> str:
    return f"probability {percent(probability, 3)}"


def _small(diagnosis: Diagnosis, finding: Finding) -> str:
    """About what is there and hardly matters."""
    if not (diagnosis.held_out and diagnosis.noise_measured_at_rest):
        return ""
    share = float(np.max(finding.torque_rms / diagnosis.noise))
    if share >= MATERIAL:
        return ""
    return f"It is small, {share:.2f} x noise: a model without it does nearly as well."


def _held_out(finding: Finding) -> str:
    if np.isnan(finding.held_out) or finding.held_out > 0.0:
        return ""
    return "Runs held out do not confirm it: they are predicted no better with it."


def _excluded(diagnosis: Diagnosis, finding: Finding) -> str:
    """What it is taken for most easily, and is not."""
    hypotheses = [*finding.alternatives, *diagnosis.all_findings]
    hypotheses += [other for undecided in diagnosis.undecided for other in undecided.alternatives]
    present = {hypothesis.effect for hypothesis in hypotheses}
    asked, similar = diagnosis.tried or kinds(), kind_of(finding.effect).mistaken_for
    names = [name for name in similar if name in asked and name not in present]
    if not names:
        return ""
    excluded = ", ".join(effect_words(name) for name in names)
    return f"Excluded, below {100 * EXCLUDED:.0f} %: {excluded}."


def _open(diagnosis: Diagnosis, finding: Finding, folder: str) -> str:
    """What it might be instead, and how to find out."""
    if not finding.alternatives:
        return ""
    others = joined([_alternative(other, diagnosis.joints) for other in finding.alternatives])
    text = f"Not excluded: {others}."
    if command := _command(finding, folder):
        return f"{text} To distinguish them: {command}"
    run = _run_that_decides(finding)
    return f"{text} What would settle it: {run}." if run else text


def _command(finding: Finding, folder: str) -> str:
    """The command that plans the run which decides; empty where there are no models to plan with."""
    files = [other.file for other in finding.alternatives if other.file]
    return f"exidyn excite {folder}/{FOUND} --against {folder}/{files[0]}" if folder and files else ""


def _run_that_decides(finding: Finding) -> str:
    """The run that decides, in words; empty if none is known."""
    hypotheses = (finding, *finding.alternatives[:1])
    return next((run for other in hypotheses if (run := kind_of(other.effect).settled_by)), "")


def _alternative(other: Hypothesis, joints: Sequence[str]) -> str:
    return f"{lower(named(other.effect, other.joints, joints))} ({percent(other.probability)})"


def _full(words: str, runs: Sequence[str]) -> str:
    """The words as a sentence; a run's name at their beginning stays as it is."""
    begun = words if words.startswith(tuple(runs)) else capital(words)
    return begun + ("" if words.endswith((".", "!", "?")) else ".")
