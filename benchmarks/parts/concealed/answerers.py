"""Who answers concealed cases: the product, with the values that a case states and without."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

Answerer = Callable[[Path], dict[str, Any]]
"""From the folder of a case to its answer; it can be sent to another process."""
COMPARISON_CUTOFF = 25.0
"""Low-pass cutoff [Hz], a part of the cases' format: residuals of different programs are comparable only with
the same filter."""


def product(folder: Path, values: bool = True) -> dict[str, Any]:
    """Exidyn's answer, given the folder of the case and nothing else; `values`: with those that it states."""
    from exidyn.identification.diagnosis import diagnose
    from exidyn.identification.preparation.prepare import Filtering

    from .answer import answer
    from .case_folder import read_case

    runs = read_case(folder)
    roles = [(run.settings["role"], run) for run in runs]
    model = runs[0].model
    if not values:
        model = replace(model, stated={}, robot=replace(model.robot, inertias_stated=False))
    diagnosis = diagnose(model, roles, filtering=Filtering(torque_cutoff=COMPARISON_CUTOFF))
    found: dict[str, Any] = answer(diagnosis)
    return found


ANSWERERS: dict[str, Answerer] = {"product": product, "bare": partial(product, values=False)}
