"""Located: the table of what the misfit of every joint depends on."""

from ..diagnosis.findings.located import Located
from ..diagnosis.words.diagnosis_schema import DiagnosisFile
from ..diagnosis.words.naming import effect_words
from ..document.document import Cell, Paragraph, Section, Table
from ..text_table import percent
from .diagnosed import Diagnosed

NOTE = (
    "What the misfit of each joint depends on, with its share of the squared misfit in the runs held out "
    "(without such runs: in fitted blocks that the others predict). Probability: that the torque depends on "
    "this quantity, whatever the formula. Name: the formula, where one is certain; the family, where several "
    "fit about equally well."
)


def located_section(diagnosis: Diagnosed) -> Section:
    """The table; empty for a diagnosis without a budget, and for one of an older version."""
    file = diagnosis.file
    rows: list[list[Cell]] = [
        [
            diagnosis.names[row.joint - 1],
            row.depends_on.replace("_", " "),
            percent(row.share),
            "" if row.probability is None else percent(row.probability, 3),
            _name(row, file),
        ]
        for row in file.located
    ]
    if not rows:
        return Section("located", TITLE, ())
    return Section("located", TITLE, (Paragraph(NOTE), Table(HEAD, rows, words=(1, 4))))


def _name(row: Located, file: DiagnosisFile) -> str:
    """The effect that is named, the family, or that it is undecided; nothing for what no finding explains."""
    if row.finding is None:
        return ""
    finding = file.every[row.finding]
    if row.finding < len(file.findings):
        return effect_words(finding.effect)
    if not finding.family:
        return "undecided"
    return OPEN if finding.family == row.depends_on else f"{finding.family}, {OPEN}"


TITLE = "Where the misfit is"
OPEN = "formula open"
"""Of a family that is certain, when its member is not."""
HEAD = ["joint", "depends on", "share", "probability", "name"]
