"""Verdict: findings, their certainty, and their alternatives, the most important first."""

from collections.abc import Sequence

import numpy as np

from ...fit.verdict import TO_NOISE
from ...plausible.suspicion import CHECK_FIRST, UNLESS
from ...text_table import digits, percent
from ..candidates import kind_of, kinds
from ..findings.diagnosis import Diagnosis
from ..findings.finding import Finding
from ..findings.residuals import Remainder
from ..improved.improved import FOUND
from ..results.remainder import MATERIAL
from ..search.selected import EXCLUDED
from .measures import left_out_words, size_words, slides
from .naming import capital, effect_words, joined, joint_words, lower, named
from .sentences import dependence, hint_sentence, moment_sentence, sentence, undecided_sentence


def verdict(diagnosis: Diagnosis, folder: str = "") -> list[str]:
    """Sentences on the missing effects, then on their certainty, then on the limits of the data.

    A suspected mistake in the input comes first, since all other sentences hold only without it.

    Args:
        diagnosis: The diagnosis.
        folder: Folder with the models of findings and rivals; empty if they are not written.
    """
    headlines = [headline(diagnosis, finding) for finding in diagnosis.findings]
    details = [certainty(diagnosis, finding, folder) for finding in diagnosis.findings]
    open_ = [undecided(diagnosis, finding, folder) for finding in diagnosis.undecided]
    if explained(diagnosis):
        headlines = [_nothing(diagnosis)]
    moments = [moment_sentence(moment) for moment in diagnosis.moments]
    hints = [hint_sentence(hint, diagnosis.joints) for hint in diagnosis.hints]
    lines = [*headlines, *open_, *hints, *_unexplained(diagnosis), *moments, *details, _unnamed(diagnosis)]
    runs = (*diagnosis.runs, *diagnosis.held_out)
    suspected = [f"{CHECK_FIRST}: {_full(words, runs)} {UNLESS}" for words in diagnosis.suspicions]
    warnings = [_full(warning, runs) for warning in diagnosis.warnings]
    return [line for line in (*suspected, *lines, *warnings) if line]


def undecided(diagnosis: Diagnosis, finding: Finding, folder: str) -> str:
    """Sentence on an undecided finding, with the run that would settle it."""
    run = _command(finding, folder) or _run_that_decides(finding)
    return undecided_sentence(finding, diagnosis.joints, run)


def explained(diagnosis: Diagnosis) -> bool:
    """Whether nothing is missing: no finding (decided or not), hint, remainder or moment."""
    effects = (*diagnosis.findings, *diagnosis.undecided, *diagnosis.hints)
    return not (effects or diagnosis.remainders or diagnosis.moments)


def headline(diagnosis: Diagnosis, finding: Finding) -> str:
    """Sentences on a finding, its share of the squared residual, and the held-out residual."""
    text = f"{sized(diagnosis, finding)}."
    joint = clearest_joint(diagnosis, finding)
    parts = [text, _share(diagnosis, finding, joint), _held_out_residual(diagnosis, joint)]
    return " ".join(part for part in parts if part)


def sized(diagnosis: Diagnosis, finding: Finding) -> str:
    """The finding as a sentence without a full stop, with its torque if parameters are not determined."""
    text = sentence(finding, diagnosis.joints, slides(diagnosis, finding))
    shown = finding.left_out and finding.size is not None
    return f"{text}; {size_words(finding.size, diagnosis)}" if shown and finding.size else text


def _share(diagnosis: Diagnosis, finding: Finding, joint: int) -> str:
    """Sentence on the share of the squared residual that a finding explains on a joint."""
    [share] = [shares[joint] for shares in _shares(diagnosis, finding)] or [np.nan]
    if not np.isfinite(share):
        return ""
    where = lower(joint_words(joint, diagnosis.joints))
    if share <= 0.0:
        return f"It explains none of the squared residual of {where}."
    amount = percent(share).replace("above", "more than").replace("below", "less than")
    return f"It explains {amount} of the squared residual of {where}."


def _shares(diagnosis: Diagnosis, finding: Finding) -> list[np.ndarray]:
    """Shares of a finding in the budget, shape (n,) each; empty without a share."""
    if diagnosis.budget is None:
        return []
    place = next(place for place, other in enumerate(diagnosis.findings) if other is finding)
    return [share.percent / 100.0 for share in diagnosis.budget.shares if share.finding == place]


def before_and_after(diagnosis: Diagnosis) -> tuple[np.ndarray, np.ndarray] | None:
    """Held-out residuals of the baseline and with findings, shape (n,) each; None without held-out runs."""
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
    over_noise = f" ({digits(before / noise, 3)} -> {digits(after / noise, 3)} x noise)"
    ratio = over_noise if diagnosis.noise_measured_at_rest else ""
    with_all = " with all findings" if len(diagnosis.findings) > 1 else ""
    return f"Held-out residual of {where}{with_all}: {digits(before, 3)} -> {digits(after, 3)} {unit}{ratio}."


def clearest_joint(diagnosis: Diagnosis, finding: Finding) -> int:
    """Index of the affected joint on which the finding explains the largest share.

    Without a budget, it is the joint on which its torque is largest relative to the noise.
    """
    for shares in _shares(diagnosis, finding):
        return int(np.argmax(np.where(finding.torque_rms > 0.0, shares, -1.0)))
    return int(np.argmax(finding.torque_rms / diagnosis.noise))


