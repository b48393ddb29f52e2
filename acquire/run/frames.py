"""Frames: messages from the loop, through a pipe, to the processes that write and show a run.

A frame has a kind, a length and a body: samples are binary, everything else is JSON. A pipe keeps its content
when the writer dies, and a frame is smaller than what a pipe takes at once, so no frame is ever torn.

For external torques of an arm that is watched, a sample has time, torque, threshold and position of each
joint, and force; contacts are events whose controller_time is the time of the sample [ns].
"""

import json
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import msgspec
import numpy as np

from exidyn.drivers import Command, Sample
from exidyn.drivers.values import SIGNALS
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import model_text, parse_model

HEAD, SAMPLE, EVENT, END = b"H", b"S", b"E", b"Z"
"""Kinds of frames: head (once, first), sample (every cycle), event, end (once, last)."""
KINDS = (HEAD, SAMPLE, EVENT, END)
MAX_LENGTH = 64 << 20
"""Upper limit of a frame [bytes]: a head with the largest robot and plan has a hundredth of this."""
_FRAME = struct.Struct("<cI")
_FIXED = struct.Struct("<qqdIII")
ARRAYS = (*SIGNALS, "command_position", "command_velocity")
"""Arrays of a sample frame, each (n,) in the units of `Sample` and `Command`."""


@dataclass(frozen=True, slots=True)
class Cycle:
    """One control cycle."""

    host_time: int  # host's clock [ns since 1970]
    controller_time: int  # controller's clock [ns from its own zero]
    lateness: float  # lateness of the exchange [s]
    skipped: int  # cycles without an exchange before this one
    stage: int  # index in `STAGES`
    arrays: np.ndarray  # rows as in `ARRAYS`, shape (7, n); NaN for a command that was not sent
    # Controller-specific state, shape (k,), as in `Sample`.
    state: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def array(self, name: str) -> np.ndarray:
        """The row of `arrays` with a name in `ARRAYS`, shape (n,)."""
        return self.arrays[ARRAYS.index(name)]


STAGES = ("listening", "approaching", "running", "braking", "holding")
"""Stages of a run, in their usual order."""


@dataclass(frozen=True, slots=True)
class Event:
    """An event of a run."""

    host_time: int  # host's clock [ns since 1970]
    controller_time: int  # controller's clock [ns from its own zero]
    kind: str  # kind of event: "driver", "stage", "stop", "late", "warning"
    text: str  # description in a sentence
    details: Mapping[str, Any]  # joint, value, limit, unit and level of a stop, if known


def sample_frame(sample: Sample, command: Command | None, stage: int) -> bytes:
    """Frame of a cycle: the sample and the command sent in it."""
    nothing = np.full(len(sample.position), np.nan)
    sent = (command.position, command.velocity) if command is not None else (nothing, nothing)
    times, state = (sample.host_time, sample.controller_time, sample.lateness), sample.state
    body = _FIXED.pack(*times, sample.skipped, stage, len(state))
    arrays = (state, *(getattr(sample, name) for name in SIGNALS), *sent)
    return frame(SAMPLE, body + np.concatenate(arrays).astype("<f8", copy=False).tobytes())


def text_frame(kind: bytes, content: Mapping[str, Any]) -> bytes:
    """Frame of a head, an event or an end."""
    return frame(kind, json.dumps(content, default=str).encode())


def frame(kind: bytes, body: bytes) -> bytes:
    """Frame of any kind, from its serialized body."""
    return _FRAME.pack(kind, len(body)) + body


def event_frame(event: Event) -> bytes:
    """Frame of an event."""
    return text_frame(EVENT, {name: getattr(event, name) for name in Event.__slots__})


def read_cycle(body: bytes) -> Cycle:
    """Read the cycle of a sample frame."""
    host_time, controller_time, lateness, skipped, stage, states = _FIXED.unpack_from(body)
    numbers = np.frombuffer(body, "<f8", offset=_FIXED.size)
    arrays = numbers[states:].reshape(len(ARRAYS), -1)
    return Cycle(host_time, controller_time, lateness, skipped, stage, arrays, numbers[:states])


def read_event(body: bytes) -> Event:
    """Read the event of an event frame."""
    return msgspec.convert(json.loads(body), Event)


class Unframed:
    """Splits a stream of bytes, received in arbitrary pieces, into frames."""

    def __init__(self) -> None:
        self._waiting = bytearray()

    def add(self, data: bytes) -> Iterator[tuple[bytes, bytes]]:
        """Add received bytes; yield kind and body of each frame that is complete by now.

        Raises:
            ValueError: If the bytes cannot be frames, so that the start of the next frame is unknown.
        """
        self._waiting += data
        start = 0
        while start + _FRAME.size <= len(self._waiting):
            kind, length = _FRAME.unpack_from(self._waiting, start)
            stop = start + _FRAME.size + length
            if kind not in KINDS or length > MAX_LENGTH:
                raise ValueError(f"a frame of kind {kind!r} and {length} bytes")
            if stop > len(self._waiting):
                break
            yield kind, bytes(self._waiting[start + _FRAME.size : stop])
            start = stop
        del self._waiting[:start]


class ContactHead(NamedTuple):
    """Description of the arm, the first frame."""

    model: Model  # model of the arm
    unit: str  # unit of the torques
    force: bool  # whether the force on the flange is known

    def frame(self) -> bytes:
        """The head as a frame."""
        return text_frame(HEAD, {**self._asdict(), "model": model_text(self.model)})

    @classmethod
    def read(cls, body: bytes) -> "ContactHead":
        """Read a head from the body of its frame."""
        content = json.loads(body)
        return cls(parse_model(content["model"]), content["unit"], content["force"])


class ContactRows(NamedTuple):
    """External torques to be drawn; unknown values are NaN."""

    time: np.ndarray  # time, shape (t,) [s]
    torque: np.ndarray  # external torques, shape (t, n) [N m]
    limit: np.ndarray  # torque at which each joint alone makes an alarm, shape (t, n) [N m]
    position: np.ndarray  # joint positions, shape (t, n) [rad]
    force: np.ndarray  # force on the flange in the axes of the base, shape (t, 3) [N]

    def frames(self) -> Iterator[bytes]:
        """One frame per row."""
        for row in np.column_stack(self).astype("<f8", copy=False):
            yield frame(SAMPLE, row.tobytes())

    @classmethod
    def read(cls, bodies: Sequence[bytes]) -> "ContactRows":
        """Read rows from the bodies of their frames."""
        rows = np.array([np.frombuffer(body, "<f8") for body in bodies])
        n = (rows.shape[1] - 4) // 3
        return cls(rows[:, 0], *np.split(rows[:, 1:], [n, 2 * n, 3 * n], axis=1))
