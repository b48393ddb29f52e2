"""Reloading: torque and load of a run as they are known after a fit, with everything found that gears carry.

A link floats in its play where its load is small, and friction depends on the load: some thousandths of it
decide when.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...model import Model
from ..questions.block_answer import Answer
from ..questions.candidate import Candidate, Thinned
from ..runs.driven import Driven

ALIKE = 2e-3
"""Change of a load over the load [-] that moves no link: its play is crossed some milliseconds sooner."""


@dataclass(frozen=True, eq=False)
class Known:
    """What makes the torque and the load of any run.

    Attributes:
        model: Nominal.
        values: Its parameters as fitted, shape (p,).
        first: Whether nothing was found yet that matters for it.
        carried: Findings that gears carry, with their coefficients.
        peak: Largest torque of each joint in the runs fitted, shape (n,) [N m]; None before that is known.
    """

    model: Model
    values: np.ndarray
    first: bool = True
    carried: tuple[tuple[Candidate, np.ndarray], ...] = ()
    peak: np.ndarray | None = None

    @classmethod
    def after(cls, model: Model, unknowns: np.ndarray, found: Sequence[Answer] = ()) -> "Known":
        """From unknowns (b,) the last of which are what was found."""
        count = sum(len(one.values) for one in found)
        own = np.split(unknowns[len(unknowns) - count :], np.cumsum([len(one.values) for one in found]))
        carried = [
            (one.candidate, values) for one, values in zip(found, own, strict=False) if one.candidate.carried
        ]
        values = model.nominal_values + unknowns[: len(model.names)]
        return cls(model, values, not found, tuple(carried))

    def of(self, runs: Sequence[Driven]) -> "Known":
        """The same with the largest torques of these runs."""
        torques = [np.max(np.abs(run.torque), axis=0) for run in map(self.on, runs)]
        return replace(self, peak=np.max(torques, axis=0))

    def on(self, run: Driven) -> Driven:
        """A run with that torque and load."""
        fresh = run.after(self.model, self.values)
        for candidate, values in self.carried:
            torque = candidate.columns(fresh) @ values
            fresh = fresh.bearing(_on_joints(self.model, torque), torque)
        return replace(fresh, peak=self.peak)


def alike(before: Sequence[Driven], after: Sequence[Driven]) -> bool:
    """Whether the load has hardly changed."""
    pairs = [(one.motion.load, other.motion.load) for one, other in zip(before, after, strict=True)]
    load = np.concatenate([one for one, _ in pairs])
    change = np.concatenate([other - one for one, other in pairs])
    return bool(np.all(np.linalg.norm(change, axis=0) <= ALIKE * np.linalg.norm(load, axis=0)))


def anew(candidate: Candidate, columns: Thinned, runs: Sequence[Driven]) -> Thinned:
    """Columns of a candidate over runs whose load has changed; those of a measured gear are zero at any."""
    changed = candidate.loaded and bool(np.any(columns.values))
    return Thinned.of(candidate, runs) if changed else columns


def _on_joints(model: Model, torque: np.ndarray) -> np.ndarray:
    """Torque of motors (t, n) [N m], seen from the joints."""
    return np.linalg.solve(model.robot.to_motors, torque.T).T
