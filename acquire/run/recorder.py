"""The recorder, as the loop sees it: its start, and the head that explains a run to it and to views."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.robot_files.robot_file import model_text, parse_model

from .errors import RunError
from .frames import HEAD, frame
from .pipe import PipeSink

NOT_OVER = "recordings are not written over"


def part_of(path: Path) -> Path:
    """What a recording is called until it is whole."""
    return path.with_name(path.name + ".part")


def start_recorder(path: Path, waits: bool = False) -> PipeSink:
    """Start the process that writes a run to a file; its first frame is a `RunHead`, its last an end.

    The content of the end, and what the recorder counts itself, is the recording's outcome.

    Args:
        path: Name of the recording once it is whole; an existing one is not written over.
        waits: Whether the loop may be made to wait, because nothing real moves.

    Raises:
        RunError: There is such a file already, or none can be created.
    """
    require_free(path)
    where = [str(path.absolute())]
    return PipeSink("recorder", "exidyn.acquire.run.recorder_process", where, waits=waits)


def require_free(path: Path) -> None:
    """Raise where no recording can be created, as far as that can be checked without creating it.

    Raises:
        RunError: There is such a file already, or no folder for it, or it would not be known for a recording.
    """
    part = part_of(path)
    if path.exists():
        raise RunError(f"{path} exists, and {NOT_OVER}. Choose another name (--output)")
    if part.exists():
        rescue = f"Rescue what an earlier run left with 'exidyn recover {part}', or remove it"
        raise RunError(f"{part} exists, and {NOT_OVER}. {rescue}")
    if not path.parent.is_dir():
        raise RunError(f"{path}: there is no folder {path.parent}. Create it, or choose another (--output)")
    if path.suffix != ".mcap":
        raise RunError(f"{path}: recordings end in .mcap. Call it {path.stem}.mcap (--output)")


@dataclass(frozen=True)
class RunHead:
    """The first frame of a run.

    Attributes:
        name: What people call it.
        model: The nominal robot, with its effects.
        signals: What the controller measures: of position, velocity, current, torque, temperature.
        epoch: Host's clock at the first sample, where the recording's time begins [ns since 1970].
        zero: Controller's clock there [ns from its own zero].
        trajectory: Text of the trajectory's file.
        payload: What hangs on the flange.
        settings: Driver, scales, limits and whatever else explains the run.
        warnings: Warnings that are known already.
        state: What cycles hold of the controller's own state, and what its codes mean, as in `Info`.
    """

    name: str
    model: Model
    signals: tuple[str, ...]
    epoch: int = 0
    zero: int = 0
    trajectory: str = ""
    payload: KnownPayload | None = None
    settings: Mapping[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    state: Mapping[str, Mapping[int, str]] = field(default_factory=dict)

    def frame(self) -> bytes:
        """To hand over."""
        return self.written()(self.epoch, self.zero)

    def written(self) -> Callable[[int, int], bytes]:
        """The frame, ready but for epoch and zero: writing the rest takes as long as a controller's cycle."""
        payload = {"name": self.payload.name, "known": self.payload.known} if self.payload else None
        content = {
            "name": self.name,
            "model": model_text(self.model),
            "signals": self.signals,
            "trajectory": self.trajectory,
            "payload": payload,
            "settings": dict(self.settings),
            "warnings": self.warnings,
            "state": {name: dict(words) for name, words in self.state.items()},
        }
        rest = json.dumps(content, default=str).encode()[:-1]

        def begun(epoch: int, zero: int) -> bytes:
            return frame(HEAD, b'%b, "epoch_ns": %d, "zero_ns": %d}' % (rest, epoch, zero))

        return begun

    @classmethod
    def read(cls, body: bytes) -> "RunHead":
        """From the body of its frame.

        Raises:
            ValueError: It is not one.
        """
        content = json.loads(body)
        payload = content["payload"]
        known = tuple((name, value) for name, value in payload["known"]) if payload else ()
        return cls(
            name=content["name"],
            model=parse_model(content["model"]),
            signals=tuple(content["signals"]),
            epoch=content["epoch_ns"],
            zero=content["zero_ns"],
            trajectory=content["trajectory"],
            payload=KnownPayload(payload["name"], known) if payload else None,
            settings=content["settings"],
            warnings=tuple(content["warnings"]),
            state={
                name: {int(code): word for code, word in words.items()}
                for name, words in content["state"].items()
            },
        )
