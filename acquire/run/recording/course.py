"""Course: what is known of a run while it is written, and how it ended."""

from array import array
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..pipe.frames import Cycle, Event


@dataclass
class Course:
    """What is known of the run so far.

    Attributes:
        cycles: Number of samples.
        skipped: Cycles that were missed.
        lateness: Of each [s].
        host_time: Of the last [ns since 1970].
        controller_time: Of the last [ns].
        end: The loop's result at its end; None until then.
        unreadable: Frames that made no sense.
    """

    cycles: int = 0
    skipped: int = 0
    lateness: array = field(default_factory=lambda: array("d"))
    host_time: int = 0
    controller_time: int = 0
    end: dict[str, Any] | None = None
    unreadable: int = 0

    def count(self, cycle: Cycle) -> None:
        """Take in one more cycle."""
        self.cycles += 1
        self.skipped += cycle.skipped
        self.lateness.append(cycle.lateness)
        self.host_time, self.controller_time = cycle.host_time, cycle.controller_time

    def event(self, kind: str, text: str) -> Event:
        """Message of this process, at the time of the last cycle."""
        return Event(self.host_time, self.controller_time, kind, text, {})

    def outcome(self) -> dict[str, str]:
        """How the run ended, for the recording."""
        facts = {name: str(value) for name, value in (self.end or {"stop": "unknown"}).items()}
        late = np.frombuffer(self.lateness) if self.cycles else np.zeros(1)
        p50, p99 = np.percentile(late, [50, 99])
        counted = {"cycles": self.cycles, "skipped": self.skipped, "unreadable_frames": self.unreadable}
        measured = {"lateness_p50": p50, "lateness_p99": p99, "lateness_max": late.max()}
        return (
            facts
            | {name: str(number) for name, number in counted.items()}
            | {f"{name}_s": f"{value:.6f}" for name, value in measured.items()}
        )
