"""Scores answers to concealed cases against their truths, and how often 95 % intervals contain the truth.

The plant has its own formulas. Only numbers with one meaning count: masses, shares, times, angles, and
coefficients of laws that both have.
"""

import json
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from common import show

from exidyn.identification.diagnosis.candidates import kind_of, kinds
from exidyn.identification.diagnosis.findings.family import FAMILIES
from exidyn.identification.text_table import NORMAL_95

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


Parameters = Mapping[str, Any]


class Number(NamedTuple):
    """One diagnosed number beside its truth."""

    effect: str  # Name in the vocabulary
    name: str  # Of the number, without that of its joint
    true: float  # Its true value
    value: float  # As diagnosed
    std: float  # Its standard deviation

    @property
    def held(self) -> bool:
        """Whether its 95 % interval contains the truth."""
        return bool(abs(self.value - self.true) <= NORMAL_95 * self.std)


def _tilt(truth: Parameters) -> dict[str, float]:
    angle, heading = np.deg2rad(truth["degrees"]), truth["heading"]
    return {"tilt_x": np.sin(angle) * np.cos(heading), "tilt_y": np.sin(angle) * np.sin(heading)}


def _balancer(truth: Parameters) -> dict[str, float]:
    """Its numbers relative to `d21`, which no torque shows."""
    fixed, moving = truth["d21"], truth["d22"]
    forces = {"Kr*d21^2": truth["Kr"] * fixed**2, "K0*d21": truth["K0"] * fixed}
    return {**forces, "d22/d21": moving / fixed, "phi": truth["phi"]}


SAME: Mapping[str, Callable[[Parameters], Mapping[str, float]]] = {
    "payload": lambda truth: {"M": truth["mass"]},
    "link_inertia": lambda truth: {"M": truth["mass"]},
    # Only that of a rotor which the model lacks is known beside the model's.
    "rotor_inertia": lambda truth: {"Ia": truth["Ia"]} if truth["missing"] else {},
    "base_tilt": _tilt,
    "viscous_friction": lambda truth: {"Fv": truth["Fv"]},
    "coulomb_friction": lambda truth: {"Fc": truth["Fc"]},
    "stribeck_friction": lambda truth: {"Fs": truth["rise"], "fade": truth["speed"]},
    "load_dependent_friction": lambda truth: {"mu": truth["mu"]},
    "nonlinear_viscous_friction": lambda truth: {"Fn": truth["coefficient"], "exponent": truth["power"]},
    "drive_gain": lambda truth: {"share": truth["error"]},
    "current_offset": lambda truth: {"Off": -truth["offset"]},  # torque beside the current's: so much less
    "spring_balancer": _balancer,
    "joint_elasticity": lambda truth: {"stiffness": truth["stiffness"]},
    "backlash": lambda truth: {"gap": truth["gap"]},
    "encoder_offset": lambda truth: {"zero": truth["radians"]},
    "time_delay": lambda truth: {"delay": truth["seconds"]},
}
"""Effect -> its numbers by the truth, in the names and signs of the diagnosis."""


def numbers(
    truth: Guess, parameters: Parameters, stated: Mapping[str, Sequence[float | None]]
) -> list[Number]:
    """Numbers of a finding that is right about an effect, `stated` with deviations, beside the truth's."""
    known = truth.effect in SAME and bool(parameters)  # older truths have no numbers
    true = SAME[truth.effect](parameters) if known else {}
    endings = {str(joint) for joint in truth.joints} | {""}
    pairs = []
    for name, value in true.items():
        pair = next((stated[name + ending] for ending in endings if name + ending in stated), None)
        if pair is not None and None not in pair:
            pairs.append(Number(truth.effect, name, float(value), *map(float, pair)))  # type: ignore[arg-type]
    return pairs


def interval_coverage(every: Sequence[Number]) -> float:
    """Share of 95 % intervals that contain the truth [%]; NaN of none."""
    return 100.0 * float(np.mean([one.held for one in every])) if every else float("nan")


