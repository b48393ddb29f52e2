"""Model: a robot and the effects that make its torque."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import accumulate, pairwise

import numpy as np

from .arm.motion import Motion
from .arm.robot import Robot
from .effects import Effect, MotionGradient, Parameter, Prior
from .errors import RobotError

CHUNK = 2000
"""Samples whose full-rate regressor is held at once; a few megabytes stay in the cache."""


@dataclass(frozen=True)
class Model:
    """Joint torque = sum over effects of regressor @ parameters + known torque.

    Attributes:
        robot: Kinematics, limits and drives.
        effects: What makes torque; order is the order of the columns.
        stated: Priors about parameters by name, beyond the robot's inertias.
        bounded: Names of those that are certain to be within the square root of three deviations.
    """

    robot: Robot
    effects: tuple[Effect, ...]
    stated: Mapping[str, Prior] = field(default_factory=dict)
    bounded: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        names = [parameter.name for parameter in self.parameters]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise RobotError(f"{self.robot.name}: parameters named twice: {', '.join(twice)}")

    def __add__(self, effect: Effect) -> "Model":
        return replace(self, effects=(*self.effects, effect))

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
        gears = self._gears
        by_load = gears.motion_gradient(motion, total.load[:, :, None] * gears.nominal_values, total.load)
        return replace(total, load=np.zeros_like(total.load)) + by_load

    @property
    def _gears(self) -> "Model":
        """The part of the model whose torque the gears transmit."""
        return replace(self, effects=tuple(e for e in self.effects if e.transmitted))

    def loaded(self, motion: Motion) -> Motion:
        """The motion with the nominal torque that gears transmit; unchanged if no effect needs it."""
        if not any(effect.needs_load for effect in self.effects):
            return motion
        gears = self._gears
        return replace(motion, load=gears.torque(motion, gears.nominal_values))
