"""A diagnosis as one page of text: the verdict, what was found, what was gained."""

from collections.abc import Sequence

import numpy as np

from ...text_table import WIDTH, at_point, digits, paragraph, table
from ..findings.finding import Diagnosis, Finding
from ..findings.quantities import with_interval
from ..improved.forward import Forward
from .changes_words import lines as changes_lines
from .measures import by_kind, noise_measured, torque_units
from .misfit import lines as misfit_lines
from .misfit import misfit
from .moments_words import direction, size, span
from .naming import joint_words, lower, named
from .words import verdict

HELD_OUT = (
    "held out: twice the logarithm of how many times more probable the runs that were not fitted are with "
    "it; above about ten it is unlikely to be chance."
)
DIVERGED = "A simulation diverged; its numbers are missing (-, and null in diagnosis.json)."


def summary(diagnosis: Diagnosis, forward: Forward | None = None, folder: str = "") -> str:
    """One page.

    Args:
        diagnosis: What was found.
        forward: How simulations of a run compare with it; None if there are none.
        folder: Where models of findings and rivals are written; empty if they are not.
    """
    diagnosis = by_kind(diagnosis)
    title = f"What the model of {diagnosis.name} leaves out"
    parts = [[title.center(WIDTH).rstrip(), "=" * WIDTH]]
    if (found := misfit(diagnosis)) is not None:
        parts[0] += _part("Where the misfit goes", misfit_lines(found))
    bullets = [line for one in verdict(diagnosis, folder) for line in paragraph(one, "  ", "- ")]
    parts.append(_part("Verdict", bullets))
    if diagnosis.findings:
        parts.append(_part("Findings", _findings(diagnosis, diagnosis.findings)))
    if diagnosis.undecided:
        parts.append(
            _part("Undecided: there, without a certain name", _findings(diagnosis, diagnosis.undecided))
        )
    if diagnosis.moments:
        parts.append(_part("When a run differs as at no other time", _moments(diagnosis)))
    if changes := changes_lines(diagnosis):
        parts.append(_part("What each candidate alone would change", changes))
    parts.append(_part("Residual held out by joint, root mean square", _joints(diagnosis, forward)))
    parts.append(_part("Runs", _runs(diagnosis)))
    return "\n\n".join("\n".join(part) for part in parts) + "\n" + "=" * WIDTH


def _part(title: str, lines: Sequence[str]) -> list[str]:
    return [title, "-" * WIDTH, *lines]


def _findings(diagnosis: Diagnosis, shown: Sequence[Finding]) -> list[str]:
    head = ["effect", "where", "parameter", "value +- 95 %", "probability", "held out"]
    rows: list[list[str]] = []
    for finding in shown:
        rows += _rows(finding, diagnosis.joints)
    lines = table(head, rows, left=(0, 1, 2, 3))
    for finding in shown:
        what_is = lower(named(finding.effect, finding.joints, diagnosis.joints))
        for other in finding.alternatives:
            what = named(other.effect, other.joints, diagnosis.joints)
            lines += paragraph(
                f"{what}, {100 * other.probability:.2g} %", "    ", f"not excluded in place of {what_is}: "
            )
    return lines + paragraph(HELD_OUT)


def _moments(diagnosis: Diagnosis) -> list[str]:
    head = ["run", "time", "joints", "force on the flange", "direction in the base's axes"]
    rows = [
        [
            one.run,
            span(one),
            ", ".join(str(j + 1) for j in one.joints),
            size(one),
            direction(one),
        ]
        for one in diagnosis.moments
    ]
    note = "The force is the one that explains most of the difference; one joint alone shows none."
    return [*table(head, rows, left=(0, 1, 2)), *paragraph(note)]


def _rows(finding: Finding, joints: Sequence[str]) -> list[list[str]]:
    """A line a parameter; the first one has the finding's name."""
    where = ", ".join(joints[joint] for joint in finding.joints) or "arm"
    first = [finding.effect, where]
    last = [f"{100 * finding.probability:.4g} %", digits(finding.held_out)]
    rows = []
    for name, (value, std, unit) in finding.parameters.items():
        known = f"{with_interval(value, std)} {'' if unit == '1' else unit}".rstrip()
        rows.append([*first, name, known, *last])
        first, last = ["", ""], ["", ""]
    return rows


def _joints(diagnosis: Diagnosis, forward: Forward | None) -> list[str]:
    """Before and after by inverse dynamics and in simulation; over noise where that was measured."""
    found = diagnosis.improvement
    if found is None:
        return ["No run was held out."]
    units = torque_units(diagnosis)
    columns, head = [found.before, found.after], ["before", "after"]
    if noise_measured(diagnosis):
        columns = [found.noise, *columns, found.before / found.noise, found.after / found.noise]
        head = ["noise", *head, "before/ noise", "after/ noise"]
    if forward is not None:
        columns += [forward.before, forward.after]
        head += ["simulated before", "simulated after"]
    names = [joint_words(joint, diagnosis.joints) for joint in range(len(diagnosis.joints))]
    cells = [at_point([digits(value) for value in np.asarray(column)]) for column in columns]
    rows = [list(row) for row in zip(names, units, *cells, strict=True)]
    lines = table(["joint", "unit", *head], rows, left=(0, 1))
    if forward is not None and not np.all(np.isfinite([forward.before, forward.after])):
        lines += paragraph(DIVERGED)
    return lines


def _runs(diagnosis: Diagnosis) -> list[str]:
    held_out = ", ".join(diagnosis.improvement.runs) if diagnosis.improvement else "none"
    lines = paragraph(", ".join(diagnosis.runs), " " * 10, "fitted:   ")
    lines += paragraph(held_out, " " * 10, "held out: ")
    return [*lines, f"took:     {diagnosis.seconds:.1f} s"]
