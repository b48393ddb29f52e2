"""Answer: a diagnosis as plain tables of numbers and words, for files and other programs."""

from typing import Any

import numpy as np

from .candidates.unlisted import UNLISTED
from .finding import Alternative, Diagnosis, Finding
from .sentences import sentence
from .words import verdict


def answer(diagnosis: Diagnosis) -> dict[str, Any]:
    """One case of an answer file, in the words of the vocabulary; joints count from 1."""
    return {
        "findings": [_named(finding) for finding in diagnosis.findings if finding.listed],
        "unexplained": diagnosis.unexplained,
        **_residuals(diagnosis),
        "seconds": round(diagnosis.seconds, 2),
    }


def _named(finding: Finding) -> dict[str, Any]:
    return {
        **_place(finding),
        "confidence": finding.probability,
        "alternatives": [_place(one) for one in finding.alternatives if one.effect not in UNLISTED],
    }


def _place(one: Finding | Alternative) -> dict[str, Any]:
    return {"effect": one.effect, "joints": [joint + 1 for joint in one.joints]}


def _residuals(diagnosis: Diagnosis) -> dict[str, Any]:
    """Torque residuals of the runs held out; nothing without any."""
    found = diagnosis.improvement
    if found is None:
        return {}
    return {
        "torque_rms_before": _numbers(found.before),
        "torque_rms_after": _numbers(found.after),
        "torque_rms_filter_hz": found.band,
    }


def plain(diagnosis: Diagnosis) -> dict[str, Any]:
    """All of a diagnosis but its samples, for diagnosis.json; what is no number is null."""
    found = diagnosis.improvement
    return {
        "exidyn_diagnosis": 1,
        "name": diagnosis.name,
        "joints": list(diagnosis.joints),
        "verdict": verdict(diagnosis),
        **answer(diagnosis),
        "findings": [_whole(finding, diagnosis) for finding in diagnosis.findings],
        "remainders": [one._asdict() | {"joint": one.joint + 1} for one in diagnosis.remainders],
        "noise": None if found is None else _numbers(found.noise),
        "runs": list(diagnosis.runs),
        "held_out": [] if found is None else list(found.runs),
        "doubts": list(diagnosis.doubts),
    }


def _whole(finding: Finding, diagnosis: Diagnosis) -> dict[str, Any]:
    return {
        **_place(finding),
        "sentence": sentence(finding, diagnosis.joints),
        "probability": finding.probability,
        "parameters": {
            name: {"value": number(value), "std": number(std), "unit": unit}
            for name, (value, std, unit) in finding.parameters.items()
        },
        "alternatives": [
            _place(other) | {"probability": number(other.probability)} for other in finding.alternatives
        ],
        "torque_rms": _numbers(finding.torque),
        "held_out": number(finding.held_out),
    }


def number(value: float) -> float | None:
    """A number that JSON has; NaN and infinity are none."""
    return float(value) if np.isfinite(value) else None


def _numbers(values: np.ndarray) -> list[float | None]:
    return [number(value) for value in values]
