"""Runs of a diagnosis: prepared recordings with the fitted model's torque at every sample."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

import numpy as np
import pinocchio as pin

from ...arm.motion import Motion, Tangent, tangent
from ...model import Model
from ...preparation.prepare import Filtering, Prepared, prepare
from ...recordings.recording import Recording


def link_torque(
    kinematics: pin.Model, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
) -> np.ndarray:
    """Inverse dynamics of a Pinocchio model for a motion, each argument (t, n); torque (t, n) [N m]."""
    data = kinematics.createData()
    states = zip(position, velocity, acceleration, strict=True)
    return np.array([pin.rnea(kinematics, data, *state) for state in states])


SMOOTH = 4.0
"""Samples per period of the cutoff frequency for products of motions: twice what their band needs."""
CHUNK = 2000
"""Samples whose regressor is in memory at once; a few megabytes."""


@dataclass(frozen=True, eq=False)
class Unloaded:
    """Quantities of a run that do not depend on the load of its gears, computed once and shared."""

    bodies: pin.Model  # arm with nominal links and nominal payload
    motion: Motion  # recorded motion, whose load is not used
    coarser: dict[int, "Unloaded"] = field(default_factory=dict)  # cache of every k-th sample, by k

    @cached_property
    def of_links(self) -> np.ndarray:
        """Torque of the links in the recorded motion, shape (t, n) [N m]."""
        return link_torque(self.bodies, self.motion.position, self.motion.velocity, self.motion.acceleration)

    @cached_property
    def tangent(self) -> Tangent:
        """Change of the links' torque for small displacements of each joint."""
        return tangent(self.bodies, self.motion)

    def strided(self, step: int) -> "Unloaded":
        """A copy with every `step`-th sample."""
        if step not in self.coarser:
            self.coarser[step] = Unloaded(self.bodies, self.motion[::step])
        return self.coarser[step]


@dataclass(frozen=True, eq=False)
class Driven:
    """One run, with the torque of the fitted model."""

    role: str  # "identify", "validate", "slow", "payload", or another role from the run's settings
    prepared: Prepared  # filtered motion and current
    motion: Motion  # filtered motion with the gear load of the fitted model
    torque: np.ndarray  # motor torque of the fitted model, at full rate, shape (t, n) [N m]
    unloaded: Unloaded  # quantities of this run that do not depend on the load
    peak: np.ndarray | None = None  # largest torque of each joint in all runs, (n,) [N m]; None for this run
    found: pin.Model | None = None  # arm with the bodies fitted and found so far; None for the nominal ones

    @property
    def bodies(self) -> pin.Model:
        """Arm with the bodies fitted and found so far; nominal before."""
        return self.unloaded.bodies if self.found is None else self.found

    @classmethod
    def of(cls, model: Model, recording: Recording, role: str, filtering: Filtering) -> "Driven":
        """Prepare a recording, with the torque of the nominal model.

        Raises:
            RecordingError: If the recording cannot be filtered.
        """
        prepared = prepare(recording, filtering)
        no_torque = np.zeros_like(prepared.motion.position)
        bodies, _ = model.bodies_apart(model.nominal_values, prepared.motion.payload)
        unloaded = Unloaded(bodies, prepared.motion)
        nominal = cls(role, prepared, prepared.motion, no_torque, unloaded)
        return nominal.after(model, model.nominal_values)

    def after(self, model: Model, values: np.ndarray) -> "Driven":
        """This run with the torque and gear load of other parameters (p,)."""
        load = model_torque(model, self.motion, values, transmitted=True)
        motion = replace(self.motion, load=load)
        torque = load + model_torque(model, motion, values, transmitted=False)
        return replace(self, motion=motion, torque=torque @ model.robot.to_motors.T)

    def with_more_load(self, torque: np.ndarray, on_motors: np.ndarray) -> "Driven":
        """This run with additional gear load at the joints and additional motor torque, each (t, n) [N m]."""
        motion = replace(self.motion, load=self.motion.load + torque)
        return replace(self, motion=motion, torque=self.torque + on_motors)

    def thinned(self, columns: np.ndarray) -> np.ndarray:
        """Columns at full rate (t, ...), filtered and decimated to the rows of the fit, (r, ...)."""
        return self.prepared.decimation.apply(columns)[: self.rows]

    @property
    def filtering(self) -> Filtering:
        """Filters that prepared the run."""
        decimation, cutoff = self.prepared.decimation, self.prepared.position_cutoff
        return Filtering(rate=decimation.rate, position_cutoff=cutoff, torque_cutoff=decimation.cutoff)

    @cached_property
    def most(self) -> np.ndarray:
        """Largest torque of each joint, shape (n,) [N m]."""
        return np.max(np.abs(self.torque), axis=0) if self.peak is None else self.peak

    @cached_property
    def rows(self) -> int:
        """Number of rows after decimation."""
        return len(self.prepared.decimation.centres(len(self.motion)))

    @property
    def centres(self) -> np.ndarray:
        """Index of the sample at the center of each row, shape (r,)."""
        return np.asarray(self.prepared.decimation.centres(len(self.motion))[: self.rows])

    @cached_property
    def coarse(self) -> "Driven":
        """This run at a lower rate, for torques that are as smooth as the motion."""
        decimation = self.prepared.decimation.thinned(SMOOTH * self.prepared.decimation.cutoff)
        step = decimation.step
        prepared = replace(self.prepared, decimation=decimation)
        coarse = replace(
            self,
            prepared=prepared,
            motion=self.motion[::step],
            torque=self.torque[::step],
            unloaded=self.unloaded.strided(step),
        )
        coarse.__dict__["rows"] = self.rows
        return coarse


Computed = TypeVar("Computed")


def cached(compute: Callable[[Driven], Computed], loaded: bool = True) -> Callable[[Driven], Computed]:
    """The same function, computed once per run; a value is freed together with its run.

    Unless its value depends on the load, runs at another load share it.
    """
    cache: WeakKeyDictionary[object, Computed] = WeakKeyDictionary()

    @wraps(compute)
    def compute_once(run: Driven) -> Computed:
        key = run if loaded else run.unloaded
        if key not in cache:
            cache[key] = compute(run)
        return cache[key]

    return compute_once


def model_torque(model: Model, motion: Motion, values: np.ndarray, transmitted: bool) -> np.ndarray:
    """Torque of the effects that gears transmit, or of all others, with parameters (p,); (t, n) [N m]."""
    part = replace(model, effects=tuple(e for e in model.effects if e.transmitted == transmitted))
    known = dict(zip(model.names, values, strict=True))
    part_values = np.array([known[name] for name in part.names])
    starts = range(0, len(motion), CHUNK)
    return np.concatenate([part.torque(motion[start : start + CHUNK], part_values) for start in starts])


def slices(runs: Sequence[Driven]) -> tuple[slice, ...]:
    """Rows of each run in the stacked rows."""
    stops = np.cumsum([0, *(run.rows for run in runs)])
    return tuple(slice(int(a), int(b)) for a, b in zip(stops[:-1], stops[1:], strict=True))
