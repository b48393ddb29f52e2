"""Inputs of `exidyn report`: the kind of each file, and its contents."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.findings.consistency import check_diagnosis
from exidyn.identification.diagnosis.words.diagnosis_file import FORMAT as DIAGNOSIS_FORMAT
from exidyn.identification.errors import NotAFile
from exidyn.identification.file_names import looked_in
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit, read_json
from exidyn.identification.pages.compared_document import verdict
from exidyn.identification.pages.shown import Shown
from exidyn.identification.recordings.importers import kind_of
from exidyn.identification.result_file import from_table, to_table
from exidyn.identification.schema import Disagreement
from exidyn.identification.simulation.comparison import Comparison

from .diagnosis_files import with_samples

FIT, DIAGNOSIS, COMPARISON, RECORDING = "fit", "diagnosis", "comparison", "recording"
KINDS = (FIT, DIAGNOSIS, COMPARISON, RECORDING)
KEYS = {"exidyn_fit": FIT, "exidyn_diagnosis": DIAGNOSIS, "exidyn_comparison": COMPARISON}
"""Key that identifies a JSON file and holds its format number -> kind."""
VALID = (
    "fit.json of exidyn identify, diagnosis.json of exidyn diagnose, the JSON of exidyn simulate --against, "
    "recordings (.mcap, .csv), or folders of these"
)
FORMAT = 1
"""Format number of the JSON file of a comparison."""


def find_files(paths: Sequence[Path]) -> dict[Path, str]:
    """Files and their kinds; a folder stands for all its files, and a file named twice counts once.

    Raises:
        NotAFile: If a path does not exist, or is not part of a report.
    """
    files = {file.resolve(): (file, kind) for path in paths for file, kind in _files_at(path).items()}
    return dict(files.values())


def _files_at(path: Path) -> dict[Path, str]:
    if not path.exists():
        raise NotAFile(f"{path} does not exist{looked_in(path)}")
    if path.suffix == ".json":
        if kind := _kind(path):
            return {path: kind}
        raise _unknown(path)
    if not path.is_dir() or (path / "metadata.yaml").exists():
        try:
            kind_of(path)
        except NotAFile as error:
            raise _unknown(path) from error
        return {path: RECORDING}
    files: dict[Path, str] = {}
    for file in sorted(path.glob("*.json")):
        with suppress(NotAFile):  # files of other programs
            files |= {file: kind} if (kind := _kind(file)) else {}
    files |= dict.fromkeys(sorted(path.glob("*.mcap")), RECORDING)
    if not files:
        raise NotAFile(f"{path} contains no files for a report. Valid: {VALID}")
    return files


def _unknown(path: Path) -> NotAFile:
    return NotAFile(f"{path} is not a file for a report. Valid: {VALID}")


def _kind(path: Path) -> str:
    """The kind of a JSON file; empty for files of other programs."""
    table = _read_table(path)
    return next((kind for key, kind in KEYS.items() if key in table), "")


def _read_table(path: Path) -> dict[str, Any]:
    table = read_json(path)
    if not isinstance(table, dict):
        raise _unknown(path)
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
    diagnosis = from_table(_of_format(path, "exidyn_diagnosis", DIAGNOSIS_FORMAT), Diagnosis, str(path))
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
    return from_table(_of_format(path, "exidyn_comparison"), Comparison, str(path))


def _of_format(path: Path, key: str, valid: int = FORMAT) -> dict[str, Any]:
    table = _read_table(path)
    if (number := table.get(key)) != valid:
        raise NotAFile(f"{path} has format {number}; this version reads {valid}; update exidyn")
    return table
