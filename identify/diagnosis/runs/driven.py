"""Runs as the diagnosis asks about them: with the torque that the fitted model gives at every sample."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import pinocchio as pin

from ...arm.motion import Motion
from ...arm.tangent import Tangent, tangent
from ...model import Model
from ...preparation.prepare import Filtering, Prepared, prepare
from ...recordings.recording import Recording


def link_torque(
    kinematics: pin.Model, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
) -> np.ndarray:
    """Torque (t, n) [N m] of the bodies of a Pinocchio model, moving so, each (t, n)."""
    data = kinematics.createData()
    states = zip(position, velocity, acceleration, strict=True)
    return np.array([pin.rnea(kinematics, data, *state) for state in states])


SMOOTH = 4.0
"""Samples a period of that cut-off which hold products of motions: twice what their band needs."""
CHUNK = 2000
"""Samples whose regressor is held at once; a few megabytes."""


@dataclass(frozen=True, eq=False)
class Unloaded:
    """What a run has at any load of its gears: worked out once, and shared by the run at each load."""

    bodies: pin.Model  # the arm with its links and its payload nominal
    motion: Motion  # its load is not used
    coarser: dict[int, "Unloaded"] = field(default_factory=dict)  # by step

    @cached_property
    def of_links(self) -> np.ndarray:
        """Torque of its links, moving as was recorded, shape (t, n) [N m]."""
        return link_torque(self.bodies, self.motion.position, self.motion.velocity, self.motion.acceleration)

    @cached_property
    def tangent(self) -> Tangent:
        """How much torque its links take when one is a little elsewhere."""
        return tangent(self.bodies, self.motion)

    def every(self, step: int) -> "Unloaded":
        """Every so many of its samples."""
        if step not in self.coarser:
            self.coarser[step] = Unloaded(self.bodies, self.motion[::step])
        return self.coarser[step]


@dataclass(frozen=True, eq=False)
class Driven:
    """One run."""

    role: str  # "identify", "validate", "slow", "payload", or as the run's settings state
    prepared: Prepared  # filtered motion and current
    motion: Motion  # the same motion with the load that the gears transmit by the fitted model
    torque: np.ndarray  # what the fitted model asks of the motors, at full rate, shape (t, n) [N m]
    bodies: pin.Model  # the arm with its links and its payload nominal
    peak: np.ndarray | None = None  # largest torque of each joint in all runs, (n,) [N m]; None for its own
    shared: Unloaded | None = None  # what it has at any load; None for its own

    @classmethod
    def of(cls, model: Model, recording: Recording, role: str, filtering: Filtering) -> "Driven":
        """Prepare a recording; the torque is that of the nominal model.

        Raises:
            RecordingError: It cannot be filtered.
        """
        prepared = prepare(recording, filtering)
        still = np.zeros_like(prepared.motion.position)
        bodies, _ = model.bodies_apart(model.nominal_values, prepared.motion.payload)
        shared = Unloaded(bodies, prepared.motion)
        nominal = cls(role, prepared, prepared.motion, still, bodies, shared=shared)
        return nominal.after(model, model.nominal_values)

    def after(self, model: Model, values: np.ndarray) -> "Driven":
        """This run with the torque of other parameters (p,), and with the load that gears transmit then."""
        load = model_torque(model, self.motion, values, transmitted=True)
        motion = replace(self.motion, load=load)
        torque = load + model_torque(model, motion, values, transmitted=False)
        return replace(self, motion=motion, torque=torque @ model.robot.to_motors.T)

    def with_more_load(self, torque: np.ndarray, on_motors: np.ndarray) -> "Driven":
        """This run with gears that transmit more torque (t, n) [N m], as joints and as motors feel it."""
        motion = replace(self.motion, load=self.motion.load + torque)
        return replace(self, motion=motion, torque=self.torque + on_motors)

    def thinned(self, columns: np.ndarray) -> np.ndarray:
        """Columns at full rate (t, ...), filtered and decimated to the rows that are compared, (r, ...)."""
        return self.prepared.decimation.apply(columns)[: self.rows]

    @property
    def filtering(self) -> Filtering:
        """Filters through which it was prepared."""
        own, cutoff = self.prepared.decimation, self.prepared.position_cutoff
        return Filtering(rate=own.rate, position_cutoff=cutoff, torque_cutoff=own.cutoff)

    @cached_property
    def most(self) -> np.ndarray:
        """Largest torque of each joint, shape (n,) [N m]."""
        return np.max(np.abs(self.torque), axis=0) if self.peak is None else self.peak

    @cached_property
    def unloaded(self) -> Unloaded:
        """What it has at any load."""
        return self.shared or Unloaded(self.bodies, self.motion)

    @property
    def of_links(self) -> np.ndarray:
        """Torque of its links, moving as was recorded, shape (t, n) [N m]."""
        return self.unloaded.of_links

    @property
    def tangent(self) -> Tangent:
        """How much torque its links take when one is a little elsewhere."""
        return self.unloaded.tangent

    @cached_property
    def rows(self) -> int:
        """Rows after thinning out."""
        return len(self.prepared.decimation.centres(len(self.motion)))

    @property
    def centres(self) -> np.ndarray:
        """Samples that the rows are about, shape (r,)."""
        return np.asarray(self.prepared.decimation.centres(len(self.motion))[: self.rows])

    @cached_property
    def coarse(self) -> "Driven":
        """This run at a lower rate, for what is no more abrupt than the motion."""
        decimation = self.prepared.decimation.thinned(SMOOTH * self.prepared.decimation.cutoff)
        step = decimation.step
        prepared = replace(self.prepared, decimation=decimation)
        coarse = replace(
            self,
            prepared=prepared,
            motion=self.motion[::step],
            torque=self.torque[::step],
            shared=self.unloaded.every(step),
        )
        coarse.__dict__["rows"] = self.rows
        return coarse


def model_torque(model: Model, motion: Motion, values: np.ndarray, transmitted: bool) -> np.ndarray:
    """Torque of all effects that gears transmit, or of all others, by parameters (p,), (t, n) [N m]."""
    part = replace(model, effects=tuple(e for e in model.effects if e.transmitted == transmitted))
    known = dict(zip(model.names, values, strict=True))
    own = np.array([known[name] for name in part.names])
    starts = range(0, len(motion), CHUNK)
    return np.concatenate([part.torque(motion[start : start + CHUNK], own) for start in starts])


def slices(runs: Sequence[Driven]) -> tuple[slice, ...]:
    """Rows of each run when they are stacked."""
    stops = np.cumsum([0, *(run.rows for run in runs)])
    return tuple(slice(int(a), int(b)) for a, b in zip(stops[:-1], stops[1:], strict=True))
