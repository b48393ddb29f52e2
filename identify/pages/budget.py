"""Residual by cause: shares of each joint's squared residual, from the budget of a diagnosis."""

import numpy as np

from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.results.budget import LEAST, NOISE, OTHER
from ..diagnosis.words.naming import finding_names
from ..document.document import Cell, Number, Paragraph, Section, Table
from ..text_table import digits
from .shown import Shown

UNDECIDED = " (name undecided)"
NOTE = (
    "Percentages of the squared baseline residual of each joint in {}, from {:g} % on; root mean squares of "
    "the residual. The baseline has no findings; its parameters and drive gains are fitted within their "
    "tolerances."
)
UNRECORDED = "depends on no recorded quantity"
CONTAINED = f' Sensor noise was not measured at rest: it is part of "{UNRECORDED}".'


def budget_section(shown: Shown) -> Section:
    """Empty for a diagnosis without a budget."""
    diagnosis = shown.diagnosis
    if (budget := diagnosis.budget) is None:
        return Section("budget", "Residual by cause", ())
    source = ", ".join(budget.held_out) or "blocks of the fitted runs that the others predict"
    note = NOTE.format(source, 100.0 * LEAST) + ("" if diagnosis.noise_measured_at_rest else CONTAINED)
    rows: list[list[Cell]] = []
    for joint, (name, unit) in enumerate(zip(shown.names, diagnosis.torque_units, strict=True)):
        before, after = (digits(rms[joint], 3) for rms in (budget.before_rms, budget.after_rms))
        rows.append([f"{name}: baseline {before} {unit}, with findings {after} {unit}"])
        shares = [(part, values[joint]) for part, values in _shares(diagnosis)]
        rows += [[f"  {part}", Number(value, 3)] for part, value in shares if value >= 100.0 * LEAST]
    table = Table(["residual", "%"], rows)
    return Section("budget", "Residual by cause", [table, Paragraph(note)])


def _shares(diagnosis: Diagnosis) -> list[tuple[str, np.ndarray]]:
    """Names of all parts of the residual, and their percentages of each joint, shape (n,)."""
    assert diagnosis.budget is not None
    names, decided, parts = finding_names(diagnosis), len(diagnosis.findings), []
    for share in diagnosis.budget.shares:
        name = {NOISE: NOISE, OTHER: UNRECORDED}.get(share.kind, f"depends on {share.kind}")
        if share.finding is not None:
            name = names[share.finding] + (UNDECIDED if share.finding >= decided else "")
        parts.append((name, share.percent))
    return parts
