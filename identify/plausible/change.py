"""Correction of a mistake in a log: what its columns mean, in place of what they were taken for."""

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from ..arm.motion import Motion
from ..model import Model
from .samples import Sampled, sliding


@dataclass(frozen=True)
class Change:
    """Correction of a log; corrections of one log follow each other by `then`."""

    position: np.ndarray | None = None  # true positions per recorded one, shape (n, n); None if right
    zero: np.ndarray | None = None  # offset added to these positions, shape (n,) [rad, m]
    effort: np.ndarray | None = None  # true efforts per recorded one, shape (n, n); None if right
    gravity: np.ndarray | None = None  # gravity in the base frame, shape (3,) [m/s^2]; None if as described
    coupling: np.ndarray | None = None  # motor angles per joint angle, shape (n, n); None if as described
    # Delay of the efforts at the first sample [s], and its increase [s/s].
    late: tuple[float, float] | None = None

    @property
    def of_motion(self) -> bool:
        """Whether the arm or its motion changes, not only the efforts."""
        parts = (self.position, self.zero, self.gravity, self.coupling)
        return any(part is not None for part in parts)

    @property
    def factor(self) -> np.ndarray | None:
        """Factors of the efforts, shape (n,), if only their sizes and signs change; else None."""
        if self.of_motion or self.late is not None or self.effort is None:
            return None
        diagonal = np.diag(self.effort)
        return diagonal if np.array_equal(self.effort, np.diag(diagonal)) else None

    def then(self, other: "Change") -> "Change":
        """This correction, and another one of the log that it makes."""
        position, zero = self.position, self.zero
        if other.position is not None:
            position = other.position if position is None else other.position @ position
            zero = None if zero is None else other.position @ zero
        if other.zero is not None:
            zero = other.zero if zero is None else zero + other.zero
        effort = self.effort
        if other.effort is not None:
            effort = other.effort if effort is None else other.effort @ effort
        gravity = self.gravity if other.gravity is None else other.gravity
        coupling = self.coupling if other.coupling is None else other.coupling
        return Change(position, zero, effort, gravity, coupling, other.late or self.late)

    def model(self, model: Model) -> Model:
        """The model of the arm with the correct gravity and coupling of motors."""
        if self.coupling is not None:
            model = replace(model, robot=replace(model.robot, coupling=self.coupling))
        return model if self.gravity is None else with_gravity(model, self.gravity)

    def log(self, log: Sampled) -> Sampled:
        """The log with the correction applied."""
        if self.position is not None or self.zero is not None:
            log = self._moved(log)
        if self.late is not None:
            time = log.motion.time
            later = time + self.late[0] + self.late[1] * (time - time[0])
            effort = np.stack([np.interp(later, time, column) for column in log.effort.T], axis=1)
            log = log._replace(effort=effort)
        return log if self.effort is None else log._replace(effort=log.effort @ self.effort.T)

    def _moved(self, log: Sampled) -> Sampled:
        matrix = np.eye(log.effort.shape[1]) if self.position is None else self.position
        old = log.motion
        position = old.position @ matrix.T + (0.0 if self.zero is None else self.zero)
        motion = Motion.of(old.time, position, old.velocity @ matrix.T, old.acceleration @ matrix.T)
        moving = np.abs(matrix) @ log.moving > 0.0
        return Sampled(motion, log.effort, sliding(motion.velocity) & moving)


def scaled(factor: np.ndarray) -> np.ndarray:
    """Matrix of factors (n,) of the joints, shape (n, n)."""
    return np.diag(np.asarray(factor, float))


def with_gravity(model: Model, gravity: np.ndarray) -> Model:
    """Copy of a model with another gravity in its base frame, shape (3,) [m/s^2]."""
    kinematics = model.robot.kinematics.copy()
    kinematics.gravity = pin.Motion(np.asarray(gravity, float), np.zeros(3))
    return replace(model, robot=replace(model.robot, kinematics=kinematics))
