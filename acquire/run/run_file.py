"""RunFile: writes the frames of a run as topics of an MCAP file; DiskFile: that file on the disk."""

import errno
import os
import tempfile
import threading
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import IO

import numpy as np

from exidyn.identification.recordings import recording
from exidyn.identification.recordings.mcap.mcap_topics import (
    ARRAY,
    ARRAY_TOPICS,
    COMMAND_FIELDS,
    EVENTS,
    JOINT_STATE,
    STATE_FIELDS,
    TRANSFORMS,
    Topic,
    event_message,
    state_messages,
    state_topic,
    timing_messages,
    timing_topic,
)
from exidyn.identification.recordings.mcap.mcap_writer import (
    RecordingWriter,
    Stream,
    of_any_length,
    pose_messages,
    ticks,
    write_merged,
)

from .frames import ARRAYS, STAGES, Cycle, Event
from .recorder import RunHead

IN_FRAMES = {"command": "command_position"}
"""Names in frames of signals that have another name in recordings."""
RESERVE = 4 << 20
"""Bytes of disk space in reserve: some ten seconds of a run, enough to stop the arm and finish the file."""
SYNC = 1.0
"""Time between requests to the operating system to flush the file to the disk [s]. Only a power failure loses
unflushed data; a killed process does not."""
FULL = (errno.ENOSPC, errno.EDQUOT)


class RunFile:
    """Writes a run as it happens, its head at once."""

    def __init__(self, stream: IO[bytes], head: RunHead) -> None:
        self._head = head
        self._robot = head.model.robot
        self._signals = _topics(head.signals)
        self._timing = timing_topic(STAGES)
        self._state = [state_topic(head.state)] if head.state else []
        self._shown = -np.inf
        settings = {**head.settings, "controller_zero_ns": str(head.zero)}
        self._writer = RecordingWriter(stream, replace(head, settings=settings))
        for topic in (*self._signals, TRANSFORMS, self._timing, *self._state, EVENTS):
            self._writer.add_topic(topic)
        self._writer.flush()

    def validated(self, cycle: Cycle) -> Cycle:
        """The cycle, if it can belong to this arm and run.

        Raises:
            ValueError: If it cannot.
        """
        joints = cycle.arrays.shape[1]
        if joints != self._robot.dof:
            raise ValueError(f"a sample of {joints} joints, expected {self._robot.dof}")
        if len(cycle.state) != len(self._head.state):
            raise ValueError(f"{len(cycle.state)} state values, expected {len(self._head.state)}")
        if min(cycle.host_time, cycle.controller_time - self._head.zero + self._head.epoch) < 0:
            raise ValueError(f"a sample before 1970: {cycle.host_time} ns, {cycle.controller_time} ns")
        return cycle

    def write(self, cycles: Sequence[Cycle], events: Sequence[Event]) -> None:
        """Write cycles and events, and flush them to the file."""
        streams = [self._event_stream(events)] if events else []
        if cycles:
            streams += self._cycle_streams(cycles)
        if streams:
            write_merged(streams, self._writer)
        self._writer.flush()

    def finish(self, outcome: Mapping[str, str]) -> None:
        """Write the outcome of the run, and the index that viewers need."""
        self._writer.add_outcome(outcome)
        self._writer.finish()

    def _event_stream(self, events: Sequence[Event]) -> Stream:
        since = np.array([event.controller_time - self._head.zero for event in events], np.int64)
        messages = [
            event_message(recording.Event(1e-9 * time, event.kind, event.text, event.details))
            for time, event in zip(since.tolist(), events, strict=True)
        ]
        logged = np.array([event.host_time for event in events], np.int64)
        return Stream(EVENTS, since + self._head.epoch, logged, of_any_length(messages))

    def _cycle_streams(self, cycles: Sequence[Cycle]) -> list[Stream]:
        since = np.array([cycle.controller_time - self._head.zero for cycle in cycles], np.int64)
        logged = np.array([cycle.host_time for cycle in cycles], np.int64)
        time, arrays = 1e-9 * since, np.stack([cycle.arrays for cycle in cycles])  # (t,), (t, 7, n)
        streams = []
        for topic in self._signals:
            values = {signal: arrays[:, _row(signal)] for signal in topic.fields}
            rows = np.any([np.isfinite(value).any(axis=1) for value in values.values()], axis=0)
            signals = {signal: recording.Signal(time[rows], value[rows]) for signal, value in values.items()}
            streams.append((topic, rows, topic.messages(self._robot.joints, signals)))
        streams.append(self._poses(time, arrays[:, _row("position")]))
        timing = recording.Timing(
            time,
            np.array([cycle.lateness for cycle in cycles]),
            np.array([cycle.skipped for cycle in cycles]),
            np.array([cycle.stage for cycle in cycles]),
        )
        streams.append((self._timing, np.ones(len(time), bool), timing_messages(timing)))
        for topic in self._state:
            state = np.stack([cycle.state for cycle in cycles])
            rows = np.isfinite(state).any(axis=1)
            streams.append((topic, rows, state_messages(state[rows])))
        published = since + self._head.epoch
        return [Stream(topic, published[rows], logged[rows], messages) for topic, rows, messages in streams]

    def _poses(self, time: np.ndarray, position: np.ndarray) -> tuple[Topic, np.ndarray, np.ndarray]:
        """Topic, rows and messages of the poses that viewers show."""
        tick = ticks(time)
        rows = (np.diff(tick, prepend=self._shown) != 0.0) & np.isfinite(position).all(axis=1)
        self._shown = tick[-1]
        return TRANSFORMS, rows, pose_messages(self._robot.kinematics, time[rows], position[rows])


