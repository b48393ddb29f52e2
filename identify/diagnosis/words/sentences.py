"""Sentences about findings, undecided findings, hints and moments, with their numbers."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...text_table import NORMAL_95, digits, percent
from ..candidates import kind_of
from ..findings.diagnosis import Moment
from ..findings.family import FAMILIES
from ..findings.finding import Finding, Hypothesis
from ..findings.quantities import SLIDING, TURNING, formatted
from ..findings.residuals import UNCERTAIN, Hinted
from .naming import effect_words, joined, joint_words, lower

UNPROVEN = ", but its torque varies so much between time blocks that it may explain nothing"
ACTS_LIKE = ", or something that acts like it: the unexplained residual there is as large"
OPTIONAL = re.compile(r"\[([^\[\]]*)\]")


def sentence(finding: Finding, joints: Sequence[str], sliding: bool = False) -> str:
    """The finding as a sentence without a full stop and without parameters that are not determined.

    Args:
        finding: The finding; an effect that has no sentence is given by its name.
        joints: Names of the robot's joints.
        sliding: Whether the joints of the finding are prismatic.
    """
    finding = replace(finding, parameters=finding.determined)
    kind, known = kind_of(finding.effect), formatted(finding)
    derived = kind.derived(finding, known) if kind.derived else {}
    known |= {**derived, **_places(finding, joints), **_units(known, sliding)}
    pattern = kind.sentence or f"{{joint}}: {finding.effect.replace('_', ' ')}"
    completed = OPTIONAL.sub(lambda part: _filled(part[1], known), pattern)
    named_only = f"{known['joint']} has {effect_words(finding.effect)}" if finding.left_out else ""
    return _filled(completed, known) or named_only or f"{known['joint']}: {finding.effect.replace('_', ' ')}"


def _filled(pattern: str, known: Mapping[str, Any]) -> str:
    try:
        return pattern.format_map(known)
    except KeyError:
        return ""


def _places(finding: Finding, joints: Sequence[str]) -> dict[str, str]:
    words = [joint_words(joint, joints) for joint in finding.joints]
    words = words or ["The arm"]
    late = "All currents come" if not finding.joints else f"The current of {lower(words[0])} comes"
    number = str(finding.joints[0] + 1) if finding.joints else "?"
    return {"joint": words[0], "other": lower(words[-1]), "late": late, "number": number}


def _units(known: Mapping[str, Any], sliding: bool) -> dict[str, str]:
    """Words that depend on the kind of the joint and are not units of parameters."""
    if not sliding:
        pace = (
            {"pace": f"{known['harmonic']:bare} times per turn of the joint"} if "harmonic" in known else {}
        )
        return {"effort": TURNING, "one": "1 rad/s"} | pace
    # The harmonic counts waves of the position in meters as if it were an angle.
    known_wave = known.get("harmonic")
    pace = {"pace": f"in a wave {2 * np.pi / known_wave.value:.3g} m long"} if known_wave else {}
    return {"effort": SLIDING, "one": "1 m/s"} | pace


def undecided_sentence(finding: Finding, joints: Sequence[str], settled: str = "") -> str:
    """Sentence on an undecided finding: its joints, its hypotheses, and the run that would settle it.

    Args:
        finding: The undecided finding with its alternatives.
        joints: Names of the robot's joints.
        settled: The run that would settle it, in words or as a command; empty if none is known.
    """
    where = joined([joint_words(joint, joints) for joint in finding.joints]) if finding.joints else "The arm"
    hypotheses = [_possible(hypothesis, finding, joints) for hypothesis in possible(finding)]
    text = f"{where}: the missing effect is {joined(hypotheses, 'or')}"
    if finding.family:
        family, sure = FAMILIES[finding.family].words, percent(finding.family_probability, 3)
        text = f"{where} has {family} ({sure}): {joined(hypotheses, 'or')}"
    text += UNPROVEN if not finding.proven else ""
    text += ", but only one joint shows it" if finding.alone else ""
    text += ACTS_LIKE if finding.unnamed else ""
    return f"{text}; what would settle it: {settled}." if settled else f"{text}."


def possible(finding: Finding) -> list[Hypothesis]:
    """The finding and its alternatives, the most probable first, which need not be the fitted finding."""
    return sorted((finding, *finding.alternatives), key=lambda hypothesis: -hypothesis.probability)


def _possible(hypothesis: Hypothesis, finding: Finding, joints: Sequence[str]) -> str:
    """A hypothesis with its probability, and its joints if they differ from those of the finding."""
    name, sure = effect_words(hypothesis.effect), percent(hypothesis.probability)
    if hypothesis.joints == finding.joints:
        return f"{name} ({sure})"
    where = (
        joined([lower(joint_words(joint, joints)) for joint in hypothesis.joints])
        if hypothesis.joints
        else "the arm"
    )
    return f"{name} of {where} ({sure})"


def hint_sentence(hint: Hinted, joints: Sequence[str]) -> str:
    """Effect that the held-out runs show and the fitted runs do not, with both numbers and an action."""
    where, effect = joint_words(hint.joint, joints), effect_words(hint.effect)
    change = f"{-100 * hint.change:.0f} ± {100 * NORMAL_95 * hint.std:.0f} %"
    return (
        f"{where}: held-out runs show {effect} (log likelihood ratio {hint.gain_held_out:.1f}), which would "
        f"explain {change} of the squared residual there; the fitted runs do not decide it (ratio "
        f"{hint.gain:.1f}). Fit one of the held-out runs too, and hold out another one."
    )


def dependence(depends_on: str) -> str:
    """Dependence of a remainder; only a part of it depends on the quantity, since it contains noise."""
    if depends_on == UNCERTAIN:
        return "it depends on no recorded quantity with certainty"
    return f"part of it depends on {depends_on}"


def moment_sentence(moment: Moment) -> str:
    """A moment as a sentence with a full stop."""
    count = [str(joint + 1) for joint in moment.joints]
    where = f"joint {count[0]} differs" if len(count) == 1 else f"joints {joined(count)} differ"
    return f"{moment.run}, {span(moment)}: {where} from the model as at no other time{_force(moment)}."


def span(moment: Moment) -> str:
    """Start and end of a moment, in the time of its run."""
    return f"{moment.start:.2f} to {moment.end:.2f} s"


def direction(moment: Moment) -> str:
    """Direction of the force on the flange, in the axes of the base; "-" without a force."""
    if not np.isfinite(moment.force):
        return "-"
    return "({:.2f}, {:.2f}, {:.2f})".format(*(moment.direction + 0.0))


def _force(moment: Moment) -> str:
    if not (np.isfinite(moment.force) and moment.force > 0.0):
        return ""
    return (
        f", as if a force of {digits(moment.force, 2)} N acted on the flange along {direction(moment)} "
        "in the axes of the base"
    )
