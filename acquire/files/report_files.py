"""What `exidyn report` is given: which kind each file is, and what is read of it."""

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
"""Key that a JSON file of each kind has, with the number of its format."""
VALID = (
    "fit.json of exidyn identify, diagnosis.json of exidyn diagnose, the JSON of exidyn compare, recordings "
    "(.mcap, .csv, case folder), or folders of these"
)
FORMAT = 1
"""Of the JSON files of a diagnosis and of a comparison."""
BY_JOINT = ("rms", "mean", "size", "noise")
"""A number a joint."""
Row = tuple[NumberOrNull, ...]


class _RegionsTable(Struct, frozen=True):
    """Mismatch in thirds of what the arm did."""

    edges: tuple[Row, ...]
    rms: tuple[Row, ...]


class _MismatchTable(Struct, frozen=True):
    """How far two recordings differ in one quantity."""

    units: tuple[str, ...]
    rms: Row
    mean: Row
    size: Row
    noise: Row
    regions: dict[str, _RegionsTable]


class _ComparisonFile(Struct, frozen=True, kw_only=True):
    """A comparison."""

    simulated: str
    recorded: str
    joints: tuple[Name, ...]
    offset: Number
    duration: Size
    filter_hz: Size
    mismatch: dict[Name, _MismatchTable]
    verdict: tuple[str, ...]

    def __post_init__(self) -> None:
        for quantity, one in self.mismatch.items():
            for name in ("units", *BY_JOINT):
                self._by_joint(getattr(one, name), f"mismatch.{quantity}.{name}")
            for kind, regions in one.regions.items():
                where = f"mismatch.{quantity}.regions.{kind}"
                for name, count in (("edges", THIRDS + 1), ("rms", THIRDS)):
                    rows = getattr(regions, name)
                    self._by_joint(rows, f"{where}.{name}")
                    check_rows(rows, f"{where}.{name}", count, f"of {THIRDS} regions")

    def _by_joint(self, values: tuple, field: str) -> None:
        check_length(values, field, len(self.joints), "one a joint")


class Found(NamedTuple):
    """A file of a known kind."""

    kind: str
    path: Path


def found_files(paths: Sequence[Path]) -> list[Found]:
    """Which kind each file is; folders give all that they hold, and what was named twice counts once.

    Raises:
        NotAFile: There is nothing, or nothing that a report is made of.
    """
    found = [one for path in paths for one in _found(path)]
    return list({one.path.resolve(): one for one in found}.values())


def _found(path: Path) -> list[Found]:
    if not path.exists():
        raise NotAFile(f"{path} does not exist")
    if path.suffix == ".json":
        if kind := _kind(path):
            return [Found(kind, path)]
        raise _unknown(path)
    if not path.is_dir() or (path / "case.toml").exists() or (path / "metadata.yaml").exists():
        try:
            kind_of(path)
        except NotAFile as error:
            raise _unknown(path) from error
        return [Found(RECORDING, path)]
    inside = []
    for file in sorted(path.glob("*.json")):
        with suppress(NotAFile):  # what is none of ours
            inside += [Found(kind, file)] if (kind := _kind(file)) else []
    inside += [Found(RECORDING, file) for file in sorted(path.glob("*.mcap"))]
    if not inside:
        raise NotAFile(f"{path} holds nothing that a report is made of. Valid: {VALID}")
    return inside


def _unknown(path: Path) -> NotAFile:
    return NotAFile(f"{path} is of no kind that a report is made of. Valid: {VALID}")


def _kind(path: Path) -> str:
    """The kind of a JSON file; empty for those of other programs, as folders may hold."""
    table = _read_table(path)
    return next((kind for key, kind in KEYS.items() if key in table), "")


def _read_table(path: Path) -> dict[str, Any]:
    table = read_json(path)
    if not isinstance(table, dict):
        raise _unknown(path)
    return table


def read_diagnosed(path: Path) -> tuple[Diagnosed, Traces | None]:
    """A diagnosis, and the samples beside it if there are any.

    Raises:
        NotAFile: It is damaged, of a later format, or the samples are those of another.
    """
    file = read_diagnosis(path)
    traces = traces_beside(path, file)
    if traces is None:
        return Diagnosed(file, array_of(file.noise)), None
    return Diagnosed(file, traces.noise, traces.traces, traces.simulated), traces


def read_diagnosis(path: Path) -> DiagnosisFile:
    """All of a diagnosis but its samples.

    Raises:
        NotAFile: It is of a later format, or a field cannot be; it is named.
    """
    return checked(_of_format(path, "exidyn_diagnosis"), DiagnosisFile, str(path))


def comparison_table(comparison: Comparison, go_on: list[str]) -> dict[str, Any]:
    """A comparison and commands that go on from it, for JSON; what is no number is null."""
    return {
        "exidyn_comparison": FORMAT,
        "simulated": comparison.simulated,
        "recorded": comparison.recorded,
        "joints": list(comparison.joints),
        "offset": comparison.offset,
        "duration": comparison.duration,
        "filter_hz": comparison.cutoff,
        "mismatch": {one.quantity: _numbers(one) for one in comparison.mismatches},
        "verdict": verdict(comparison),
        "go_on": go_on,
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
        NotAFile: It is damaged or of a later format.
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
    for quantity, one in table.items():
        numbers = {name: _array(getattr(one, name)) for name in BY_JOINT}
        regions = {
            kind: Regions(_array(thirds.edges), _array(thirds.rms)) for kind, thirds in one.regions.items()
        }
        yield Mismatch(quantity=quantity, units=one.units, regions=regions, **numbers)


def _array(values: Any) -> np.ndarray:
    """Numbers, which are NaN where JSON has null."""
    return np.array(values, dtype=float)