def _topics(measured: Sequence[str]) -> list[Topic]:
    """Topics of the measured and commanded signals."""
    states = {name: field for name, field in STATE_FIELDS.items() if name in ("position", *measured)}
    arrays = [name for name in ARRAY_TOPICS if name in measured and name not in STATE_FIELDS]
    return [
        Topic("/joint_states", JOINT_STATE, states),
        Topic("/joint_command", JOINT_STATE, COMMAND_FIELDS),
        *(Topic(ARRAY_TOPICS[name], ARRAY, {name: "data"}) for name in arrays),
    ]


def _row(signal: str) -> int:
    return ARRAYS.index(IN_FRAMES.get(signal, signal))


class DiskFile:
    """A new file with the interface that the MCAP writer needs, and disk space in reserve [bytes].

    A context manager that closes it.

    Raises:
        OSError: If the file exists or cannot be created, or the disk has no space for the reserve.
    """

    def __init__(self, path: Path, reserve: int = RESERVE) -> None:
        self.full = ""  # disk error, such as a full disk with only the reserve left
        self._size = 0
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
        self._closing = threading.Event()
        self._syncing = threading.Thread(target=self._sync, daemon=True)
        try:
            # Without a name, so that a crash frees the space too.
            self._reserve = tempfile.TemporaryFile(dir=path.parent)
            os.posix_fallocate(self._reserve.fileno(), 0, reserve)
        except OSError:
            os.close(self._file)
            path.unlink()
            raise
        self._syncing.start()

    def write(self, data: bytes) -> int:
        """Append data; if the disk is full, use the reserve.

        Raises:
            OSError: If the reserve is used up too, or writing fails otherwise.
        """
        unwritten = memoryview(data)
        while unwritten:
            try:
                unwritten = unwritten[os.write(self._file, unwritten) :]
            except OSError as error:
                if error.errno not in FULL or self.full:
                    raise
                self.full = error.strerror or "full"
                self._reserve.close()
        self._size += len(data)
        return len(data)

    def tell(self) -> int:
        """Number of bytes written."""
        return self._size

    def flush(self) -> None:
        """Do nothing: written data is with the operating system and survives this process."""

    def _sync(self) -> None:
        """Flush to the disk regularly; runs in a thread, since it takes long on a busy disk."""
        while not self._closing.wait(SYNC):
            try:
                os.fdatasync(self._file)
            except OSError as error:
                self.full = error.strerror or "failing"

    def close(self) -> None:
        """Flush all data to the disk and close the file."""
        if self._closing.is_set():
            return
        self._closing.set()
        self._syncing.join()
        self._reserve.close()
        try:
            os.fsync(self._file)
        finally:
            os.close(self._file)

    def __enter__(self) -> "DiskFile":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
