"""Files with results: fits, diagnoses and comparisons, by what each says it is."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.findings.consistency import check_diagnosis
from exidyn.identification.diagnosis.words.diagnosis_file import FORMAT as DIAGNOSIS_FORMAT
from exidyn.identification.errors import NotAFile
from exidyn.identification.file_names import other_format
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit, read_json
from exidyn.identification.pages.compared_document import verdict
from exidyn.identification.pages.shown import Shown
from exidyn.identification.result_file import from_table, to_table
from exidyn.identification.schema import Disagreement
from exidyn.identification.simulation.comparison import Comparison

from .diagnosis_files import with_samples

FIT, DIAGNOSIS, COMPARISON = "fit", "diagnosis", "comparison"
KEYS = {"exidyn_fit": FIT, "exidyn_diagnosis": DIAGNOSIS, "exidyn_comparison": COMPARISON}
"""Key that identifies a JSON file and holds its format number -> kind."""
FORMAT = 1
"""Format number of the JSON file of a comparison."""


def _kind(path: Path) -> str:
    """The kind of a JSON file; empty for files of other programs."""
    table = _read_table(path)
    return next((kind for key, kind in KEYS.items() if key in table), "")


def _read_table(path: Path) -> dict[str, Any]:
    table = read_json(path)
    if not isinstance(table, dict):
        raise NotAFile(f"{path} is no fit, diagnosis or comparison of exidyn")
    return table


def read_shown(path: Path) -> Shown:
    """A diagnosis, and the samples beside it if there are any.

    Raises:
        NotAFile: If it is damaged, of another format, or the samples belong to another diagnosis.
    """
    return with_samples(read_diagnosis(path), path)


def read_diagnosis(path: Path) -> Diagnosis:
    """All of a diagnosis but its samples.

    Raises:
        NotAFile: If it is of another format, or a field is invalid; the message names the field.
    """
    table = _of_format(path, "exidyn_diagnosis", DIAGNOSIS_FORMAT, "diagnose RUN")
    diagnosis = from_table(table, Diagnosis, str(path))
    try:
        check_diagnosis(diagnosis)
    except Disagreement as error:
        raise NotAFile(f"{path}: {error}") from None
    return diagnosis


def read_result(path: Path) -> Fit | Diagnosis | Comparison:
    """A fit, a diagnosis or a comparison, by what the file says it is.

    Raises:
        NotAFile: It is none of them, of another format, or damaged.
    """
    readers: dict[str, Callable[[Path], Fit | Diagnosis | Comparison]] = {
        FIT: read_fit,
        DIAGNOSIS: read_diagnosis,
        COMPARISON: read_comparison,
    }
    if (kind := _kind(path)) not in readers:
        raise NotAFile(f"{path} is no fit, diagnosis or comparison of exidyn")
    return readers[kind](path)


def comparison_table(comparison: Comparison, next_commands: list[str]) -> dict[str, Any]:
    """A comparison, its verdict and the commands that follow from it, for JSON."""
    words = {"verdict": verdict(comparison), "go_on": next_commands}
    return {"exidyn_comparison": FORMAT} | to_table(comparison) | words


def read_comparison(path: Path) -> Comparison:
    """A comparison.

    Raises:
        NotAFile: If it is damaged or of another format.
    """
    table = _of_format(path, "exidyn_comparison", FORMAT, "simulate SIM --against RUN")
    return from_table(table, Comparison, str(path))


def _of_format(path: Path, key: str, valid: int, command: str) -> dict[str, Any]:
    table = _read_table(path)
    if (number := table.get(key)) != valid:
        raise NotAFile(f"{path} has {other_format(number, valid, command)}")
    return table
