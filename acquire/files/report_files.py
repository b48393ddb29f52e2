"""Inputs of `exidyn report`: the kind of each file, and its contents."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct

from exidyn.identification.diagnosis.words.diagnosis_file import array_of
from exidyn.identification.diagnosis.words.diagnosis_schema import DiagnosisFile
from exidyn.identification.errors import NotAFile
from exidyn.identification.fit.fit_file import read_json
from exidyn.identification.pages.compared_document import verdict
from exidyn.identification.pages.diagnosis_document import Diagnosed
from exidyn.identification.pages.report_material import Compared
from exidyn.identification.recordings.importers import kind_of
from exidyn.identification.schema import Name, Number, NumberOrNull, Size, check_length, check_rows, checked
from exidyn.identification.simulation.comparison import THIRDS, Comparison, Mismatch, Regions

from .diagnosis_files import Traces, traces_beside

FIT, DIAGNOSIS, COMPARISON, RECORDING = "fit", "diagnosis", "comparison", "recording"
KINDS = (FIT, DIAGNOSIS, COMPARISON, RECORDING)
KEYS = {"exidyn_fit": FIT, "exidyn_diagnosis": DIAGNOSIS, "exidyn_comparison": COMPARISON}
"""Key that identifies a JSON file and holds its format number -> kind."""
VALID = (
    "fit.json of exidyn identify, diagnosis.json of exidyn diagnose, the JSON of exidyn compare, recordings "
    "(.mcap, .csv, case folder), or folders of these"
)
FORMAT = 1
"""Format number of the JSON files of a diagnosis and of a comparison."""
BY_JOINT = ("rms", "mean", "size", "noise")
"""Fields with one number per joint."""
Row = tuple[NumberOrNull, ...]


class _RegionsTable(Struct, frozen=True):
    """Mismatch in thirds of the range of a quantity."""

    edges: tuple[Row, ...]
    rms: tuple[Row, ...]


class _MismatchTable(Struct, frozen=True):
    """Mismatch of two recordings in one quantity."""

    units: tuple[str, ...]
    rms: Row
    mean: Row
    size: Row
    noise: Row
    regions: dict[str, _RegionsTable]


class _ComparisonFile(Struct, frozen=True, kw_only=True):
    """The JSON file of a comparison."""

    simulated: str
    recorded: str
    joints: tuple[Name, ...]
    offset: Number
    duration: Size
    filter_hz: Size
    mismatch: dict[Name, _MismatchTable]
    verdict: tuple[str, ...]

    def __post_init__(self) -> None:
        for quantity, mismatch in self.mismatch.items():
            for name in ("units", *BY_JOINT):
                self._check_joints(getattr(mismatch, name), f"mismatch.{quantity}.{name}")
            for kind, regions in mismatch.regions.items():
                where = f"mismatch.{quantity}.regions.{kind}"
                for name, count in (("edges", THIRDS + 1), ("rms", THIRDS)):
                    rows = getattr(regions, name)
                    self._check_joints(rows, f"{where}.{name}")
                    check_rows(rows, f"{where}.{name}", count, f"of {THIRDS} regions")

    def _check_joints(self, values: tuple, field: str) -> None:
        check_length(values, field, len(self.joints), "one a joint")


class ReportFile(NamedTuple):
    """A file of a known kind."""

    kind: str
    path: Path


def find_files(paths: Sequence[Path]) -> list[ReportFile]:
    """Files with their kinds; a folder stands for all its files, and a file named twice counts once.

    Raises:
        NotAFile: If a path does not exist, or is not part of a report.
    """
    files = [file for path in paths for file in _files_at(path)]
    return list({file.path.resolve(): file for file in files}.values())


def _files_at(path: Path) -> list[ReportFile]:
    if not path.exists():
        raise NotAFile(f"{path} does not exist")
    if path.suffix == ".json":
        if kind := _kind(path):
            return [ReportFile(kind, path)]
        raise _unknown(path)
    if not path.is_dir() or (path / "case.toml").exists() or (path / "metadata.yaml").exists():
        try:
            kind_of(path)
        except NotAFile as error:
            raise _unknown(path) from error
        return [ReportFile(RECORDING, path)]
    files = []
    for file in sorted(path.glob("*.json")):
        with suppress(NotAFile):  # files of other programs
            files += [ReportFile(kind, file)] if (kind := _kind(file)) else []
    files += [ReportFile(RECORDING, file) for file in sorted(path.glob("*.mcap"))]
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


def read_diagnosed(path: Path) -> tuple[Diagnosed, Traces | None]:
    """A diagnosis, and the samples beside it; None without samples.

    Raises:
        NotAFile: If it is damaged, of a later format, or the samples belong to another diagnosis.
    """
    file = read_diagnosis(path)
    traces = traces_beside(path, file)
    if traces is None:
        return Diagnosed(file, array_of(file.noise)), None
    return Diagnosed(file, traces.noise, traces.traces, traces.simulated), traces


def read_diagnosis(path: Path) -> DiagnosisFile:
    """A diagnosis without its samples.

    Raises:
        NotAFile: If it is of a later format, or a field is invalid; the message names the field.
    """
    return checked(_of_format(path, "exidyn_diagnosis"), DiagnosisFile, str(path))


def comparison_table(comparison: Comparison, next_commands: list[str]) -> dict[str, Any]:
    """A comparison and the next commands, for JSON; NaN and infinity become null."""
    return {
        "exidyn_comparison": FORMAT,
        "simulated": comparison.simulated,
        "recorded": comparison.recorded,
        "joints": list(comparison.joints),
        "offset": comparison.offset,
        "duration": comparison.duration,
        "filter_hz": comparison.cutoff,
        "mismatch": {mismatch.quantity: _numbers(mismatch) for mismatch in comparison.mismatches},
        "verdict": verdict(comparison),
        "go_on": next_commands,
    }


def _numbers(mismatch: Mismatch) -> dict[str, Any]:
    return {
        "units": list(mismatch.units),
        **{name: getattr(mismatch, name) for name in BY_JOINT},
        "regions": {kind: regions._asdict() for kind, regions in mismatch.regions.items()},
    }


def read_compared(path: Path) -> Compared:
    """A comparison.

    Raises:
        NotAFile: If it is damaged or of a later format.
    """
    file = checked(_of_format(path, "exidyn_comparison"), _ComparisonFile, str(path))
    comparison = Comparison(
        simulated=file.simulated,
        recorded=file.recorded,
        joints=file.joints,
        offset=file.offset,
        duration=file.duration,
        cutoff=file.filter_hz,
        mismatches=tuple(_mismatches(file.mismatch)),
    )
    return Compared(comparison, file.verdict)


def _of_format(path: Path, key: str) -> dict[str, Any]:
    table = _read_table(path)
    if table.get(key) != FORMAT:
        raise NotAFile(f"{path} has format {table.get(key)}; this version reads {FORMAT}; update exidyn")
    return table


def _mismatches(table: Mapping[str, _MismatchTable]) -> Iterator[Mismatch]:
    for quantity, row in table.items():
        numbers = {name: _array(getattr(row, name)) for name in BY_JOINT}
        regions = {
            kind: Regions(_array(thirds.edges), _array(thirds.rms)) for kind, thirds in row.regions.items()
        }
        yield Mismatch(quantity=quantity, units=row.units, regions=regions, **numbers)


def _array(values: Any) -> np.ndarray:
    """Numbers as an array, with NaN for null."""
    return np.array(values, dtype=float)
