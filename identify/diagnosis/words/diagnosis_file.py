"""Content of diagnosis.json, with numbers and sentences but without samples."""

from typing import Any

from ...result_file import to_table
from ..findings.diagnosis import Diagnosis
from .naming import finding_names
from .verdict import finding_sentence, verdict

FORMAT = 2
"""Version of the format of diagnosis.json."""


def as_json(diagnosis: Diagnosis, folder: str = "") -> dict[str, Any]:
    """The content of diagnosis.json.

    The sentences are for readers of the file; exidyn itself reads only the numbers.

    Args:
        diagnosis: The diagnosis.
        folder: Folder with the models of findings and rivals; empty if they are not written.
    """
    table = to_table(diagnosis)
    rows = [*table["findings"], *table["undecided"]]
    for row, name, finding in zip(rows, finding_names(diagnosis), diagnosis.all_findings, strict=True):
        row |= {"name": name, "sentence": finding_sentence(diagnosis, finding)}
    head = {
        "exidyn_diagnosis": FORMAT,
        "unexplained": diagnosis.unexplained,
        "verdict": verdict(diagnosis, folder),
    }
    return head | table
