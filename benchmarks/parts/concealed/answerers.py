"""Who answers concealed cases: the product, and two that show what the scores mean."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .write import truth_table

if TYPE_CHECKING:
    from exidyn.identification.model import Model

Answerer = Callable[[Path], dict[str, Any]]
"""From the folder of a case to its answer; it can be sent to another process."""


def product(folder: Path, values: bool = True) -> dict[str, Any]:
    """Exidyn's answer, given the folder of the case and nothing else; `values`: with those that it states."""
    from exidyn.acquire.files.given_runs import COMPARISON_CUTOFF
    from exidyn.identification.diagnosis import diagnose
    from exidyn.identification.diagnosis.words.diagnosis_file import answer
    from exidyn.identification.preparation.prepare import Filtering
    from exidyn.identification.recordings.importers import import_source

    runs = import_source(folder)
    roles = [(run.settings["role"], run) for run in runs]
    model = runs[0].model if values else without_values(runs[0].model)
    diagnosis = diagnose(model, roles, filtering=Filtering(torque_cutoff=COMPARISON_CUTOFF))
    found: dict[str, Any] = answer(diagnosis)
    return found


def without_values(model: "Model") -> "Model":
    """A model with inertias, friction and offsets unstated."""
    return replace(model, stated={}, robot=replace(model.robot, inertias_stated=False))


def silent(folder: Path) -> dict[str, Any]:
    """Never finds anything: what a score is worth without work."""
    return {"findings": [], "unexplained": False, "seconds": 0.0}


def oracle(folder: Path, truths: Path) -> dict[str, Any]:
    """Reads the truth: whether the scorer gives full marks."""
    truth = truth_table(truths, folder.name)
    outside = truth["kind"] == "outside"
    findings = [
        {"effect": effect["effect"], "joints": effect["joints"], "confidence": 1.0, "alternatives": []}
        for effect in truth["effects"]
    ]
    return {
        "findings": [] if outside else findings,
        "unexplained": outside,
        "torque_rms_before": truth["noise_floor_filtered"],
        "torque_rms_after": truth["noise_floor_filtered"],
        "torque_rms_filter_hz": truth["noise_filter_hz"],
        "seconds": 0.0,
    }


def answerer(name: str, truths: Path) -> Answerer:
    """By name: product, bare, silent or oracle."""
    return {
        "product": product,
        "bare": partial(product, values=False),
        "silent": silent,
        "oracle": partial(oracle, truths=truths),
    }[name]


NAMES = ("product", "bare", "silent", "oracle")
