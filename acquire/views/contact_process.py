"""The process that shows external torques live, as `view_process` shows a run."""

import sys

import rerun as rr

from ..run.frames import EVENT, HEAD, SAMPLE, ContactHead, ContactRows, Event, read_event
from .contact_view import EVENTS, LEAST, ContactLog, contact_layout, weight
from .live_log import live_plot
from .parts import log_event
from .view_process import show_frames


class ContactFrames:
    """Logs the frames of an arm that is watched, in batches."""

    def __init__(self, stream: rr.RecordingStream) -> None:
        self._stream = stream
        self._log: ContactLog | None = None
        self._samples: list[bytes] = []
        self._events: list[Event] = []

    def take(self, kind: bytes, body: bytes) -> None:
        """Take a frame."""
        if kind == HEAD:
            head = ContactHead.read(body)
            self._log = ContactLog(self._stream, head.model, LEAST * weight(head.model))
            layout = contact_layout(head.model, head.unit, head.force, True, live_plot, "following")
            self._stream.send_blueprint(layout)
        elif kind == SAMPLE:
            self._samples.append(body)
        elif kind == EVENT:
            self._events.append(read_event(body))

    def draw(self, last: bool) -> None:
        """Log what was taken since the last batch."""
        if self._log is not None and self._samples:
            self._log.add(ContactRows.read(self._samples))
        for event in self._events:
            log_event(self._stream, [EVENTS], 1e-9 * event.controller_time, event.kind, event.text)
        self._samples, self._events = [], []


if __name__ == "__main__":
    sys.exit(show_frames(sys.argv[1:], ContactFrames))
