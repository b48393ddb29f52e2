"""Kinds of files, and the view of each kind."""

from collections.abc import Sequence
from pathlib import Path

from exidyn.identification.errors import NotAFile
from exidyn.identification.fit.fit_file import read_fit, read_json
from exidyn.identification.model import Model
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.simulation.predicted import predicted

from ..files.given_runs import renamed
from ..files.result_files import read_shown
from .diagnosis_view import diagnosis_view
from .fit_view import fit_view
from .recording_view import recording_view
from .viewers import View


def view_of(paths: Sequence[Path], model: Model | None = None) -> View:
    """The view of files: recordings, a fit and recordings that it predicts, or a diagnosis.

    Args:
        paths: Files or folders.
        model: Robot of tables, which do not name their robot.

    Raises:
        NotAFile: If a file cannot be shown, or not together with the others.
        RecordingError: If a recording cannot be read or is too short for the filters of the fit.
        DifferentRobot: If a recording has other joints than the fit.
    """
    results = [path for path in paths if path.suffix == ".json"]
    if len(results) > 1:
        raise NotAFile(f"{' and '.join(map(str, results))}: give one fit or one diagnosis at a time")
    sources = [path for path in paths if path not in results]
    recordings = renamed(recording for path in sources for recording in import_source(path, model))
    if not results:
        return recording_view(recordings)
    table = read_json(results[0])
    if not isinstance(table, dict):
        raise NotAFile(f"{results[0]} is neither a fit nor a diagnosis")
    if "exidyn_fit" in table:
        return fit_view(predicted(read_fit(results[0]), recordings))
    if "exidyn_diagnosis" not in table:
        raise NotAFile(f"{results[0]} is neither a fit nor a diagnosis")
    if recordings:
        raise NotAFile(f"{results[0]} contains its runs; view {', '.join(map(str, sources))} separately")
    shown = read_shown(results[0])
    return diagnosis_view(shown._replace(traces=tuple(renamed(shown.traces))))