def _nothing(diagnosis: Diagnosis) -> str:
    unknown = "No missing effect was found: the residual{} depends on no recorded quantity"
    if (after := diagnosis.torque_rms_after) is None:
        if diagnosis.budget is None or diagnosis.noise_measured_at_rest:
            return (
                "Nothing is missing, as far as the fitted runs show, with parameters and drive gains fitted "
                "within their tolerances; no run was held out."
            )
        return unknown.format("") + _may_be_noise(diagnosis, diagnosis.budget.after_rms)
    unknown = unknown.format(" of the held-out runs")
    if not diagnosis.noise_measured_at_rest:
        return unknown + _may_be_noise(diagnosis, after, diagnosis.noise)
    ratio = after / diagnosis.noise
    worst = int(np.argmax(ratio))
    where = f"{lower(joint_words(worst, diagnosis.joints))} with {ratio[worst]:.2f} x noise"
    if ratio[worst] <= TO_NOISE:
        return (
            "Nothing is missing. With parameters and drive gains fitted within their tolerances, the "
            f"residual of every joint is at the noise floor on held-out runs; the largest is that of {where}."
        )
    return f"{unknown}. But it exceeds the noise floor; the worst is {where}."


def _may_be_noise(diagnosis: Diagnosis, after: np.ndarray, noise: np.ndarray | float = 1.0) -> str:
    worst = int(np.argmax(after / noise))
    residual = f"{digits(after[worst], 3)} {diagnosis.torque_units[worst]}"
    where = lower(joint_words(worst, diagnosis.joints))
    return f". It is {residual} on {where}; noise was not measured at rest, so it may be noise."


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
    residual = left_on(remainder, diagnosis)
    return f"{where} keeps a residual of {residual}, and {dependence(remainder.depends_on)}"


def left_on(remainder: Remainder, diagnosis: Diagnosis) -> str:
    """Residual of a joint with its unit, and as a multiple of the noise if that was measured."""
    joint, budget = remainder.joint, diagnosis.budget
    noise = float(diagnosis.noise[joint])
    size = remainder.over_noise * noise if budget is None else float(budget.after_rms[joint])
    text = f"{digits(size, 3)} {diagnosis.torque_units[joint]}"
    return f"{text} ({size / noise:.2f} x its noise)" if diagnosis.noise_measured_at_rest else text


def _unnamed(diagnosis: Diagnosis) -> str:
    """Sentence on joints that keep more than noise and are not named in another sentence."""
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
    """Sentences on the probability of a finding, excluded effects, alternatives, and the run that decides."""
    name, probability = (
        named(finding.effect, finding.joints, diagnosis.joints),
        percent(finding.probability, 3),
    )
    parts = [f"{name}: probability {probability}."]
    parts += [_small(diagnosis, finding), _held_out(finding), _excluded(diagnosis, finding)]
    remark = kind_of(finding.effect).remark
    parts += [*left_out_words(finding.left_out).values(), _open(diagnosis, finding, folder)]
    parts.append(f"{remark}." if remark else "")
    return " ".join(part for part in parts if part)


def _small(diagnosis: Diagnosis, finding: Finding) -> str:
    """Sentence on a finding that exists but hardly matters; empty for others."""
    if not (diagnosis.held_out and diagnosis.noise_measured_at_rest):
        return ""
    share = float(np.max(finding.torque_rms / diagnosis.noise))
    if share >= MATERIAL:
        return ""
    return f"It is small, {share:.2f} x noise: a model without it does nearly as well."


def _held_out(finding: Finding) -> str:
    if np.isnan(finding.held_out) or finding.held_out > 0.0:
        return ""
    return "The held-out runs do not confirm it: they are predicted no better with it."


def _excluded(diagnosis: Diagnosis, finding: Finding) -> str:
    """Sentence on similar effects that the data exclude."""
    hypotheses = [*finding.alternatives, *diagnosis.all_findings]
    hypotheses += [other for undecided in diagnosis.undecided for other in undecided.alternatives]
    present = {hypothesis.effect for hypothesis in hypotheses}
    tried, similar = diagnosis.tried or kinds(), kind_of(finding.effect).mistaken_for
    names = [name for name in similar if name in tried and name not in present]
    if not names:
        return ""
    excluded = ", ".join(effect_words(name) for name in names)
    return f"Excluded (each less than {100 * EXCLUDED:.0f} % probable): {excluded}."


def _open(diagnosis: Diagnosis, finding: Finding, folder: str) -> str:
    """Sentence on the alternatives of a finding, and on how to decide."""
    if not finding.alternatives:
        return ""
    others = [
        f"{lower(named(other.effect, other.joints, diagnosis.joints))} ({percent(other.probability)})"
        for other in finding.alternatives
    ]
    text = f"Not excluded: {joined(others)}."
    if command := _command(finding, folder):
        return f"{text} To distinguish them: {command}"
    run = _run_that_decides(finding)
    return f"{text} What would settle it: {run}." if run else text


def _command(finding: Finding, folder: str) -> str:
    """Command that plans the deciding run; empty without models to plan with."""
    files = [other.file for other in finding.alternatives if other.file]
    return f"exidyn excite {folder}/{FOUND} --against {folder}/{files[0]}" if folder and files else ""


def _run_that_decides(finding: Finding) -> str:
    """The deciding run in words; empty if none is known."""
    hypotheses = (finding, *finding.alternatives[:1])
    return next((run for other in hypotheses if (run := kind_of(other.effect).settled_by)), "")


def _full(words: str, runs: Sequence[str]) -> str:
    """The words as a sentence; the name of a run at the beginning is not capitalized."""
    text = words if words.startswith(tuple(runs)) else capital(words)
    return text + ("" if words.endswith((".", "!", "?")) else ".")
