"""Sink: who is handed every frame of a run."""

from typing import Protocol


class Sink(Protocol):
    """The recorder, the live view: a process of its own at the other end of a pipe.

    `put` is called from the control loop: it never blocks and never raises.
    """

    @property
    def failure(self) -> str:
        """Why nothing can be handed over any more; empty while it can. A run without recorder is stopped."""

    def put(self, frame: bytes) -> None:
        """Hand a frame over."""

    def close(self) -> None:
        """Wait until all is written or shown."""
