"""Scores answers to concealed cases against their truths."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from .answers import Answer, Truth
from .coverage import Number, interval_coverage, numbers

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


def simulated_share(case: Pair) -> float:
    """Error of the simulated torque after over before, over the joints concerned; NaN if not simulated."""
    truth, answer = case
    chosen = np.array(concerned(truth), int) - 1
    if not len(answer.simulated_after) or not len(chosen):
        return float("nan")
    # Joints have noise floors of their own; a sum over them has to be in these.
    after, before = (
        np.linalg.norm(rms[chosen] / truth.noise[chosen])
        for rms in (answer.simulated_after, answer.simulated_before)
    )
    return float(after / before)


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
    simulated = [simulated_share(case) for case in single + double if top1(case)]
    simulated = [value for value in simulated if np.isfinite(value)]
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
        "interval_coverage": interval_coverage(sizes),
        "residual_over_noise": float(np.median(left)) if left else float("nan"),
        "residual_over_noise_max": max(left, default=float("nan")),
        "simulated": len(simulated),
        "simulated_better": share(value < 1.0 for value in simulated),
        "simulated_share": float(np.median(simulated)) if simulated else float("nan"),
        "seconds": float(np.median(seconds)) if seconds else float("nan"),
        "seconds_max": max(seconds, default=float("nan")),
    }