def coverage_rows(every: Iterable[Number]) -> list[list[Any]]:
    """One row a number of an effect: count, contained [%], median error and half interval [%], error/std."""
    groups: dict[tuple[str, str], list[Number]] = {}
    for one in every:
        groups.setdefault((one.effect, one.name), []).append(one)
    rows = []
    for (effect, name), own in sorted(groups.items()):
        apart = np.array([one.value - one.true for one in own])
        std, true = np.array([one.std for one in own]), np.abs([one.true for one in own])
        error, half = (100.0 * float(np.median(x / true)) for x in (np.abs(apart), NORMAL_95 * std))
        deviations = float(np.sqrt(np.mean((apart / std) ** 2)))
        rows.append([effect, name, len(own), interval_coverage(own), error, half, deviations])
    return rows


DETECTABLE = 50.0
"""Gain in chi-squared from which an oracle can distinguish an effect from hundreds on other joints."""


class Pair(NamedTuple):
    """A case's truth and its answer."""

    truth: Truth
    answer: Answer


def pairs(truths: Mapping[str, Truth], answers: Mapping[str, Answer]) -> list[Pair]:
    """Cases that were answered."""
    return [Pair(truth, answers[name]) for name, truth in truths.items() if name in answers]


def share(right: Iterable[bool]) -> float:
    """Part that is true; NaN of nothing."""
    values = list(right)
    return float(np.mean(values)) if values else float("nan")


def of_kind(cases: Iterable[Pair], kind: str) -> list[Pair]:
    """Cases of a kind."""
    return [case for case in cases if case.truth.kind == kind]


def top1(case: Pair) -> bool:
    """Whether the first finding is right, effect and joint."""
    findings = case.answer.findings
    return bool(findings) and any(findings[0].guess.meets(truth) for truth in case.truth.effects)


def covered(case: Pair) -> bool:
    """Whether the first finding or one of its alternatives is right."""
    findings = case.answer.findings
    return bool(findings) and any(findings[0].covers(truth) for truth in case.truth.effects)


def joint_right(case: Pair) -> bool:
    """Whether the first finding is on the right joint, whatever its name."""
    findings = case.answer.findings
    return bool(findings) and any(findings[0].guess.same_joints(truth) for truth in case.truth.effects)


def recalled(case: Pair) -> list[bool]:
    """Of every effect that is concealed, whether any finding is right about it."""
    return [any(found.guess.meets(truth) for found in case.answer.findings) for truth in case.truth.effects]


def family_recalled(case: Pair) -> list[bool]:
    """Of every effect that is concealed, whether any finding names its dependence on its joint."""
    return [any(found.related(truth) for found in case.answer.findings) for truth in case.truth.effects]


def precise(case: Pair) -> list[bool]:
    """Of every finding, whether it is right."""
    return [any(found.guess.meets(truth) for truth in case.truth.effects) for found in case.answer.findings]


def alarmed(case: Pair) -> bool:
    """Whether anything was reported."""
    return bool(case.answer.findings) or case.answer.unexplained


def diagnosed_numbers(case: Pair) -> list[Number]:
    """Numbers of findings that are right, beside their truth."""
    return [
        number
        for truth, parameters in zip(case.truth.effects, case.truth.parameters, strict=False)
        for found in case.answer.findings
        if found.guess.meets(truth)
        for number in numbers(truth, parameters, found.numbers)
    ]


def concerned(truth: Truth) -> list[int]:
    """Joints that effects are on, or that they move most, from 1."""
    return sorted({joint for effect in truth.effects for joint in effect.joints} | set(truth.loudest))


