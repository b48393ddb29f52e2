"""Who answers concealed cases: the product, simulating or not, and two that show what the scores mean."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .recordings.truth import truth_table

if TYPE_CHECKING:
    from exidyn.identification.model import Model

Answerer = Callable[[Path], dict[str, Any]]
"""From the folder of a case to its answer; it can be sent to another process."""
COMPARISON_CUTOFF = 25.0
"""Low-pass cutoff [Hz], a part of the cases' format: residuals of different programs are comparable only with
the same filter."""


def product(folder: Path, simulate: bool = False, values: bool = True) -> dict[str, Any]:
    """Exidyn's answer; it is given the folder of the case and nothing else.

    Args:
        folder: Of the case.
        simulate: Whether the run held out is simulated too, nominal and with what was found.
        values: Whether the values that the case states of inertias and friction are used.
    """
    from exidyn.identification.diagnosis import diagnose
    from exidyn.identification.diagnosis.improved.forward import forward
    from exidyn.identification.errors import ExidynError
    from exidyn.identification.preparation.prepare import Filtering

    from .answer import answer
    from .case_folder import read_case

    runs = read_case(folder)
    roles = [(run.settings["role"], run) for run in runs]
    model = runs[0].model if values else without_values(runs[0].model)
    diagnosis = diagnose(model, roles, filtering=Filtering(torque_cutoff=COMPARISON_CUTOFF))
    given: dict[str, Any] = answer(diagnosis)
    if not simulate or not given["findings"]:
        return given
    [held_out] = [run for run in runs if run.settings["role"] == "validate"]
    try:
        simulated = forward(diagnosis, held_out)
    except ExidynError as error:  # the answer stands all the same
        return given | {"not_simulated": str(error)}
    assert simulated is not None
    return given | {
        "simulated_before": simulated.before.tolist(),
        "simulated_after": simulated.after.tolist(),
    }


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
    """By name: product, bare, simulating, silent or oracle."""
    return {
        "product": product,
        "bare": partial(product, values=False),
        "simulating": partial(product, simulate=True),
        "silent": silent,
        "oracle": partial(oracle, truths=truths),
    }[name]


NAMES = ("product", "bare", "simulating", "silent", "oracle")
