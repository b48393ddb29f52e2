"""What happened during a run beside what was measured: events, its clock, the controller's own state."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import WrongShape


@dataclass(frozen=True)
class Event:
    """Something that happened.

    Attributes:
        time: On the recording's axis [s].
        kind: A word: "driver", "stage", "stop", "late", "warning".
        text: In a sentence.
        details: Joint, value, limit, unit and level of a stop, where it has them.
    """

    time: float
    kind: str
    text: str
    details: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Timing:
    """How each cycle of the control loop went.

    Attributes:
        time: Shape (t,) on the recording's axis [s], rounded to the nanosecond that files keep.
        lateness: By how much each began too late, shape (t,) [s].
        skipped: Cycles that were missed before each, shape (t,).
        stage: What the arm was doing, shape (t,): indices into `stages`.
        stages: Names.
    """

    time: np.ndarray
    lateness: np.ndarray
    skipped: np.ndarray
    stage: np.ndarray
    stages: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        kinds = {"time": float, "lateness": float, "skipped": np.int64, "stage": np.int64}
        for name, kind in kinds.items():
            array = np.array(getattr(self, name), kind)
            if name == "time":
                array = np.rint(array * 1e9) / 1e9
            if array.shape != np.shape(self.time):
                raise WrongShape(f"timing: {name} has shape {array.shape}, time {np.shape(self.time)}")
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.time)


@dataclass(frozen=True, eq=False)
class ControllerState:
    """What the controller reported about itself, such as its safety mode.

    Attributes:
        time: Shape (t,) on the recording's axis [s], rounded to the nanosecond that files keep.
        values: Shape (t, k), a column a name; NaN where unknown.
        words: Name -> what its codes mean; nothing for a plain number.
    """

    time: np.ndarray
    values: np.ndarray
    words: Mapping[str, Mapping[int, str]]

    def __post_init__(self) -> None:
        time, values = np.rint(np.array(self.time, float) * 1e9) / 1e9, np.array(self.values, float)
        expected = (*np.shape(time), len(self.words))
        if values.shape != expected:
            raise WrongShape(f"controller state: values have shape {values.shape}, expected {expected}")
        for name, array in (("time", time), ("values", values)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.time)

    def of(self, name: str) -> np.ndarray:
        """One of `words`, shape (t,)."""
        values: np.ndarray = self.values[:, list(self.words).index(name)]
        return values
