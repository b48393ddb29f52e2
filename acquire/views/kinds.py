"""Kinds: what a file is, and how it is shown."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from exidyn.identify.errors import NotAFile
from exidyn.identify.fit_file import read_fit
from exidyn.identify.importers import import_source
from exidyn.identify.model import Model
from exidyn.identify.recording import Recording

from ..traces_file import NAME, read_traces
from .diagnosis_view import diagnosis_view
from .fit_view import fit_view
from .recording_view import recording_view
from .screen import View

FORMAT = 1
"""Of diagnosis.json."""
KEYS = ("name", "joints", "verdict", "findings", "remainders")
"""What a diagnosis has at least."""


def view_of(paths: Sequence[Path], model: Model | None = None) -> View:
    """How files are shown: recordings, a fit and recordings that it predicts, or a diagnosis.

    Args:
        paths: Files or folders.
        model: The robot of tables, which do not say of which they are.

    Raises:
        NotAFile: One is nothing that can be shown, or not together with others.
        RecordingError: A recording that cannot be read.
    """
    results = [path for path in paths if path.suffix == ".json"]
    if len(results) > 1:
        raise NotAFile(f"{' and '.join(map(str, results))}: give one fit or one diagnosis at a time")
    sources = [path for path in paths if path not in results]
    recordings = _told_apart([one for path in sources for one in import_source(path, model)])
    if not results:
        return recording_view(recordings)
    table = _table(results[0])
    if "exidyn_fit" in table:
        return fit_view(read_fit(results[0]), recordings)
    if table.get("exidyn_diagnosis") != FORMAT:
        raise NotAFile(f"{results[0]} is neither a fit nor a diagnosis of format {FORMAT}; update exidyn")
    if missing := [key for key in KEYS if key not in table]:
        raise NotAFile(f"{results[0]}: key {missing[0]} is missing")
    if recordings:
        raise NotAFile(f"{results[0]} brings its runs; give {', '.join(map(str, sources))} apart from it")
    samples = results[0].with_name(NAME)
    return diagnosis_view(table, read_traces(samples) if samples.exists() else None)


def _table(path: Path) -> dict[str, Any]:
    """A JSON file.

    Raises:
        NotAFile: It is none.
    """
    try:
        table = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise NotAFile(f"{path} is not JSON, or was cut off: {error}") from error
    if not isinstance(table, dict):
        raise NotAFile(f"{path} is neither a fit nor a diagnosis")
    return table


def _told_apart(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings with names that differ, since a tab has no other."""
    names: list[str] = []
    for recording in recordings:
        number = sum(name.partition(" #")[0] == recording.name for name in names) + 1
        names.append(recording.name if number == 1 else f"{recording.name} #{number}")
    return [replace(one, name=name) for one, name in zip(recordings, names, strict=True)]
