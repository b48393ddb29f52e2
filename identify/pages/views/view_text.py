"""A fit in Markdown, for viewers that show it."""

import numpy as np

from ...fit.fit import Fit
from ...fit.warnings.verdict import NORMAL_95, gains_estimated, verdict
from ..report_html import rounded


def verdict_markdown(fit: Fit) -> str:
    """The verdict as a list."""
    return "\n".join(["## Verdict", *(f"- {line}" for line in verdict(fit))])


def parameters_markdown(fit: Fit) -> str:
    """Gains and parameters as Markdown tables."""
    estimate, (nominal, deviation) = fit.estimate, fit.prior
    lines = ["## Drive gains", "| joint | gain | \u00b1 95 % | nominal |", "|---|---|---|---|"]
    for k, (joint, stated) in enumerate(zip(fit.model.robot.joints, fit.model.robot.drive_gain, strict=True)):
        half = rounded(NORMAL_95 * estimate.gain_std[k], 2) if gains_estimated(fit) else "as stated"
        gain = "not stated" if fit.gains_unstated else rounded(stated)
        half = "unknown" if fit.unscaled else half
        lines.append(f"| {joint} | {rounded(estimate.gain[k], 5)} | {half} | {gain} |")
    lines += [
        "## Parameters",
        "| | parameter | value | \u00b1 95 % | "
        + (f"unit per {', '.join(dict.fromkeys(fit.model.robot.units('N m/A')))}" if fit.unscaled else "unit")
        + " | nominal |",
        "|---|---|---|---|---|---|",
    ]
    for k, (name, unit) in enumerate(zip(fit.names, fit.base.units, strict=True)):
        prior = (
            f"{rounded(nominal[k])} \u00b1 {rounded(deviation[k], 2)}"
            if np.isfinite(deviation[k]) and not fit.unscaled
            else ""
        )
        value, half = rounded(estimate.values[k], 5), rounded(NORMAL_95 * estimate.std[k], 2)
        lines.append(f"| {k} | {name} | {value} | {half} | {unit} | {prior} |")
    return "\n".join(lines)
