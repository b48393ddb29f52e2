"""Sentences about findings, undecided findings and moments, with their numbers."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from string import Formatter
from typing import Any

import numpy as np

from ...text_table import digits, percent
from ..candidates import kind_of
from ..findings.adequacy import Misfit
from ..findings.diagnosis import Moment
from ..findings.evidence import UNCERTAIN
from ..findings.family import FAMILIES
from ..findings.finding import Finding, Hypothesis
from ..findings.quantities import SCALES, SLIDING, TURNING, Formatted, formatted
from .naming import effect_words, joined, joint_words, lower

OPTIONAL = re.compile(r"\[([^\[\]]*)\]")


def sentence(finding: Finding, joints: Sequence[str], sliding: bool = False) -> str:
    """The finding as a sentence without a full stop and without parameters that are not determined.

    An effect that has no sentence is given by its name.
    """
    known = {**numbers(finding), **_places(finding, joints)}
    known |= _units(known, sliding)
    pattern = kind_of(finding.effect).sentence or f"{{joint}}: {finding.effect.replace('_', ' ')}"
    completed = OPTIONAL.sub(lambda part: _filled(part[1], known), pattern)
    named_only = f"{known['joint']} has {effect_words(finding.effect)}" if finding.left_out else ""
    return _filled(completed, known) or named_only or f"{known['joint']}: {finding.effect.replace('_', ' ')}"


def numbers(finding: Finding) -> dict[str, Any]:
    """Parameters of a finding that the data determine, and numbers that are derived from them, by name."""
    finding = replace(finding, parameters=finding.determined)
    kind, known = kind_of(finding.effect), formatted(finding)
    return known | dict(kind.derived(finding, known) if kind.derived else {})


def main_number(finding: Finding) -> str:
    """The first number in the sentence of a finding, with sign and unit; empty if it is not determined.

    A bare number, such as an exponent, only counts if all parameters are determined and no other number is.
    """
    known, shown, bare = numbers(finding), "", ""
    for _, name, form, _ in Formatter().parse(kind_of(finding.effect).sentence):
        words = (form or "").split()
        if isinstance(number := known.get(name or ""), Formatted) and "|" not in (form or ""):
            text = format(number, " ".join(word for word in words if word in SCALES))
            shown, bare = (shown, bare or text) if "bare" in words else (shown or text, bare)
    return shown or (bare if not finding.left_out else "")


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


def undecided_sentence(finding: Finding, joints: Sequence[str]) -> str:
    """Sentence on an undecided finding: its joints, its hypotheses, and why it is undecided."""
    where = joined([joint_words(joint, joints) for joint in finding.joints]) if finding.joints else "The arm"
    known = f"{where}: the missing effect may be "
    if finding.family:
        sure = percent(finding.family_probability, 3)
        known = f"{where} has {FAMILIES[finding.family].words} ({sure}): "
    return f"{known}{hypotheses_words(finding, joints)}{reservations(finding)}."


def possible(finding: Finding) -> list[Hypothesis]:
    """The finding and its alternatives, the most probable first, which need not be the fitted finding."""
    return sorted((finding, *finding.alternatives), key=lambda hypothesis: -hypothesis.probability)


LISTED = 3
"""Number of hypotheses that a sentence names; pages list all of them."""


def hypotheses_words(finding: Finding, joints: Sequence[str], probable: bool = True) -> str:
    """The most probable hypotheses of a finding, with joints if these differ.

    Joints that do not fit have no probabilities.
    """
    hypotheses = possible(finding)
    words = []
    for hypothesis in hypotheses[:LISTED]:
        where = joined([lower(joint_words(joint, joints)) for joint in hypothesis.joints] or ["the arm"])
        name = effect_words(hypothesis.effect)
        name += f" of {where}" if hypothesis.joints != finding.joints else ""
        words.append(f"{name} {percent(hypothesis.probability)}" if probable else name)
    words += ["another effect"] if len(hypotheses) > LISTED else []
    return joined(words, "or")


def reservations(finding: Finding) -> str:
    """Why a finding is undecided although its name may be probable, in parentheses; empty without reasons."""
    reasons = {
        "not proven": not finding.proven,
        "only one joint shows it": finding.alone,
        "or something like it": finding.unnamed,
    }
    words = [reason for reason, holds in reasons.items() if holds]
    return f" ({', '.join(words)})" if words else ""


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


def span(moment: Moment | Misfit) -> str:
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