def residual_over_noise(case: Pair) -> float:
    """Residual held out over the noise floor, on the worst of the joints concerned; NaN if not comparable."""
    truth, answer = case
    if len(answer.after) != len(truth.noise) or not concerned(truth):
        return float("nan")
    if answer.filter_hz is None:
        noise = truth.noise
    elif np.isclose(answer.filter_hz, truth.filter_hz):
        noise = truth.noise_filtered
    else:
        return float("nan")
    chosen = np.array(concerned(truth)) - 1
    return float(np.max(answer.after[chosen] / noise[chosen]))


def visible(case: Pair) -> bool:
    """Whether an oracle sees it; unknown strengths are taken to be visible."""
    return all(not value < DETECTABLE for value in case.truth.evidence)


def figures(cases: list[Pair]) -> dict[str, Any]:
    """All figures of a scoring, by name."""
    single, double, outside, none = (of_kind(cases, kind) for kind in ("single", "double", "outside", "none"))
    seen = [case for case in single if visible(case)]
    placed = [case for case in seen if case.truth.effects[0].joints]
    left = [residual_over_noise(case) for case in seen + double if top1(case)]
    left = [value for value in left if np.isfinite(value)]
    seconds = [case.answer.seconds for case in cases]
    sizes = [number for case in cases for number in diagnosed_numbers(case)]
    return {
        "cases": len(cases),
        "detectable": len(seen),
        "top1": share(map(top1, seen)),
        "top1_all_strengths": share(map(top1, single)),
        "with_alternatives": share(map(covered, seen)),
        "wrong_name": share(bool(case.answer.findings) and not top1(case) for case in single),
        "family_recall": share(right for case in seen + double for right in family_recalled(case)),
        "joint": share(map(joint_right, placed)),
        "false_alarms": sum(map(alarmed, none)),
        "nothing_cases": len(none),
        "double_recall": share(right for case in double for right in recalled(case)),
        "double_precision": share(right for case in double for right in precise(case)),
        "outside_misnamed": share(bool(case.answer.findings) for case in outside),
        "outside_unexplained": share(case.answer.unexplained for case in outside),
        "intervals": len(sizes),
        "interval_coverage_percent": interval_coverage(sizes),
        "residual_over_noise": float(np.median(left)) if left else float("nan"),
        "residual_over_noise_max": max(left, default=float("nan")),
        "seconds": float(np.median(seconds)) if seconds else float("nan"),
        "seconds_max": max(seconds, default=float("nan")),
    }


STRENGTHS = (0.0, 0.5, 1.0, 2.0, 5.0, np.inf)
CONFIDENCES = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0 + 1e-9)


def calibration(cases: list[Pair]) -> list[list[Any]]:
    """Stated probability against the share that was right: from, to, findings, mean stated, right."""
    stated = [
        (found.confidence, right)
        for case in cases
        for found, right in zip(case.answer.findings, precise(case), strict=True)
    ]
    return classes(stated)


def classes(stated: list[tuple[float, bool]]) -> list[list[Any]]:
    """Pairs of a stated probability and whether it was right, by classes of the first."""
    rows: list[list[Any]] = []
    for low, high in zip(CONFIDENCES, CONFIDENCES[1:], strict=False):
        inside = [pair for pair in stated if low <= pair[0] < high]
        if inside:
            rows.append([low, min(high, 1.0), len(inside), *np.mean(inside, axis=0)])
    return rows


def by_strength(cases: list[Pair]) -> list[list[Any]]:
    """Detectable singles by visibility: from, to, cases, top 1, with alternatives, reported as nothing."""
    rows: list[list[Any]] = []
    for low, high in zip(STRENGTHS, STRENGTHS[1:], strict=False):
        inside = [
            case
            for case in of_kind(cases, "single")
            if visible(case) and low <= case.truth.visibility[0] < high
        ]
        if inside:
            silent = share(not alarmed(case) for case in inside)
            rows.append(
                [low, high, len(inside), share(map(top1, inside)), share(map(covered, inside)), silent]
            )
    return rows


