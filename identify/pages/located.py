"""Located: table of the quantities on which the residual of each joint depends."""

from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.findings.residuals import Located
from ..diagnosis.words.naming import effect_words
from ..document.document import Cell, Paragraph, Section, Table
from ..text_table import percent
from .shown import Shown

NOTE = (
    "Share: part of the joint's squared baseline residual in the held-out runs (without such runs: in fitted "
    "blocks that the others predict). Probability: that the torque depends on this quantity, whatever the "
    "formula. Name: the effect if one is certain, or the family of effects if several fit about equally well."
)


def located_section(shown: Shown) -> Section:
    """The section with the table; empty for a diagnosis without a budget."""
    rows: list[list[Cell]] = [
        [
            shown.names[row.joint],
            row.depends_on.replace("_", " "),
            percent(row.share),
            "" if row.probability is None else percent(row.probability, 3),
            _name(row, shown.diagnosis),
        ]
        for row in shown.diagnosis.located
    ]
    if not rows:
        return Section("located", TITLE, ())
    return Section("located", TITLE, (Paragraph(NOTE), Table(HEAD, rows, words=(1, 4))))


def _name(row: Located, diagnosis: Diagnosis) -> str:
    """The effect, its family, or "undecided"; empty if no finding explains the row."""
    if row.finding is None:
        return ""
    finding = diagnosis.all_findings[row.finding]
    if row.finding < len(diagnosis.findings):
        return effect_words(finding.effect)
    if not finding.family:
        return "undecided"
    return OPEN if finding.family == row.depends_on else f"{finding.family}, {OPEN}"


TITLE = "Residual by quantity"
OPEN = "formula open"
"""Words for a certain family whose member is not certain."""
HEAD = ["joint", "depends on", "share", "probability", "name"]
