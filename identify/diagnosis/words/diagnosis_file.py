"""Content of diagnosis.json, with numbers and sentences but without samples."""

from collections.abc import Iterable
from typing import Any

from ...result_file import to_table
from ..findings.diagnosis import Diagnosis
from .naming import finding_names
from .sentences import undecided_sentence
from .verdict import certainty, headline, sized, undecided, verdict

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
    if diagnosis.simulated is None:
        del table["simulated"]
    words = [*_words_of_findings(diagnosis, folder), *_words_of_undecided(diagnosis, folder)]
    rows = [*table["findings"], *table["undecided"]]
    for row, name, sentences in zip(rows, finding_names(diagnosis), words, strict=True):
        row |= {"name": name, **sentences}
    head = {
        "exidyn_diagnosis": FORMAT,
        "unexplained": diagnosis.unexplained,
        "verdict": verdict(diagnosis, folder),
    }
    return head | table


def _words_of_findings(diagnosis: Diagnosis, folder: str) -> Iterable[dict[str, str]]:
    for finding in diagnosis.findings:
        yield {
            "sentence": sized(diagnosis, finding),
            "headline": headline(diagnosis, finding),
            "certainty": certainty(diagnosis, finding, folder),
        }


def _words_of_undecided(diagnosis: Diagnosis, folder: str) -> Iterable[dict[str, str]]:
    for finding in diagnosis.undecided:
        yield {
            "sentence": undecided_sentence(finding, diagnosis.joints).removesuffix("."),
            "headline": undecided(diagnosis, finding, folder),
            "certainty": "",
        }
