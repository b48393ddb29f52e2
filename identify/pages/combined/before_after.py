"""Before and after: how much better the arm is predicted with what was identified and what was found."""

from collections.abc import Sequence

import numpy as np

from ...fit.agreement import Agreement
from ...fit.fit import Fit
from ..diagnosis.plots import bars
from ..diagnosis.sections import forward_section, improvement
from ..report_html import figure, grid, paragraph, section
from .compared import compared_sections
from .material import Fitted, Material


def before_and_after(material: Material) -> str:
    """What identification gained, what the diagnosis gained, and what simulations come to."""
    fits = [_identified(fitted, place) for place, fitted in enumerate(material.fits)]
    return "".join([*fits, _diagnosed(material), compared_sections(material.comparisons)])


def _identified(fitted: Fitted, place: int) -> str:
    """Nominal values beside identified ones; nothing without samples."""
    if fitted.nominal is None or not (runs := _runs(fitted.fit)):
        return ""
    before, after = (_rms(_runs(fit)) for fit in (fitted.nominal, fitted.fit))
    noise = np.sqrt(np.mean([run.noise**2 for run in runs], axis=0))
    note = (
        "Before: the robot as it was described, with its drive gains; what that does not state counts as "
        "zero. "
        "After: the same model with the values identified. Each is judged by the torque that its own drive "
        "gains make of the currents, over the noise floor."
    )
    role = "held out" if fitted.fit.validation else "used for the fit"
    remark = ", ".join([*(run.run for run in runs), role])
    picture = bars(before / noise, after / noise, fitted.fit.model.robot.joints, "residual over noise")
    return section(
        f"values{place or ''}",
        "Nominal and identified values",
        paragraph(note),
        grid(figure("Residual over noise", remark, picture)),
    )


def _runs(fit: Fit) -> tuple[Agreement, ...]:
    return fit.validation or fit.agreement


def _rms(runs: Sequence[Agreement]) -> np.ndarray:
    return np.sqrt(np.mean([run.residual_rms**2 for run in runs], axis=0))


def _diagnosed(material: Material) -> str:
    """Residuals of runs held out with and without what was found, and the same of a simulation."""
    if material.diagnosis is None:
        return ""
    parts = ""
    if gained := improvement(material.diagnosis):
        parts = section("residual", "Without and with what was found", gained)
    return parts + forward_section(material.diagnosis)
