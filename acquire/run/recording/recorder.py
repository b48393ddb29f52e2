"""The recorder, as the loop sees it."""

from pathlib import Path

from ..errors import RunError
from ..pipe.pipe_sink import PipeSink


def part_of(path: Path) -> Path:
    """What a recording is called until it is whole."""
    return path.with_name(path.name + ".part")


def start_recorder(path: Path, waits: bool = False) -> PipeSink:
    """Start the process that writes a run to a file; its first frame is a `RunHead`, its last an end.

    The content of the end, and what the recorder counts itself, is the recording's outcome.

    Args:
        path: Of the recording, which is called so when it is whole; an existing one is not written over.
        waits: Whether the loop may be made to wait, because nothing real moves.

    Raises:
        RunError: There is such a file already, or none can be created.
    """
    require_free(path)
    where = [str(path.absolute())]
    return PipeSink("recorder", "exidyn.acquire.run.recording.recorder_process", where, waits=waits)


def require_free(path: Path) -> None:
    """Raise where no recording can be created, as far as that can be checked without creating it.

    Raises:
        RunError: There is such a file already, or no folder for it, or it would not be known for a recording.
    """
    for existing in (path, part_of(path)):
        if existing.exists():
            raise RunError(f"{existing} exists, and recordings are not written over. {_advice(existing)}")
    if not path.parent.is_dir():
        raise RunError(f"{path}: there is no folder {path.parent}. Create it, or choose another (--output)")
    if path.suffix != ".mcap":
        raise RunError(f"{path}: recordings end in .mcap. Call it {path.stem}.mcap (--output)")


def _advice(existing: Path) -> str:
    if existing.suffix == ".part":
        return f"Rescue what an earlier run left with 'exidyn recover {existing}', or remove it"
    return "Choose another name (--output)"
