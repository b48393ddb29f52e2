"""Words: what was found, how surely, and what it might be instead, the most important first."""

from collections.abc import Sequence

import numpy as np

from ..verdict import TO_NOISE
from .candidates import CANDIDATES
from .finding import Alternative, Diagnosis, Finding, Remainder
from .found import EXCLUDED
from .remainder import MATERIAL
from .rivals import FOUND, Rival, rivals
from .sentences import LIKE, SETTLED, joint_words, lower, sentence


def verdict(diagnosis: Diagnosis, folder: str = "") -> list[str]:
    """Sentences for people: what is missing, or that nothing is; then certainty, then doubts.

    Args:
        diagnosis: What was found.
        folder: Where the models of the findings and their rivals are written; empty if they are not.
    """
    files = rivals(diagnosis) if folder else []
    headlines = [headline(diagnosis, finding) for finding in diagnosis.findings]
    details = [
        _detail(diagnosis, place, [one for one in files if one.finding == place], folder)
        for place in range(len(diagnosis.findings))
    ]
    if not diagnosis.findings and not diagnosis.remainders:
        headlines = [_nothing(diagnosis)]
    lines = [*headlines, *_unexplained(diagnosis), *details, _left(diagnosis), *map(_full, diagnosis.doubts)]
    return [line for line in lines if line]


def headline(diagnosis: Diagnosis, finding: Finding) -> str:
    """What is missing, and what the runs held out say of it."""
    said = f"{sentence(finding, diagnosis.joints)}."
    if diagnosis.improvement is None:
        return said
    joint = telling_joint(diagnosis, finding)
    before, after = (
        float(rms[joint] / diagnosis.improvement.noise[joint])
        for rms in (diagnosis.improvement.before, diagnosis.improvement.after)
    )
    where = lower(joint_words(joint, diagnosis.joints))
    return f"{said} Held-out residual of {where}: {before:.3g} -> {after:.3g} x noise."


def telling_joint(diagnosis: Diagnosis, finding: Finding) -> int:
    """The joint on which the finding is seen best: of those that feel it, where most was gained."""
    found = diagnosis.improvement
    if found is None:
        return int(np.argmax(finding.torque))
    gained = (found.before - found.after) / found.noise
    return int(np.argmax(np.where(finding.torque > 0.0, gained, -np.inf)))


def _nothing(diagnosis: Diagnosis) -> str:
    if diagnosis.improvement is None:
        return "Nothing is missing, as far as runs can tell that the parameters were fitted to."
    ratio = diagnosis.improvement.after / diagnosis.improvement.noise
    worst = int(np.argmax(ratio))
    where = f"{lower(joint_words(worst, diagnosis.joints))} with {ratio[worst]:.2f} x noise"
    if ratio[worst] <= TO_NOISE:
        return (
            "Nothing is missing. With its parameters moved within their tolerances the model explains every "
            f"joint to its noise on runs held out; the worst is {where}."
        )
    return (
        "Nothing is missing that would show: what is left on runs held out goes with nothing that exidyn "
        f"knows or looks for. But it is more than noise; the worst is {where}."
    )


def _unexplained(diagnosis: Diagnosis) -> list[str]:
    if not diagnosis.remainders:
        return []
    more = "Something more is missing" if diagnosis.findings else "Something is missing"
    places = "; ".join(_place(one, diagnosis.joints) for one in diagnosis.remainders)
    return [f"{more}, and it is none of what exidyn knows: {places}."]


def _place(remainder: Remainder, joints: Sequence[str]) -> str:
    where = lower(joint_words(remainder.joint, joints))
    left = f"{remainder.over_noise:.2f} x its noise"
    return f"{where} keeps {left}, and what is left goes with {remainder.depends_on}"


def _left(diagnosis: Diagnosis) -> str:
    """Joints that keep more than noise and are not spoken of otherwise."""
    if diagnosis.improvement is None or not (diagnosis.findings or diagnosis.remainders):
        return ""
    ratio = diagnosis.improvement.after / diagnosis.improvement.noise
    told = {one.joint for one in diagnosis.remainders}
    joints = [joint for joint in range(len(ratio)) if ratio[joint] > TO_NOISE and joint not in told]
    if not joints:
        return ""
    places = joined([f"{lower(joint_words(j, diagnosis.joints))} ({ratio[j]:.2f} x noise)" for j in joints])
    return f"More than noise is left on {places}; it goes with nothing that exidyn knows or looks for."


def _detail(diagnosis: Diagnosis, place: int, files: Sequence[Rival], folder: str) -> str:
    """How surely it is this, what is excluded, what is not, and the run that would tell."""
    finding = diagnosis.findings[place]
    parts = [
        f"{named(finding.effect, finding.joints, diagnosis.joints)}: {_probability(finding.probability)}."
    ]
    parts += [_small(diagnosis, finding), _held_out(finding), _excluded(diagnosis, finding)]
    parts += [_open(diagnosis, finding, files, folder)]
    return " ".join(part for part in parts if part)


def named(effect: str, joints: Sequence[int], names: Sequence[str]) -> str:
    """An effect and where it acts: Load dependent friction of joint 3."""
    where = " and ".join(
        f"link {joint + 1}" if effect == "link_inertia" else lower(joint_words(joint, names))
        for joint in joints
    )
    return _capital(effect.replace("_", " ")) + (f" of {where}" if where else "")


def _probability(probability: float) -> str:
    return "probability above 99.9 %" if probability > 0.999 else f"probability {100 * probability:.3g} %"


def _small(diagnosis: Diagnosis, finding: Finding) -> str:
    """Said of what is there and hardly matters."""
    if diagnosis.improvement is None:
        return ""
    share = float(np.max(finding.torque / diagnosis.improvement.noise))
    if share >= MATERIAL:
        return ""
    return f"It is real and small, {share:.2f} x noise: a model without it does nearly as well."


def _held_out(finding: Finding) -> str:
    if np.isnan(finding.held_out) or finding.held_out > 0.0:
        return ""
    return "Runs held out do not bear it out: they are predicted no better with it."


def _excluded(diagnosis: Diagnosis, finding: Finding) -> str:
    """What it is taken for most easily, and is not."""
    present = {one.effect for one in finding.alternatives} | {one.effect for one in diagnosis.findings}
    asked = diagnosis.tried or CANDIDATES
    names = [name for name in LIKE.get(finding.effect, ()) if name in asked and name not in present]
    if not names:
        return ""
    said = ", ".join(name.replace("_", " ") for name in names)
    return f"Excluded, below {100 * EXCLUDED:.0f} %: {said}."


def _open(diagnosis: Diagnosis, finding: Finding, files: Sequence[Rival], folder: str) -> str:
    """What it might be instead, and how to find out."""
    if not finding.alternatives:
        return ""
    others = joined([_alternative(one, diagnosis.joints) for one in finding.alternatives])
    said = f"Not excluded: {others}."
    if files:
        return f"{said} Tell them apart: exidyn excite {folder}/{FOUND} --against {folder}/{files[0].file}"
    settled = SETTLED.get(finding.effect) or SETTLED.get(finding.alternatives[0].effect)
    return f"{said} What would settle it: {settled}." if settled else said


def _alternative(one: Alternative, joints: Sequence[str]) -> str:
    return f"{lower(named(one.effect, one.joints, joints))} ({100 * one.probability:.2g} %)"


def joined(words: Sequence[str]) -> str:
    """One sentence part out of several: a, b and c."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]


def _full(words: str) -> str:
    """The words as a sentence."""
    return _capital(words) + ("" if words.endswith((".", "!", "?")) else ".")
