"""Verdict: what was found, how surely, and what it might be instead, the most important first."""

from collections.abc import Sequence

import numpy as np

from ...fit.verdict import TO_NOISE
from ...plausible.suspicion import CHECK_FIRST, UNLESS
from ...text_table import digits, percent
from ..candidates import kind_of, kinds
from ..findings.finding import Alternative, Diagnosis, Finding, Remainder
from ..improved.improved import FOUND, Rival, rivals
from ..results.remainder import MATERIAL
from ..search.selected import EXCLUDED
from .measures import by_kind, noise_measured, slides, torque_units
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
    diagnosis = by_kind(diagnosis)
    headlines = [headline(diagnosis, finding) for finding in diagnosis.findings]
    details = [certainty(diagnosis, place, folder) for place in range(len(diagnosis.findings))]
    open_ = [undecided(diagnosis, place, folder) for place in range(len(diagnosis.undecided))]
    if explained(diagnosis):
        headlines = [_nothing(diagnosis)]
    moments = [moment_sentence(one) for one in diagnosis.moments]
    hints = [hint_sentence(one, diagnosis.joints) for one in diagnosis.hints]
    lines = [*headlines, *open_, *hints, *_unexplained(diagnosis), *moments, *details, _left(diagnosis)]
    held_out = diagnosis.improvement.runs if diagnosis.improvement else ()
    runs = (*diagnosis.runs, *held_out)
    suspected = [f"{CHECK_FIRST}: {_full(one, runs)} {UNLESS}" for one in diagnosis.suspicions]
    warnings = [_full(warning, runs) for warning in diagnosis.warnings]
    return [line for line in (*suspected, *lines, *warnings) if line]


def undecided(diagnosis: Diagnosis, place: int, folder: str) -> str:
    """What an undecided finding may be, and the run that would settle it."""
    finding = diagnosis.undecided[place]
    files = _rivals(diagnosis, len(diagnosis.findings) + place, folder)
    return undecided_sentence(finding, diagnosis.joints, _distinguishing_run(finding, files, folder))


def _rivals(diagnosis: Diagnosis, place: int, folder: str) -> list[Rival]:
    """Models of what a finding might be instead; none where no models are written."""
    return [one for one in rivals(diagnosis) if one.finding == place] if folder else []


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
    [share] = [one[joint] for one in _shares(diagnosis, finding)] or [np.nan]
    if not np.isfinite(share):
        return ""
    where = lower(joint_words(joint, diagnosis.joints))
    if share <= 0.0:
        return f"It explains nothing of what the model misses on {where}."
    said = percent(share).replace("above", "more than").replace("below", "less than")
    return f"It explains {said} of what the model misses on {where}."


def _shares(diagnosis: Diagnosis, finding: Finding) -> list[np.ndarray]:
    """Its shares of the budget, (n,); none where it has none."""
    budget = diagnosis.budget
    place = next(place for place, one in enumerate(diagnosis.findings) if one is finding)
    return [] if budget is None else [one.shares for one in budget.shares if one.finding == place]


def before_and_after(diagnosis: Diagnosis) -> tuple[np.ndarray, np.ndarray] | None:
    """Residual of runs held out, (n,) each, of the model fitted without and with findings; None without."""
    gained, budget = diagnosis.improvement, diagnosis.budget
    if gained is None:
        return None
    if budget is not None and budget.held_out:
        return budget.before, budget.after
    return gained.before, gained.after


def _held_out_residual(diagnosis: Diagnosis, joint: int) -> str:
    gained, residuals = diagnosis.improvement, before_and_after(diagnosis)
    if gained is None or residuals is None:
        return ""
    unit, noise = torque_units(diagnosis)[joint], float(gained.noise[joint])
    where = lower(joint_words(joint, diagnosis.joints))
    before, after = (float(one[joint]) for one in residuals)
    over = f" ({digits(before / noise, 3)} -> {digits(after / noise, 3)} x noise)"
    ratio = over if noise_measured(diagnosis) else ""
    every = " with all findings" if len(diagnosis.findings) > 1 else ""
    return f"Held-out residual of {where}{every}: {digits(before, 3)} -> {digits(after, 3)} {unit}{ratio}."


def clearest_joint(diagnosis: Diagnosis, finding: Finding) -> int:
    """The joint on which the finding is seen best: of those that feel it, where it explains most.

    Without a budget, where its torque is most over the noise.
    """
    for shares in _shares(diagnosis, finding):
        return int(np.argmax(np.where(finding.torque > 0.0, shares, -1.0)))
    found = diagnosis.improvement
    return int(np.argmax(finding.torque if found is None else finding.torque / found.noise))


def _nothing(diagnosis: Diagnosis) -> str:
    found = diagnosis.improvement
    unknown = "Nothing was found to be missing: what is left{} depends on nothing that was recorded"
    if found is None:
        if diagnosis.budget is None or noise_measured(diagnosis):
            return (
                "Nothing is missing, as far as the fitted runs show, with parameters and drive gains moved "
                "within their tolerances; no run was held out."
            )
        return unknown.format("") + _may_be_noise(diagnosis, diagnosis.budget.after)
    unknown = unknown.format(" on runs held out")
    if not noise_measured(diagnosis):
        return unknown + _may_be_noise(diagnosis, found.after, found.noise)
    ratio = found.after / found.noise
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
    left = f"{digits(after[worst], 3)} {torque_units(diagnosis)[worst]}"
    where = lower(joint_words(worst, diagnosis.joints))
    return f". It is {left} on {where}; noise was not measured at rest, so that it may be noise."


