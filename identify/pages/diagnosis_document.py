"""Content of a diagnosis page: verdict, residual by cause, parameters, findings, plots of residuals."""

import numpy as np

from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.results.budget import LEAST, NOISE, OTHER
from ..diagnosis.words.limits import warnings
from ..diagnosis.words.measures import left_out_words
from ..diagnosis.words.naming import capital, finding_names
from ..diagnosis.words.verdict import verdict
from ..document.document import Block, Cell, Document, Heading, Number, Paragraph, Section, Statements, Table
from ..document.html import html
from ..text_table import NORMAL_95, digits
from .diagnosis_plots import NOTE, every_joint, findings_blocks
from .diagnosis_table import GAIN, findings_table, gain_title
from .shown import Shown

HELD_OUT = (
    "Held-out score: how much better the model with the finding predicts the held-out runs; a positive score "
    "confirms it."
)


def diagnosis_document(shown: Shown) -> Document:
    """The document of a diagnosis."""
    diagnosis = shown.diagnosis
    facts = [
        ("Fitted", ", ".join(diagnosis.runs)),
        ("Held out", ", ".join(diagnosis.held_out) or "none"),
        ("Search time", f"{diagnosis.seconds:.1f} s, reading files not counted"),
    ]
    sections = [Section("verdict", "Verdict", verdict_blocks(shown)), *detail_sections(shown)]
    [said, _, *rest] = verdict_blocks(shown)
    brief = [said, findings_table(diagnosis, brief=True), *(b for b in rest if isinstance(b, Statements))]
    return Document(f"Diagnosis of {diagnosis.name}", "", sections, facts, brief)


def report_html(diagnosis: Diagnosis, folder: str = "") -> str:
    """The document as one self-contained HTML page; see `Shown.of` for the arguments."""
    return html(diagnosis_document(Shown.of(diagnosis, folder)))


def detail_sections(shown: Shown) -> list[Section]:
    """All sections below the verdict, the residual by cause first."""
    note = "The effects exist, but the runs do not determine their names. Plots show the fitted hypothesis."
    diagnosis, first = shown.diagnosis, len(shown.diagnosis.findings)
    return [
        budget_section(shown),
        Section("parameters", "Parameters of the findings", _parameters(shown)),
        Section("findings", "Findings", findings_blocks(shown, NOTE, diagnosis.findings, 0)),
        Section("undecided", "Undecided", findings_blocks(shown, note, diagnosis.undecided, first)),
        Section("joints", "Residual of every joint", every_joint(shown), True),
    ]


def verdict_blocks(shown: Shown) -> list[Block]:
    """Three sentences, the table of findings, and warnings."""
    diagnosis, said = shown.diagnosis, verdict(shown.diagnosis, shown.folder)
    limits = warnings(diagnosis, said)
    blocks: list[Block] = [Statements(said, "verdict"), findings_table(diagnosis)]
    blocks.append(Paragraph(GAIN.format(capital(gain_title(diagnosis)))))
    return [*blocks, Heading("Warnings"), Statements(limits)] if limits else blocks


def _parameters(shown: Shown) -> list[Block]:
    """One row per determined parameter, undecided findings last; empty without findings."""
    rows: list[list[Cell]] = []
    reasons: list[str] = []
    for name, finding in zip(shown.finding_names, shown.diagnosis.all_findings, strict=True):
        score = "" if np.isnan(finding.held_out) else f" (held-out score {digits(finding.held_out, 3)})"
        rows.append([f"{name}{score}"])
        rows += [
            [f"  {parameter}", Number(q.value), Number(NORMAL_95 * q.std, 2), "" if q.unit == "1" else q.unit]
            for parameter, q in finding.determined.items()
        ]
        reasons += [f"{name}: {words}" for words in left_out_words(finding.left_out)]
    if not rows:
        return []
    table = Table(["parameter", "value", "± 95 %", "unit"], rows, words=(3,))
    return [table, *([Statements(reasons)] if reasons else []), Paragraph(HELD_OUT)]


BUDGET, UNDECIDED = "Residual by cause", " (name undecided)"
SHARES = (
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
        return Section("budget", BUDGET, ())
    source = ", ".join(budget.held_out) or "blocks of the fitted runs that the others predict"
    note = SHARES.format(source, 100.0 * LEAST) + ("" if diagnosis.noise_measured_at_rest else CONTAINED)
    rows: list[list[Cell]] = []
    for joint, (name, unit) in enumerate(zip(shown.names, diagnosis.torque_units, strict=True)):
        before, after = (digits(rms[joint], 3) for rms in (budget.before_rms, budget.after_rms))
        rows.append([f"{name}: baseline {before} {unit}, with findings {after} {unit}"])
        shares = [(part, values[joint]) for part, values in _shares(diagnosis)]
        rows += [[f"  {part}", Number(value, 3)] for part, value in shares if value >= 100.0 * LEAST]
    table = Table(["residual", "%"], rows)
    return Section("budget", BUDGET, [table, Paragraph(note)])


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
