"""Sentences: a finding in words, with its numbers."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..candidates import kind_of
from ..findings.finding import Finding
from ..findings.quantities import SLIDING, TURNING, formatted
from .naming import joint_words as joint_words
from .naming import lower as lower

OPTIONAL = re.compile(r"\[([^\[\]]*)\]")


def sentence(finding: Finding, joints: Sequence[str], sliding: bool = False) -> str:
    """The finding as a sentence, without a full stop.

    Args:
        finding: Of any effect; one without a sentence is given by its name.
        joints: Names of the robot's joints.
        sliding: Whether its joints slide.
    """
    kind, known = kind_of(finding.effect), formatted(finding)
    derived = kind.derived(finding, known) if kind.derived else {}
    known |= {**derived, **_places(finding, joints), **_units(known, sliding)}
    pattern = kind.sentence or f"{{joint}}: {finding.effect.replace('_', ' ')}"
    whole = OPTIONAL.sub(lambda part: _filled(part[1], known), pattern)
    return _filled(whole, known) or f"{known['joint']}: {finding.effect.replace('_', ' ')}"


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
    """What depends on how the joint moves, and is in no parameter's unit."""
    if not sliding:
        pace = (
            {"pace": f"{known['harmonic']:bare} times per turn of the joint"} if "harmonic" in known else {}
        )
        return {"effort": TURNING, "one": "1 rad/s"} | pace
    # Waves of the position in metres, as if it were an angle.
    known_wave = known.get("harmonic")
    pace = {"pace": f"in a wave {2 * np.pi / known_wave.value:.3g} m long"} if known_wave else {}
    return {"effort": SLIDING, "one": "1 m/s"} | pace