def _unexplained(diagnosis: Diagnosis) -> list[str]:
    if not diagnosis.remainders:
        return []
    more = (
        "Something more is missing" if diagnosis.findings or diagnosis.undecided else "Something is missing"
    )
    places = "; ".join(_place(one, diagnosis) for one in diagnosis.remainders)
    return [f"{more}, and it is none of the effects that exidyn knows: {places}."]


def _place(remainder: Remainder, diagnosis: Diagnosis) -> str:
    where = lower(joint_words(remainder.joint, diagnosis.joints))
    return f"{where} keeps {left_on(remainder, diagnosis)}, and {dependence(remainder.depends_on)}"


def left_on(remainder: Remainder, diagnosis: Diagnosis) -> str:
    """How much is left on a joint, with its unit; as a multiple of noise besides where that was measured."""
    joint, known = remainder.joint, diagnosis.evidence or diagnosis.improvement
    noise = float(known.noise[joint]) if known is not None else float("nan")
    size = remainder.over_noise * noise if diagnosis.budget is None else float(diagnosis.budget.after[joint])
    if not np.isfinite(size):
        return f"{remainder.over_noise:.2f} x its noise"
    text = f"{digits(size, 3)} {torque_units(diagnosis)[joint]}"
    return f"{text} ({size / noise:.2f} x its noise)" if noise_measured(diagnosis) else text


def _left(diagnosis: Diagnosis) -> str:
    """Joints that keep more than noise and are not named otherwise."""
    if diagnosis.improvement is None or explained(diagnosis) or not noise_measured(diagnosis):
        return ""
    ratio = diagnosis.improvement.after / diagnosis.improvement.noise
    named_ = {one.joint for one in diagnosis.remainders}
    joints = [joint for joint in range(len(ratio)) if ratio[joint] > TO_NOISE and joint not in named_]
    if not joints:
        return ""
    places = joined([f"{lower(joint_words(j, diagnosis.joints))} ({ratio[j]:.2f} x noise)" for j in joints])
    return f"More than noise is left on {places}; it depends on no recorded quantity with certainty."


def certainty(diagnosis: Diagnosis, place: int, folder: str) -> str:
    """How surely it is this, what is excluded, what is not, and the run that would decide."""
    finding, files = diagnosis.findings[place], _rivals(diagnosis, place, folder)
    parts = [
        f"{named(finding.effect, finding.joints, diagnosis.joints)}: {_probability(finding.probability)}."
    ]
    parts += [_small(diagnosis, finding), _held_out(finding), _excluded(diagnosis, finding)]
    remark = kind_of(finding.effect).remark
    parts += [*left_out_words(finding.left_out).values(), _open(diagnosis, finding, files, folder)]
    parts.append(f"{remark}." if remark else "")
    return " ".join(part for part in parts if part)


def _probability(probability: float) -> str:
    return f"probability {percent(probability, 3)}"


def _small(diagnosis: Diagnosis, finding: Finding) -> str:
    """About what is there and hardly matters."""
    if diagnosis.improvement is None or not noise_measured(diagnosis):
        return ""
    share = float(np.max(finding.torque / diagnosis.improvement.noise))
    if share >= MATERIAL:
        return ""
    return f"It is small, {share:.2f} x noise: a model without it does nearly as well."


def _held_out(finding: Finding) -> str:
    if np.isnan(finding.held_out) or finding.held_out > 0.0:
        return ""
    return "Runs held out do not confirm it: they are predicted no better with it."


def _excluded(diagnosis: Diagnosis, finding: Finding) -> str:
    """What it is taken for most easily, and is not."""
    here = (*diagnosis.findings, *diagnosis.undecided)
    present = {one.effect for one in finding.alternatives} | {one.effect for one in here}
    present |= {other.effect for one in diagnosis.undecided for other in one.alternatives}
    asked, similar = diagnosis.tried or kinds(), kind_of(finding.effect).mistaken_for
    names = [name for name in similar if name in asked and name not in present]
    if not names:
        return ""
    excluded = ", ".join(effect_words(name) for name in names)
    return f"Excluded, below {100 * EXCLUDED:.0f} %: {excluded}."


def _open(diagnosis: Diagnosis, finding: Finding, files: Sequence[Rival], folder: str) -> str:
    """What it might be instead, and how to find out."""
    if not finding.alternatives:
        return ""
    others = joined([_alternative(one, diagnosis.joints) for one in finding.alternatives])
    text = f"Not excluded: {others}."
    if files:
        return f"{text} To distinguish them: {_distinguishing_run(finding, files, folder)}"
    settled = _distinguishing_run(finding, files, folder)
    return f"{text} What would settle it: {settled}." if settled else text


def _distinguishing_run(finding: Finding, files: Sequence[Rival], folder: str) -> str:
    """The command that plans the run which would settle it, or that run in words; empty if none is known."""
    if files:
        return f"exidyn excite {folder}/{FOUND} --against {folder}/{files[0].file}"
    other = finding.alternatives[0].effect if finding.alternatives else ""
    return kind_of(finding.effect).settled_by or kind_of(other).settled_by


def _alternative(one: Alternative, joints: Sequence[str]) -> str:
    return f"{lower(named(one.effect, one.joints, joints))} ({percent(one.probability)})"


def _full(words: str, runs: Sequence[str]) -> str:
    """The words as a sentence; a run's name at their beginning stays as it is."""
    begun = words if words.startswith(tuple(runs)) else capital(words)
    return begun + ("" if words.endswith((".", "!", "?")) else ".")
