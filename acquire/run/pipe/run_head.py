"""RunHead: what explains a run to the processes that record and show it."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from exidyn.identify.model import Model
from exidyn.identify.recordings.recording import KnownPayload
from exidyn.identify.robot_files.robot_file import model_text, parse_model

from .frames import HEAD, frame


@dataclass(frozen=True)
class RunHead:
    """The first frame of a run.

    Attributes:
        name: What people call the run.
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
