"""Answer: a diagnosis as plain tables of numbers and words, for files and other programs."""

from typing import Any

from ..findings.finding import Alternative, Diagnosis, Finding, Remainder
from .changes_words import as_table as changes_table
from .measures import by_kind, noise_measured, slides, torque_units
from .misfit import as_table, misfit
from .moments_words import as_table as moments_table
from .numbers import number, numbers
from .sentences import sentence
from .undecided_words import undecided_sentence
from .words import left_on, verdict


def answer(diagnosis: Diagnosis) -> dict[str, Any]:
    """One case of an answer file, in the words of the vocabulary; joints count from 1.

    What is undecided is answered with the most probable name, and its confidence shows it.
    """
    every = (*diagnosis.findings, *diagnosis.undecided)
    return {
        "findings": [_named(finding) for finding in every if finding.listed],
        "unexplained": diagnosis.unexplained,
        **_residuals(diagnosis),
        "seconds": round(diagnosis.seconds, 2),
    }


def _named(finding: Finding) -> dict[str, Any]:
    every: list[Finding | Alternative] = [finding]
    every += [one for one in finding.alternatives if one.listed]
    first, *rest = sorted(every, key=lambda one: -one.probability)
    return {
        **_place(first),
        "confidence": first.probability,
        "alternatives": [_place(one) for one in rest],
    }


def _place(one: Finding | Alternative) -> dict[str, Any]:
    return {"effect": one.effect, "joints": [joint + 1 for joint in one.joints]}


def _residuals(diagnosis: Diagnosis) -> dict[str, Any]:
    """Torque residuals of the runs held out; nothing without any."""
    found = diagnosis.improvement
    if found is None:
        return {}
    return {
        "torque_rms_before": numbers(found.before),
        "torque_rms_after": numbers(found.after),
        "torque_rms_filter_hz": found.band,
    }


def plain(diagnosis: Diagnosis) -> dict[str, Any]:
    """All of a diagnosis but its samples, for diagnosis.json; what is no number is null."""
    diagnosis = by_kind(diagnosis)
    found, budget = diagnosis.improvement, misfit(diagnosis)
    return {
        "exidyn_diagnosis": 1,
        "name": diagnosis.name,
        "joints": list(diagnosis.joints),
        "torque_units": list(torque_units(diagnosis)),
        "budget": None if budget is None else as_table(budget),
        "verdict": verdict(diagnosis),
        **answer(diagnosis),
        "findings": [_whole(finding, diagnosis) for finding in diagnosis.findings],
        "undecided": [_open(finding, diagnosis) for finding in diagnosis.undecided],
        "remainders": [_remainder(one, diagnosis) for one in diagnosis.remainders],
        "moments": moments_table(diagnosis.moments),
        "changes": changes_table(diagnosis.changes),
        "noise": None if found is None else numbers(found.noise),
        "noise_measured_at_rest": noise_measured(diagnosis),
        "runs": list(diagnosis.runs),
        "held_out": [] if found is None else list(found.runs),
        "warnings": list(diagnosis.warnings),
    }


def _remainder(one: Remainder, diagnosis: Diagnosis) -> dict[str, Any]:
    return one._asdict() | {
        "joint": one.joint + 1,
        "over_noise": number(one.over_noise),
        "left": left_on(one, diagnosis),
    }


def _open(finding: Finding, diagnosis: Diagnosis) -> dict[str, Any]:
    text = undecided_sentence(finding, diagnosis.joints).removesuffix(".")
    return _whole(finding, diagnosis) | {"sentence": text}


def _whole(finding: Finding, diagnosis: Diagnosis) -> dict[str, Any]:
    return {
        **_place(finding),
        "sentence": sentence(finding, diagnosis.joints, slides(diagnosis, finding)),
        "probability": finding.probability,
        "parameters": {
            name: {"value": number(value), "std": number(std), "unit": unit}
            for name, (value, std, unit) in finding.parameters.items()
        },
        "alternatives": [
            _place(other) | {"probability": number(other.probability)} for other in finding.alternatives
        ],
        "torque_rms": numbers(finding.torque),
        "held_out": number(finding.held_out),
    }
