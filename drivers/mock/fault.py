"""A fault that the mock can inject: when it acts, and what it is given to spoil."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .drives import MockDrives

START = -1.0
"""Time of every exchange before the first command, as faults count it [s]."""
ROUNDING = 1e-9
"""Of times [s]."""


@dataclass
class Reply:
    """What comes back in one cycle, before faults have acted on it and after.

    Attributes:
        position: Shape (n,) [rad].
        velocity: Shape (n,) [rad/s].
        current: Shape (n,) [A].
        temperature: Shape (n,) [degC].
        stale: Joints of which nothing fresh came, shape (n,).
        late: Time that it takes longer [s].
        lost: Why nothing comes back at all; empty where something does.
        events: Sentences.
    """

    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    temperature: np.ndarray
    stale: np.ndarray
    late: float = 0.0
    lost: str = ""
    events: list[str] = field(default_factory=list)

    def copy(self) -> "Reply":
        """The same, to be spoiled."""
        arrays = (self.position, self.velocity, self.current, self.temperature, self.stale)
        position, velocity, current, temperature, stale = (array.copy() for array in arrays)
        return Reply(position, velocity, current, temperature, stale)

    def silence(self, joint: int | slice) -> None:
        """Nothing came from a joint, or from several."""
        self.stale[joint] = True
        for values in (self.position, self.velocity, self.current, self.temperature):
            values[joint] = np.nan


class Fault(NamedTuple):
    """One fault.

    Attributes:
        kind: What it does.
        joint: Index of the joint it befalls; None for all, or for none in particular.
        amount: How much of it, in the fault's own unit.
        begin: From when on [s]; `START` for the first exchange.
        length: For how long [s]; zero for one cycle.
    """

    kind: "Kind"
    joint: int | None
    amount: float
    begin: float
    length: float

    def acts(self, before: float, now: float) -> bool:
        """Whether it acts in the cycle at a time [s], the one before having been at another."""
        since, then = now - self.begin + ROUNDING, before - self.begin + ROUNDING
        return since >= 0.0 and (then < 0.0 or since < self.length)

    @property
    def where(self) -> int | slice:
        """The joint, or all of them."""
        return slice(None) if self.joint is None else self.joint

    @property
    def one(self) -> int:
        """The joint, or the first."""
        return self.joint or 0


class Kind(NamedTuple):
    """What faults of a name do.

    Attributes:
        act: Spoils a reply, or the drives.
        usual: Default amount.
        lasts: Default length [s].
        prepare: What it does before the first exchange.
    """

    act: Callable[[Fault, Reply, MockDrives], None] = lambda fault, reply, drives: None
    usual: float = 0.0
    lasts: float = 0.0
    prepare: Callable[[Fault, MockDrives], None] = lambda fault, drives: None
