"""Model: a robot, the effects that make its torque, and what lies between it and its recordings."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import accumulate, pairwise

import numpy as np
import pinocchio as pin

from .arm.motion import Motion
from .arm.robot import Robot
from .arm.tangent import tangent
from .effects import Effect, MotionGradient, Parameter, Prior
from .errors import RobotError, WrongShape
from .measurements import Gear, Measurement
from .notebook import InNotebook

CHUNK = 2000
"""Samples whose full-rate regressor is held at once; a few megabytes stay in the cache."""


@dataclass(frozen=True, repr=False)
class Model(InNotebook):
    """Joint torque = sum over effects of regressor @ parameters + known torque.

    Attributes:
        robot: Kinematics, limits and drives.
        effects: What makes torque; order is the order of the columns.
        stated: Priors about parameters by name, beyond the robot's inertias.
        bounded: Names of those that are certain to be within the square root of three deviations.
        measurements: What makes a recording differ from the motion and torque of rigid joints: delays, gears
            that give way, clipped currents. A fit takes it out of recordings, and a simulation puts it in.
    """

    robot: Robot
    effects: tuple[Effect, ...]
    stated: Mapping[str, Prior] = field(default_factory=dict)
    bounded: frozenset[str] = frozenset()
    measurements: tuple[Measurement, ...] = ()

    def __post_init__(self) -> None:
        for measurement in self.measurements:
            measurement.check(self.robot)
        names = [parameter.name for parameter in self.parameters]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise RobotError(f"{self.robot.name}: parameters named twice: {', '.join(twice)}")

    def __add__(self, effect: Effect) -> "Model":
        return replace(self, effects=(*self.effects, effect))

    def __repr__(self) -> str:
        parts = ", ".join(type(part).__name__ for part in (*self.effects, *self.measurements))
        return f"Model of {self.robot.name}: {self.robot.dof} joints, {len(self.names)} parameters: {parts}"

    def with_values(self, **values: float) -> "Model":
        """Return the model with other nominal values; standard deviations stay as they are.

        Example:
            >>> robot("kr270").with_values(Fv2=30.0)

        Raises:
            RobotError: There is no such parameter; the message lists the valid ones.
        """
        priors = dict(zip(self.names, self.priors, strict=True))
        if unknown := [name for name in values if name not in priors]:
            raise RobotError(
                f"{self.robot.name} has no parameter {', '.join(unknown)}. Valid: {', '.join(priors)}"
            )
        changed = {name: Prior(float(value), priors[name].std) for name, value in values.items()}
        return replace(self, stated={**self.stated, **changed})

    def at(self, values: np.ndarray) -> "Model":
        """The same model whose nominal values are these (p,), with the deviations that it has."""
        priors = zip(self.names, values, self.priors, strict=True)
        return replace(self, stated={name: Prior(float(value), prior.std) for name, value, prior in priors})

    @property
    def parameters(self) -> list[Parameter]:
        """Linear unknowns of all effects, one a column."""
        return [parameter for effect in self.effects for parameter in effect.parameters(self.robot)]

    @property
    def names(self) -> list[str]:
        """Names of the parameters, one a column."""
        return [parameter.name for parameter in self.parameters]

    @property
    def priors(self) -> list[Prior]:
        """What is held true of each parameter; value zero and infinite deviation where nothing is."""
        known = {n: b for effect in self.effects for n, b in effect.priors(self.robot).items()}
        known |= self.stated
        return [known.get(name, Prior(0.0)) for name in self.names]

    @property
    def nominal_values(self) -> np.ndarray:
        """Nominal value of each parameter, shape (p,)."""
        return np.array([prior.value for prior in self.priors])

    @property
    def inertias(self) -> list[slice]:
        """Columns that are the ten parameters of one rigid body each."""
        return [
            slice(own.start + body.start, own.start + body.stop)
            for effect, own in zip(self.effects, self.columns, strict=True)
            for body in effect.inertias(self.robot)
        ]

    @property
    def columns(self) -> list[slice]:
        """Columns of each effect."""
        counts = (len(effect.parameters(self.robot)) for effect in self.effects)
        return [slice(*ends) for ends in pairwise(accumulate(counts, initial=0))]

    @property
    def payloads(self) -> dict[str, Effect]:
        """Bodies that runs may carry on the flange, by name."""
        return {effect.payload: effect for effect in self.effects if effect.payload}

    @property
    def delay(self) -> np.ndarray:
        """Time by which the effort of each joint is recorded later than its position, shape (n,) [s]."""
        return sum((one.delay(self.robot) for one in self.measurements), np.zeros(self.robot.dof))

    @property
    def current_limit(self) -> np.ndarray:
        """Largest effort of each joint that is recorded, infinite without a limit, shape (n,) [A, N m]."""
        return np.min(
            [np.full(self.robot.dof, np.inf), *(m.current_limit(self.robot) for m in self.measurements)], 0
        )

    def recorded(self, torque: np.ndarray) -> np.ndarray:
        """Drive gains times the currents that are recorded at motor torques (..., n), as many [N m]."""
        for measurement in self.measurements:
            torque = measurement.recorded(self.robot, torque)
        return torque

    def restored(self, shown: np.ndarray) -> np.ndarray:
        """Motor torques for drive gains times recorded currents (t, n), as many [N m]."""
        for measurement in reversed(self.measurements):
            shown = measurement.restored(self.robot, shown)
        return shown

    @property
    def gears(self) -> tuple[Gear, ...]:
        """Gears that are not rigid."""
        return tuple(one for one in self.measurements if isinstance(one, Gear))

    def shares(self, values: np.ndarray) -> list[tuple[Effect, np.ndarray]]:
        """Each effect with its own of the parameters (p,)."""
        return [(effect, values[own]) for effect, own in zip(self.effects, self.columns, strict=True)]

    def regressor(self, motion: Motion) -> np.ndarray:
        """Torque per unit of each parameter, shape (t, n, p) [N m / unit]."""
        return self._stacked(motion, [effect.regressor(self.robot, motion) for effect in self.effects])

    def pieces(
        self, motion: Motion, loading: "Model | None" = None
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Regressor (t, n, p) and known torque (t, n) of a whole run, piece by piece to spare memory.

        Effects with a memory see the run at once; the load on gears is that of `loading`, or of this model.
        """
        known = {
            place: e.regressor(self.robot, motion) for place, e in enumerate(self.effects) if not e.pointwise
        }
        needs_load = any(effect.needs_load for effect in self.effects)
        for start in range(0, len(motion), CHUNK):
            rows = slice(start, start + CHUNK)
            piece = (loading or self).loaded(motion[rows]) if needs_load else motion[rows]
            columns = [
                known[place][rows] if place in known else effect.regressor(self.robot, piece)
                for place, effect in enumerate(self.effects)
            ]
            yield self._stacked(piece, columns), self.known_torque(piece)

    def _stacked(self, motion: Motion, columns: list[np.ndarray]) -> np.ndarray:
        return np.concatenate([np.zeros((*motion.position.shape, 0)), *columns], axis=2)

    def known_torque(self, motion: Motion) -> np.ndarray:
        """Torque that no parameter scales (a known payload), shape (t, n) [N m]."""
        return sum((e.known_torque(self.robot, motion) for e in self.effects), np.zeros_like(motion.position))

    def torque(self, motion: Motion, values: np.ndarray) -> np.ndarray:
        """Joint torque for given parameter values (p,), shape (t, n) [N m]."""
        return self.regressor(motion) @ values + self.known_torque(motion)

    def bodies_apart(
        self, values: np.ndarray, payload: str
    ) -> tuple[pin.Model, list[tuple[Effect, np.ndarray]]]:
        """The joints with the bodies that parameters (p,) give them, and other effects with their parameters.

        Raises:
            WrongShape: Not a value a parameter.
        """
        kinematics, others = self.robot.kinematics.copy(), []
        kinematics.armature = np.zeros(kinematics.nv)
        for link in range(kinematics.njoints):
            kinematics.inertias[link] = pin.Inertia.Zero()
        values = np.asarray(values, float)
        if values.shape != (len(self.parameters),):
            raise WrongShape(
                f"{self.robot.name}: values have shape {values.shape}, expected ({len(self.parameters)},), "
                "one a parameter of the model"
            )
        for effect, own in self.shares(values):
            bodies = effect.bodies(self.robot, own, payload)
            for link, body in bodies.items():
                kinematics.inertias[link + 1] += body
            if not bodies:
                others.append((effect, own))
        return kinematics, others

    def gear_torque(self, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
        """Torque of the joints beyond that of rigid gears, and how far motors lead their links, along a run.

        The load of the gears is nominal. Shapes (t, n) [N m] and (t, n) [rad].
        """
        torque, lead = np.zeros((2, *motion.position.shape))
        if not self.gears:
            return torque, lead
        load, step = self.gear_load(motion), float(np.median(np.diff(motion.time)))
        along = tangent(self.bodies_apart(self.nominal_values, motion.payload)[0], motion)
        for gear in self.gears:
            joint = self.robot.index(gear.joint)
            twist = gear.twist(along, load[:, joint], joint, step)
            torque -= along.torque(joint, *twist)
            lead[:, joint] += twist.value
        return torque, lead

    def motion_gradient(
        self, motion: Motion, weights: np.ndarray, known: np.ndarray | None = None
    ) -> MotionGradient:
        """Derivatives of sum(weights * regressor) + sum(known * known torque) by a loaded motion.

        It has the load that `loaded` gives it, so that what the load gains is passed on. Weights are (t, n,
        p); known is (t, n), or nothing.
        """
        known = np.zeros_like(motion.position) if known is None else known
        total = MotionGradient.none(motion.position.shape)
        for effect, own in zip(self.effects, self.columns, strict=True):
            total = total + effect.motion_gradient(self.robot, motion, weights[:, :, own], known)
        if not np.any(total.load):
            return total
        gears = self._transmitted
        by_load = gears.motion_gradient(motion, total.load[:, :, None] * gears.nominal_values, total.load)
        return replace(total, load=np.zeros_like(total.load)) + by_load

    @property
    def _transmitted(self) -> "Model":
        """The part of the model whose torque the gears transmit."""
        return replace(self, effects=tuple(e for e in self.effects if e.transmitted))

    def loaded(self, motion: Motion) -> Motion:
        """The motion with the nominal torque that gears transmit; unchanged if no effect needs it."""
        if not any(effect.needs_load for effect in self.effects):
            return motion
        return replace(motion, load=self.gear_load(motion))

    def gear_load(self, motion: Motion) -> np.ndarray:
        """Nominal torque that gears transmit, formed in pieces to spare memory, shape (t, n) [N m]."""
        part = self._transmitted
        values, starts = part.nominal_values, range(0, len(motion), CHUNK)
        return np.concatenate([part.torque(motion[start : start + CHUNK], values) for start in starts])
