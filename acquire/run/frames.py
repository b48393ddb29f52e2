"""Frames: how the loop hands a run over to the processes that write and show it, through a pipe.

A frame is a kind, a length and a body: samples in fixed binary, all else as JSON. A pipe keeps what was
written when its writer dies, and frames are smaller than what a pipe takes at once, so none is ever torn.
"""

import json
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from exidyn.drivers import Command, Sample
from exidyn.drivers.values import SIGNALS

HEAD, SAMPLE, EVENT, END = b"H", b"S", b"E", b"Z"
"""Kinds: once at the start, every cycle, what happened, once at the end."""
KINDS = (HEAD, SAMPLE, EVENT, END)
LONGEST = 64 << 20
"""Bytes that no frame has: a head with the largest robot and plan is a hundredth of that."""
_FRAME = struct.Struct("<cI")
_FIXED = struct.Struct("<qqdIII")
ARRAYS = (*SIGNALS, "command_position", "command_velocity")
"""Arrays of a sample frame, each (n,) in the units of `Sample` and `Command`."""


@dataclass(frozen=True, slots=True)
class Cycle:
    """One cycle as it is handed over.

    Attributes:
        host_time: [ns since 1970].
        controller_time: [ns from the controller's zero].
        lateness: [s].
        skipped: Cycles without an exchange before this one.
        stage: Index in `STAGES`.
        arrays: Rows as in `ARRAYS`, shape (7, n); the command that was sent in this cycle, NaN for none.
        state: The controller's own, shape (k,), as in `Sample`.
    """

    host_time: int
    controller_time: int
    lateness: float
    skipped: int
    stage: int
    arrays: np.ndarray
    state: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def array(self, name: str) -> np.ndarray:
        """One of `ARRAYS`, shape (n,)."""
        return self.arrays[ARRAYS.index(name)]


STAGES = ("listening", "approaching", "running", "braking", "holding")
"""What the arm was doing, in the order in which it usually comes."""


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened.

    Attributes:
        host_time: [ns since 1970].
        controller_time: [ns from the controller's zero].
        kind: A word: "driver", "stage", "stop", "late", "warning".
        text: In a sentence.
        details: Joint, value, limit, unit and level of a stop, where it has them.
    """

    host_time: int
    controller_time: int
    kind: str
    text: str
    details: Mapping[str, Any]


def sample_frame(sample: Sample, command: Command | None, stage: int) -> bytes:
    """One cycle: what was measured and the command sent in it."""
    nothing = np.full(len(sample.position), np.nan)
    sent = (command.position, command.velocity) if command is not None else (nothing, nothing)
    times, state = (sample.host_time, sample.controller_time, sample.lateness), sample.state
    body = _FIXED.pack(*times, sample.skipped, stage, len(state))
    arrays = (state, *(getattr(sample, name) for name in SIGNALS), *sent)
    return frame(SAMPLE, body + np.concatenate(arrays).astype("<f8", copy=False).tobytes())


def text_frame(kind: bytes, content: Mapping[str, Any]) -> bytes:
    """A head, an event or an end."""
    return frame(kind, json.dumps(content, default=str).encode())


def frame(kind: bytes, body: bytes) -> bytes:
    """Any kind, its body written already."""
    return _FRAME.pack(kind, len(body)) + body


def event_frame(event: Event) -> bytes:
    """Something that happened."""
    return text_frame(EVENT, {name: getattr(event, name) for name in Event.__slots__})


def read_cycle(body: bytes) -> Cycle:
    """The cycle of a sample frame."""
    host_time, controller_time, lateness, skipped, stage, states = _FIXED.unpack_from(body)
    numbers = np.frombuffer(body, "<f8", offset=_FIXED.size)
    arrays = numbers[states:].reshape(len(ARRAYS), -1)
    return Cycle(host_time, controller_time, lateness, skipped, stage, arrays, numbers[:states])


def read_event(body: bytes) -> Event:
    """The event of an event frame."""
    fields = json.loads(body)
    times = int(fields["host_time"]), int(fields["controller_time"])
    return Event(*times, str(fields["kind"]), str(fields["text"]), dict(fields["details"]))


class Unframed:
    """Frames out of bytes that come in any pieces."""

    def __init__(self) -> None:
        self._waiting = bytearray()

    def add(self, data: bytes) -> Iterator[tuple[bytes, bytes]]:
        """Kind and body of each frame that is whole by now.

        Raises:
            ValueError: What comes cannot be frames, so that the begin of the next one is unknown.
        """
        self._waiting += data
        start = 0
        while start + _FRAME.size <= len(self._waiting):
            kind, length = _FRAME.unpack_from(self._waiting, start)
            stop = start + _FRAME.size + length
            if kind not in KINDS or length > LONGEST:
                raise ValueError(f"a frame of kind {kind!r} and {length} bytes")
            if stop > len(self._waiting):
                break
            yield kind, bytes(self._waiting[start + _FRAME.size : stop])
            start = stop
        del self._waiting[:start]
