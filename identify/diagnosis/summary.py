"""A diagnosis as one page of text: the verdict, what was found, what was gained."""

from collections.abc import Sequence

import numpy as np

from ..text_table import WIDTH, at_point, digits, paragraph, table
from .finding import Diagnosis, Finding
from .forward import Forward
from .quantities import with_interval
from .sentences import joint_words
from .words import named, verdict


def summary(diagnosis: Diagnosis, forward: Forward | None = None, folder: str = "") -> str:
    """One page.

    Args:
        diagnosis: What was found.
        forward: How simulations of a run compare with it; None if there are none.
        folder: Where models of findings and rivals are written; empty if they are not.
    """
    title = f"What the model of {diagnosis.name} leaves out"
    bullets = [line for said in verdict(diagnosis, folder) for line in paragraph(said, "  ", "- ")]
    parts = [[title.center(WIDTH).rstrip(), "=" * WIDTH, *bullets]]
    if diagnosis.findings:
        parts.append(_part("Findings", _findings(diagnosis)))
    parts.append(_part("Residual by joint, root mean square", _joints(diagnosis, forward)))
    parts.append(_part("Runs", _runs(diagnosis)))
    return "\n\n".join("\n".join(part) for part in parts) + "\n" + "=" * WIDTH


def _part(title: str, lines: Sequence[str]) -> list[str]:
    return [title, "-" * WIDTH, *lines]


def _findings(diagnosis: Diagnosis) -> list[str]:
    head = ["effect", "where", "parameter", "value +- 95 %", "unit", "probability", "held out"]
    rows: list[list[str]] = []
    for finding in diagnosis.findings:
        rows += _rows(finding, diagnosis.joints)
    lines = table(head, rows, left=(0, 1, 2, 3, 4))
    for finding in diagnosis.findings:
        for other in finding.alternatives:
            what = named(other.effect, other.joints, diagnosis.joints)
            lines += paragraph(f"{what}, {100 * other.probability:.2g} %", "    ", "not excluded: ")
    return lines + paragraph(
        "held out: by how much the sum of squares of white residuals falls on runs that were not fitted; "
        "from about ten on it is no chance."
    )


def _rows(finding: Finding, joints: Sequence[str]) -> list[list[str]]:
    """A line a parameter; the first one has the finding's name."""
    where = ", ".join(joints[joint] for joint in finding.joints) or "arm"
    first = [finding.effect, where]
    last = [f"{100 * finding.probability:.4g} %", digits(finding.held_out)]
    rows = []
    for name, (value, std, unit) in finding.parameters.items():
        rows.append([*first, name, with_interval(value, std), "" if unit == "1" else unit, *last])
        first, last = ["", ""], ["", ""]
    return rows


def _joints(diagnosis: Diagnosis, forward: Forward | None) -> list[str]:
    """Before and after over the noise floor, by inverse dynamics and in simulation."""
    found = diagnosis.improvement
    if found is None:
        return ["No run was held out."]
    columns = [found.noise, found.before, found.after, found.before / found.noise, found.after / found.noise]
    head = ["joint", "noise N m", "before", "after", "before/noise", "after/noise"]
    if forward is not None:
        columns += [forward.before, forward.after]
        head += ["simulated before", "simulated after"]
    names = [joint_words(joint, diagnosis.joints) for joint in range(len(diagnosis.joints))]
    cells = [at_point([digits(value) for value in np.asarray(column)]) for column in columns]
    return table(head, [list(row) for row in zip(names, *cells, strict=True)])


def _runs(diagnosis: Diagnosis) -> list[str]:
    held_out = ", ".join(diagnosis.improvement.runs) if diagnosis.improvement else "none"
    lines = paragraph(", ".join(diagnosis.runs), " " * 10, "fitted:   ")
    lines += paragraph(held_out, " " * 10, "held out: ")
    return [*lines, f"{diagnosis.seconds:.1f} s"]