def confusion(cases: list[Pair]) -> list[list[Any]]:
    """What singles, outside and nothing were called: truth, called, times; agreement left out."""
    counts: Counter[tuple[str, str]] = Counter()
    for truth, answer in cases:
        if truth.kind == "double":
            continue
        name = truth.effects[0].effect if truth.effects else NOTHING
        right = top1(Pair(truth, answer)) if truth.kind == "single" else answer.called == (
            UNEXPLAINED if truth.kind == "outside" else NOTHING
        )  # fmt: skip
        if not right:
            wrong_joint = truth.kind == "single" and answer.called == name
            counts[name, "the same, on another joint" if wrong_joint else answer.called] += 1
    return [[name, called, times] for (name, called), times in sorted(counts.items())]


def outside(cases: list[Pair]) -> list[list[Any]]:
    """Cases outside the vocabulary, of kinds that are asked for all the same and of others.

    Returns:
        Of both: which, cases, share misnamed, share reported as unexplained.
    """
    asked, rows = kinds(), []
    every = of_kind(cases, "outside")
    for which, known in (("has a candidate", True), ("has none", False)):
        own = [case for case in every if (case.truth.effects[0].effect in asked) == known]
        misnamed = share(bool(case.answer.findings) for case in own)
        rows.append([which, len(own), misnamed, share(case.answer.unexplained for case in own)])
    return rows if every else []


def coverage(cases: list[Pair]) -> list[list[Any]]:
    """Diagnosed numbers whose truth is known: how many, whose 95 % interval contains it, and their errors."""
    return coverage_rows(number for case in cases for number in diagnosed_numbers(case))


def missed(cases: list[Pair]) -> list[list[Any]]:
    """Diagnosed numbers whose 95 % interval does not contain their truth, with half of that interval."""
    return [
        [case.truth.name, one.effect, one.name, one.true, one.value, NORMAL_95 * one.std]
        for case in cases
        for one in diagnosed_numbers(case)
        if not one.held
    ]


class Table(NamedTuple):
    """One table of scores, by what its rows are made."""

    title: str
    header: tuple[str, ...]
    rows: Callable[[list[Pair]], list[list[Any]]]


TABLES = {
    "outside": Table(
        "outside the vocabulary", ("the diagnosis", "cases", "misnamed", "unexplained"), outside
    ),
    "by_strength": Table(
        "by strength (effect over noise)",
        ("from", "to", "cases", "top 1", "with alternatives", "silent"),
        by_strength,
    ),
    "calibration": Table("stated probabilities", ("from", "to", "findings", "stated", "right"), calibration),
    "coverage": Table(
        "95 % intervals of diagnosed numbers (medians; error over std is a root mean square)",
        ("effect", "number", "count", "contained %", "error %", "half interval %", "error / std"),
        coverage,
    ),
    "missed": Table(
        "95 % intervals that do not contain the truth",
        ("case", "effect", "number", "true", "diagnosed", "half interval"),
        missed,
    ),
    "confusion": Table("called otherwise", ("truth", "called", "times"), confusion),
}
"""In the order in which they are printed."""


def print_scores(answered: Mapping[str, list[Pair]]) -> dict[str, Any]:
    """Print every table, each way to answer beside the others.

    Returns:
        Figures and tables by name: those of the first way, and those of each other under its name.
    """
    several = len(answered) > 1
    numbers = {who: figures(cases) for who, cases in answered.items()}
    tables = {who: {name: one.rows(cases) for name, one in TABLES.items()} for who, cases in answered.items()}
    first, *others = answered
    rows = [[name, *(found[name] for found in numbers.values())] for name in numbers[first]]
    show("concealed cases", ["figure", *(answered if several else ["value"])], rows)
    for name, table in TABLES.items():
        rows = [[who, *row] if several else row for who in answered for row in tables[who][name]]
        if rows:
            show(table.title, ["answered", *table.header] if several else table.header, rows)
    return numbers[first] | tables[first] | {who: numbers[who] | tables[who] for who in others}
