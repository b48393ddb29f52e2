"""What `exidyn report` is given: which kind each file is, and what is read of it."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from exidyn.identify.diagnosis.words.diagnosis_file import array_of
from exidyn.identify.diagnosis.words.diagnosis_schema import DiagnosisFile
from exidyn.identify.errors import NotAFile
from exidyn.identify.fit.fit_file import read_json
from exidyn.identify.pages.diagnosis_document import Diagnosed
from exidyn.identify.pages.report_material import Compared
from exidyn.identify.recordings.importers import kind_of
from exidyn.identify.schema import checked
from exidyn.identify.simulation.comparison import Comparison, Mismatch, Regions

from .comparison_schema import BY_JOINT, ComparisonFile, MismatchTable
from .traces_file import Traces, traces_beside

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
        return [Found(_kind(path), path)]
    if not path.is_dir() or (path / "case.toml").exists() or (path / "metadata.yaml").exists():
        return [Found(RECORDING, _importable(path))]
    inside = [Found(kind, file) for file in sorted(path.glob("*.json")) if (kind := _known_kind(file))]
    inside += [Found(RECORDING, file) for file in sorted(path.glob("*.mcap"))]
    if not inside:
        raise NotAFile(f"{path} holds nothing that a report is made of. Valid: {VALID}")
    return inside


def _importable(path: Path) -> Path:
    """The path of a recording.

    Raises:
        NotAFile: It is none.
    """
    try:
        kind_of(path)
    except NotAFile as error:
        raise NotAFile(f"{path} is of no kind that a report is made of. Valid: {VALID}") from error
    return path


def _kind(path: Path) -> str:
    """Which kind of JSON file this is.

    Raises:
        NotAFile: None that is known.
    """
    if kind := _known_kind(path):
        return kind
    read_table(path)  # raises with the damaged place
    raise NotAFile(f"{path} is of no kind that a report is made of. Valid: {VALID}")


def _known_kind(path: Path) -> str:
    """The kind of a JSON file; empty for others, as folders may hold."""
    try:
        table = read_table(path)
    except NotAFile:
        return ""
    return next((kind for key, kind in KEYS.items() if key in table), "")


def read_table(path: Path) -> dict[str, Any]:
    """A JSON file.

    Raises:
        NotAFile: It is none.
    """
    table = read_json(path)
    if not isinstance(table, dict):
        raise NotAFile(f"{path} is of no kind that a report is made of. Valid: {VALID}")
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


def read_compared(path: Path) -> Compared:
    """A comparison.

    Raises:
        NotAFile: It is damaged or of a later format.
    """
    file = checked(_of_format(path, "exidyn_comparison"), ComparisonFile, str(path))
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
    table = read_table(path)
    if table.get(key) != FORMAT:
        raise NotAFile(f"{path} has format {table.get(key)}; this version reads {FORMAT}; update exidyn")
    return table


def _mismatches(table: Mapping[str, MismatchTable]) -> Iterator[Mismatch]:
    for quantity, one in table.items():
        numbers = {name: _array(getattr(one, name)) for name in BY_JOINT}
        regions = {
            kind: Regions(_array(thirds.edges), _array(thirds.rms)) for kind, thirds in one.regions.items()
        }
        yield Mismatch(quantity=quantity, units=one.units, regions=regions, **numbers)


def _array(values: Any) -> np.ndarray:
    """Numbers, which are NaN where JSON has null."""
    return np.array(values, dtype=float)
