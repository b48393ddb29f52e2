"""Answers and truths of concealed cases, and whether a finding is right."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identification.diagnosis.candidates import kind_of
from exidyn.identification.diagnosis.findings.family import FAMILIES

BY_SHAPE = "velocity"
"""What effects depend on whose family follows from their shape: all are friction over velocity."""


def dependence(effect: str) -> str:
    """What the torque of an effect depends on; its own name where it is of no family."""
    family = kind_of(effect).family
    return BY_SHAPE if callable(family) else FAMILIES[family].dependence if family else effect


NOTHING, UNEXPLAINED = "nothing", "unexplained"


@dataclass(frozen=True)
class Guess:
    """An effect on joints, counted from 1; none for the whole arm."""

    effect: str
    joints: frozenset[int]

    def meets(self, truth: "Guess") -> bool:
        """Whether it is what is concealed; of an effect between two joints, one of them will do."""
        return self.effect == truth.effect and self.same_joints(truth)

    def same_joints(self, truth: "Guess") -> bool:
        """Whether the joints are right; what belongs to the whole arm is on any."""
        if not truth.joints:
            return True
        return self.joints == truth.joints or (
            len(truth.joints) > 1 and bool(self.joints) and self.joints < truth.joints
        )


@dataclass(frozen=True)
class Finding:
    """A guess with its stated probability, what else it might be, and its numbers (value, std)."""

    guess: Guess
    confidence: float
    alternatives: tuple[Guess, ...]
    family: str = ""
    family_confidence: float = float("nan")
    numbers: Mapping[str, tuple[float | None, float | None]] = field(default_factory=dict)

    def related(self, truth: Guess) -> bool:
        """Whether it depends on what the truth depends on, by the family that it names, or by its name."""
        depends_on = FAMILIES[self.family].dependence if self.family else dependence(self.guess.effect)
        return depends_on == dependence(truth.effect) and self.guess.same_joints(truth)

    def covers(self, truth: Guess) -> bool:
        """Whether the guess or an alternative is right."""
        return any(guess.meets(truth) for guess in (self.guess, *self.alternatives))


@dataclass(frozen=True)
class Answer:
    """Answer about a case; rms held out, (n,) [N m], behind a low-pass if one is named."""

    findings: tuple[Finding, ...]
    unexplained: bool
    before: np.ndarray
    after: np.ndarray
    filter_hz: float | None
    seconds: float

    @property
    def called(self) -> str:
        """The first finding in a word."""
        if self.findings:
            return self.findings[0].guess.effect
        return UNEXPLAINED if self.unexplained else NOTHING


@dataclass(frozen=True)
class Truth:
    """What is concealed in a case; `visibility` and `evidence` are NaN where not measured.

    Parameters are those of each effect, in the plant's own words.
    """

    name: str
    kind: str
    robot: str
    effects: tuple[Guess, ...]
    visibility: tuple[float, ...]
    evidence: tuple[float, ...]
    loudest: tuple[int, ...]
    noise: np.ndarray
    noise_filtered: np.ndarray
    filter_hz: float
    parameters: tuple[Mapping[str, Any], ...] = ()


def _guess(effect: str, joints: Any) -> Guess:
    return Guess(effect, frozenset(int(joint) for joint in joints or ()))


def _finding(found: Mapping[str, Any]) -> Finding:
    guess = _guess(found["effect"], found.get("joints"))
    others = [
        Guess(other, guess.joints)  # a bare name is on the same joints
        if isinstance(other, str)
        else _guess(other["effect"], other.get("joints", guess.joints))
        for other in found.get("alternatives", ())
    ]
    return Finding(
        guess,
        float(found.get("confidence", np.nan)),
        tuple(others),
        found.get("family", ""),
        float(found.get("family_confidence", np.nan)),
        found.get("parameters", {}),
    )


def read_answer(case: Mapping[str, Any]) -> Answer:
    """One case of an answer file."""
    return Answer(
        tuple(_finding(found) for found in case.get("findings", ())),
        bool(case.get("unexplained", False)),
        np.array(case.get("torque_rms_before", ()), float),
        np.array(case.get("torque_rms_after", ()), float),
        case.get("torque_rms_filter_hz"),
        float(case.get("seconds", np.nan)),
    )


def read_truth(path: Path) -> Truth:
    """A truth file."""
    case = json.loads(path.read_text())
    effects = case["effects"]
    return Truth(
        case["name"],
        case["kind"],
        case["robot"],
        tuple(_guess(effect["effect"], effect["joints"]) for effect in effects),
        tuple(float(effect.get("visibility", np.nan)) for effect in effects),
        tuple(float(effect.get("evidence", np.nan)) for effect in effects),
        tuple(1 + int(np.argmax(seen)) for seen in (e.get("visibility_by_joint") for e in effects) if seen),
        np.array(case["noise_floor"], float),
        np.array(case["noise_floor_filtered"], float),
        float(case["noise_filter_hz"]),
        tuple(effect.get("parameters", {}) for effect in effects),
    )


def read_truths(folder: Path) -> dict[str, Truth]:
    """All truth files of a folder."""
    return {path.stem: read_truth(path) for path in sorted(folder.glob("*.json"))}
