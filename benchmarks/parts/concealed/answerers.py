"""Who answers concealed cases: the product, with the values that a case states and without."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from exidyn.identification.diagnosis import Diagnosis, diagnose
from exidyn.identification.diagnosis.findings.finding import Finding, Hypothesis
from exidyn.identification.diagnosis.words.sentences import possible
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.result_file import to_table

from .case_folder import read_case

Answerer = Callable[[Path], dict[str, Any]]
"""From the folder of a case to its answer; it can be sent to another process."""
COMPARISON_CUTOFF = 25.0
"""Low-pass cutoff [Hz], a part of the cases' format: residuals of different programs are comparable only with
the same filter."""


def product(folder: Path, values: bool = True) -> dict[str, Any]:
    """Exidyn's answer, given the folder of the case and nothing else; `values`: with those that it states."""
    runs = read_case(folder)
    roles = [(run.settings["role"], run) for run in runs]
    model = runs[0].model
    if not values:
        model = replace(model, stated={}, robot=replace(model.robot, inertias_stated=False))
    diagnosis = diagnose(model, roles, filtering=Filtering(torque_cutoff=COMPARISON_CUTOFF))
    return answer(diagnosis)


def answer(diagnosis: Diagnosis) -> dict[str, Any]:
    """Answer of one case, with names of the vocabulary; joints count from 1.

    An undecided finding is answered with its most probable name and the low confidence of that name. A curve
    without a formula is answered with the most probable formula.
    """
    residuals = {
        "torque_rms_before": to_table(diagnosis.torque_rms_before),
        "torque_rms_after": to_table(diagnosis.torque_rms_after),
        "torque_rms_filter_hz": diagnosis.torque_rms_filter_hz,
    }
    return {
        "findings": [answered for answered in map(_answered, diagnosis.all_findings) if answered],
        "unexplained": diagnosis.unexplained,
        **(residuals if diagnosis.held_out else {}),
        "seconds": round(diagnosis.seconds, 2),
    }


def _answered(finding: Finding) -> dict[str, Any]:
    """The most probable hypothesis in the vocabulary and a certain family; empty without a hypothesis."""
    names = [hypothesis for hypothesis in possible(finding) if hypothesis.listed]
    if not names:
        return {}
    first, *others = names
    family = {"family": finding.family, "family_confidence": finding.family_probability}
    stated = finding.determined if first is finding else {}
    return {
        **_place(first),
        "confidence": first.probability,
        "alternatives": [_place(other) for other in others],
        **(family if finding.family else {}),
        "parameters": {name: to_table((number.value, number.std)) for name, number in stated.items()},
    }


def _place(hypothesis: Hypothesis) -> dict[str, Any]:
    return {"effect": hypothesis.effect, "joints": [joint + 1 for joint in hypothesis.joints]}


ANSWERERS: dict[str, Answerer] = {"product": product, "bare": partial(product, values=False)}
