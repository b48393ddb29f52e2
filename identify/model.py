"""Model: a robot, the effects that produce its torque, and the measurements that shape its recordings."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import accumulate, pairwise

import numpy as np
import pinocchio as pin

from .arm.motion import Motion, tangent
from .arm.robot import Robot
from .effects import Effect, MotionGradient, Parameter, Prior
from .effects.rigid_body import usual_body
from .errors import RobotError, WrongShape
from .measurements import Gear, Measurement
from .notebook import InNotebook

CHUNK = 2000
"""Samples per piece of a full-rate regressor; a few megabytes fit into the cache."""


@dataclass(frozen=True, repr=False)
class Model(InNotebook):
    """Joint torque = sum over effects of regressor @ parameters + known torque."""

    robot: Robot  # kinematics, limits and drives
    effects: tuple[Effect, ...]  # contributions to the torque, in the order of the regressor's columns
    # Priors of parameters by name, beyond the robot's inertias.
    stated: Mapping[str, Prior] = field(default_factory=dict)
    bounded: frozenset[str] = frozenset()  # parameters certain to lie within sqrt(3) standard deviations
    # Reasons why a recording differs from the motion and torque of rigid joints: delays, compliant gears,
    # clipped currents. A fit removes them from recordings, and a simulation adds them.
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
        """Return the model with other nominal values and unchanged standard deviations.

        Example:
            >>> robot("kr270").with_values(Fv2=30.0)

        Raises:
            RobotError: There is no such parameter; the message lists the valid parameters.
        """
        priors = dict(zip(self.names, self.priors, strict=True))
        if unknown := [name for name in values if name not in priors]:
            raise RobotError(
                f"{self.robot.name} has no parameter {', '.join(unknown)}. Valid: {', '.join(priors)}"
            )
        changed = {name: Prior(float(value), priors[name].std) for name, value in values.items()}
        return replace(self, stated={**self.stated, **changed})

    def at(self, values: np.ndarray) -> "Model":
        """Model with nominal values (p,) and unchanged standard deviations."""
        priors = zip(self.names, values, self.priors, strict=True)
        return replace(self, stated={name: Prior(float(value), prior.std) for name, value, prior in priors})

    @property
    def parameters(self) -> list[Parameter]:
        """Linear parameters of all effects, one per column."""
        return [parameter for effect in self.effects for parameter in effect.parameters(self.robot)]

    @property
    def names(self) -> list[str]:
        """Names of the parameters, one per column."""
        return [parameter.name for parameter in self.parameters]

    @property
    def priors(self) -> list[Prior]:
        """Prior of each parameter; without one, the value is zero and the standard deviation infinite."""
        known = {n: b for effect in self.effects for n, b in effect.priors(self.robot).items()}
        known |= self.stated
        return [known.get(name, Prior(0.0)) for name in self.names]

    @property
    def nominal_values(self) -> np.ndarray:
        """Nominal value of each parameter, shape (p,)."""
        return np.array([prior.value for prior in self.priors])

    @property
    def prior_values(self) -> np.ndarray:
        """Nominal values, those of usual bodies in place of missing or implausible ones, shape (p,)."""
        values = self.nominal_values
        for effect, columns in zip(self.effects, self.columns, strict=True):
            if effect.of_links and not self.robot.body_units.informative:
                values[columns] = np.tile(usual_body(self.robot), self.robot.dof)
        return values

    @property
    def inertias(self) -> list[slice]:
        """Columns of the ten parameters of each rigid body."""
        return [
            slice(columns.start + body.start, columns.start + body.stop)
            for effect, columns in zip(self.effects, self.columns, strict=True)
            for body in effect.inertias(self.robot)
        ]

    @property
    def columns(self) -> list[slice]:
        """Columns of each effect."""
        counts = (len(effect.parameters(self.robot)) for effect in self.effects)
        return [slice(*ends) for ends in pairwise(accumulate(counts, initial=0))]

    @property
    def payloads(self) -> dict[str, Effect]:
        """Payloads that runs may carry on the flange, by name."""
        return {effect.payload: effect for effect in self.effects if effect.payload}

    @property
    def delay(self) -> np.ndarray:
        """Delay of each joint's recorded effort behind its position, shape (n,) [s]."""
        return sum(
            (measurement.delay(self.robot) for measurement in self.measurements), np.zeros(self.robot.dof)
        )

    @property
    def current_limit(self) -> np.ndarray:
        """Largest effort that is recorded of each joint, infinite without a limit, shape (n,) [A, N m]."""
        return np.min(
            [np.full(self.robot.dof, np.inf), *(m.current_limit(self.robot) for m in self.measurements)], 0
        )

    def recorded(self, torque: np.ndarray) -> np.ndarray:
        """Drive gains times the currents that are recorded at motor torques (..., n), same shape [N m]."""
        for measurement in self.measurements:
            torque = measurement.recorded(self.robot, torque)
        return torque

    def restored(self, torque: np.ndarray) -> np.ndarray:
        """Motor torques from drive gains times recorded currents (t, n), same shape [N m]."""
        for measurement in reversed(self.measurements):
            torque = measurement.restored(self.robot, torque)
        return torque

    @property
    def gears(self) -> tuple[Gear, ...]:
        """Gears that are not rigid."""
        return tuple(part for part in self.measurements if isinstance(part, Gear))

    def shares(self, values: np.ndarray) -> list[tuple[Effect, np.ndarray]]:
        """Each effect with its values, out of the values (p,) of all parameters."""
        return [(effect, values[columns]) for effect, columns in zip(self.effects, self.columns, strict=True)]

    def regressor(self, motion: Motion) -> np.ndarray:
        """Torque per unit of each parameter, shape (t, n, p) [N m / unit]."""
        return self._stacked(motion, [effect.regressor(self.robot, motion) for effect in self.effects])

    def pieces(
        self, motion: Motion, loading: "Model | None" = None
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Regressor (t, n, p) and known torque (t, n) of a run, in pieces to save memory.

        Effects with memory, such as hysteresis, are evaluated over the entire run. The load on the gears is
        taken from `loading`, by default from this model.
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
        """Torque that depends on no parameter (a known payload), shape (t, n) [N m]."""
        return sum((e.known_torque(self.robot, motion) for e in self.effects), np.zeros_like(motion.position))

    def torque(self, motion: Motion, values: np.ndarray) -> np.ndarray:
        """Joint torque for given parameter values (p,), shape (t, n) [N m]."""
        return self.regressor(motion) @ values + self.known_torque(motion)

    def bodies_apart(
        self, values: np.ndarray, payload: str
    ) -> tuple[pin.Model, list[tuple[Effect, np.ndarray]]]:
        """Kinematics with the rigid bodies of parameters (p,), and the other effects with their values.

        Raises:
            WrongShape: The number of values is not the number of parameters.
        """
        kinematics, others = self.robot.kinematics.copy(), []
        kinematics.armature = np.zeros(kinematics.nv)
        for link in range(kinematics.njoints):
            kinematics.inertias[link] = pin.Inertia.Zero()
        values = np.asarray(values, float)
        if values.shape != (len(self.parameters),):
            raise WrongShape(
                f"{self.robot.name}: values have shape {values.shape}, expected ({len(self.parameters)},), "
                "one per parameter of the model"
            )
        for effect, share in self.shares(values):
            bodies = effect.bodies(self.robot, share, payload)
            for link, body in bodies.items():
                kinematics.inertias[link + 1] += body
            if not bodies:
                others.append((effect, share))
        return kinematics, others

    def gear_torque(self, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
        """Additional joint torque due to compliant gears, and lead of the motors over the links, along a run.

        The load of the gears is nominal. Both have shape (t, n), in [N m] and [rad].
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
        """Derivatives of sum(weights * regressor) + sum(known * known torque) with respect to the motion.

        The motion has the load that `loaded` computes; derivatives with respect to the load are propagated
        to the motion. Weights have shape (t, n, p); `known` has shape (t, n), or is None for zeros.
        """
        known = np.zeros_like(motion.position) if known is None else known
        total = MotionGradient.none(motion.position.shape)
        for effect, columns in zip(self.effects, self.columns, strict=True):
            total = total + effect.motion_gradient(self.robot, motion, weights[:, :, columns], known)
        if not np.any(total.load):
            return total
        gears = self._transmitted
        by_load = gears.motion_gradient(motion, total.load[:, :, None] * gears.nominal_values, total.load)
        return replace(total, load=np.zeros_like(total.load)) + by_load

    @property
    def _transmitted(self) -> "Model":
        """Model of the effects whose torque the gears transmit."""
        return replace(self, effects=tuple(e for e in self.effects if e.transmitted))

    def loaded(self, motion: Motion) -> Motion:
        """Motion with the nominal torque that the gears transmit; unchanged if no effect needs it."""
        if not any(effect.needs_load for effect in self.effects):
            return motion
        return replace(motion, load=self.gear_load(motion))

    def gear_load(self, motion: Motion) -> np.ndarray:
        """Nominal torque that the gears transmit, computed in pieces to save memory, shape (t, n) [N m]."""
        part = self._transmitted
        values, starts = part.nominal_values, range(0, len(motion), CHUNK)
        return np.concatenate([part.torque(motion[start : start + CHUNK], values) for start in starts])
