"""Content of diagnosis.json, with numbers and sentences but without samples, and of answer files."""

from collections.abc import Iterable
from typing import Any

from ...result_file import to_table
from ..findings.diagnosis import Diagnosis
from ..findings.finding import Finding, Hypothesis
from .naming import finding_names
from .sentences import possible, undecided_sentence
from .verdict import certainty, headline, sized, undecided, verdict

FORMAT = 2
"""Version of the format of diagnosis.json."""


def as_json(diagnosis: Diagnosis, folder: str = "") -> dict[str, Any]:
    """The content of diagnosis.json.

    The sentences are for readers of the file; exidyn itself reads only the numbers.

    Args:
        diagnosis: The diagnosis.
        folder: Folder with the models of findings and rivals; empty if they are not written.
    """
    table = to_table(diagnosis)
    if diagnosis.simulated is None:
        del table["simulated"]
    words = [*_words_of_findings(diagnosis, folder), *_words_of_undecided(diagnosis, folder)]
    rows = [*table["findings"], *table["undecided"]]
    for row, name, sentences in zip(rows, finding_names(diagnosis), words, strict=True):
        row |= {"name": name, **sentences}
    head = {
        "exidyn_diagnosis": FORMAT,
        "unexplained": diagnosis.unexplained,
        "verdict": verdict(diagnosis, folder),
    }
    return head | table


def _words_of_findings(diagnosis: Diagnosis, folder: str) -> Iterable[dict[str, str]]:
    for finding in diagnosis.findings:
        yield {
            "sentence": sized(diagnosis, finding),
            "headline": headline(diagnosis, finding),
            "certainty": certainty(diagnosis, finding, folder),
        }


def _words_of_undecided(diagnosis: Diagnosis, folder: str) -> Iterable[dict[str, str]]:
    for finding in diagnosis.undecided:
        yield {
            "sentence": undecided_sentence(finding, diagnosis.joints).removesuffix("."),
            "headline": undecided(diagnosis, finding, folder),
            "certainty": "",
        }


def answer(diagnosis: Diagnosis) -> dict[str, Any]:
    """One case of an answer file, with names of the vocabulary; joints count from 1.

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
