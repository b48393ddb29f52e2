"""The recorder, as seen by the loop: its start, and the head frame that describes a run."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_type_hints

import msgspec

from exidyn.identification.recordings.mcap.mcap_writer import Head
from exidyn.identification.robot_files.robot_file import model_text, parse_model

from .errors import RunError
from .frames import HEAD, frame
from .pipe import PipeSink

NOT_OVERWRITTEN = "recordings are not overwritten"


def part_of(path: Path) -> Path:
    """Path of a recording until it is complete."""
    return path.with_name(path.name + ".part")


def start_recorder(path: Path, waits: bool = False) -> PipeSink:
    """Start the process that writes a run to a file, from the frame of its `RunHead` to its end frame.

    The outcome in the recording is the content of the end frame and the recorder's own counts. The loop
    `waits` for a slow recorder only if no real arm moves.

    Raises:
        RunError: If the file exists or cannot be created.
    """
    require_free(path)
    where = [str(path.absolute())]
    return PipeSink("recorder", "exidyn.acquire.run.recorder_process", where, waits=waits)


def require_free(path: Path) -> None:
    """Check, without creating the file, that a recording can be created.

    Raises:
        RunError: If the file exists, its folder does not exist, or its suffix is not .mcap.
    """
    part = part_of(path)
    if path.exists():
        raise RunError(f"{path} exists, and {NOT_OVERWRITTEN}. Choose another name (--output)")
    if part.exists():
        rescue = f"Recover the data of an earlier run with 'exidyn info --repair {part}', or remove it"
        raise RunError(f"{part} exists, and {NOT_OVERWRITTEN}. {rescue}")
    if not path.parent.is_dir():
        raise RunError(f"{path}: there is no folder {path.parent}. Create it, or choose another (--output)")
    if path.suffix != ".mcap":
        raise RunError(f"{path}: names of recordings end in .mcap. Use {path.stem}.mcap (--output)")


@dataclass(frozen=True)
class RunHead(Head):
    """The first frame of a run: the head of its recording, and how to read its samples."""

    host_clock: bool = True
    # Measured signals: some of position, velocity, current, torque and temperature.
    signals: tuple[str, ...] = ()
    zero: int = 0  # controller's clock at the first sample [ns from its own zero]
    # Names of the controller's own state in each cycle, and the meaning of its codes, as in `Info`.
    state: Mapping[str, Mapping[int, str]] = field(default_factory=dict)

    def frame(self) -> bytes:
        """The head as a frame."""
        return self.prepare_frame()(self.epoch, self.zero)

    def prepare_frame(self) -> Callable[[int, int], bytes]:
        """Function that makes the frame from epoch and zero; the rest takes a cycle to serialize."""
        content = {**vars(self), "model": model_text(self.model)}
        del content["epoch"], content["zero"]
        prefix = msgspec.json.encode(content, enc_hook=_plain)[:-1]

        def complete(epoch: int, zero: int) -> bytes:
            return frame(HEAD, b'%b,"epoch":%d,"zero":%d}' % (prefix, epoch, zero))

        return complete

    @classmethod
    def read(cls, body: bytes) -> "RunHead":
        """Read a head from the body of its frame.

        Raises:
            ValueError: If the body is not that of a head.
        """
        content, kinds = msgspec.json.decode(body, type=dict[str, Any]), get_type_hints(cls)
        model = parse_model(content.pop("model"))
        values = {name: msgspec.convert(value, kinds[name], strict=False) for name, value in content.items()}
        return cls(model=model, **values)


def _plain(value: Any) -> Any:
    """A mapping of any type, numbers of numpy, or the text of anything else a driver has, for JSON."""
    return dict(value) if isinstance(value, Mapping) else getattr(value, "tolist", lambda: str(value))()
