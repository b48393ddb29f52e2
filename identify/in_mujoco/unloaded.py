"""Runs that are simulated: those of the arm alone, since its file has no payload."""

from collections.abc import Sequence

from ..diagnosis.runs.usable import HELD_OUT
from ..errors import RecordingError
from ..preparation.prepare import Filtering
from ..recordings.recording import Recording
from .replay import Run


def require_unloaded(recordings: Sequence[tuple[str, Recording]]) -> None:
    """Check that runs can be simulated: some that are fitted, and some that judge.

    Args:
        recordings: Role and recording of each run.

    Raises:
        RecordingError: If no run without a payload is held out, or none is fitted.
    """
    if not any(role == HELD_OUT for role, _ in recordings):
        raise RecordingError(
            "no run is held out to decide which findings help: add one that is not fitted, --validate RUN"
        )
    for held_out, words in ((True, "held-out"), (False, "fitted")):
        if not _unloaded(recordings, held_out):
            raise RecordingError(
                f"every {words} run carries a payload, which the file does not have: add a {words} run "
                "without a payload"
            )


def simulated_runs(
    recordings: Sequence[tuple[str, Recording]], filtering: Filtering, held_out: bool
) -> tuple[Run, ...]:
    """Held-out or fitted runs without a payload, prepared for replay."""
    return tuple(Run.of(run, filtering) for run in _unloaded(recordings, held_out))


def _unloaded(recordings: Sequence[tuple[str, Recording]], held_out: bool) -> list[Recording]:
    return [run for role, run in recordings if (role == HELD_OUT) == held_out and run.payload is None]
