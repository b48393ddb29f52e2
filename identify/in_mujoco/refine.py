"""Joint numbers of a file, refined so that its own simulation follows recordings: no effects beside the file.

A file that lacks an effect simulates best with other numbers than those that the effect leaves in a fit to
torque. Armature, damping and dry friction of all joints are fitted to the positions of short simulations
from recorded states, by Gauss-Newton steps with finite differences. A number keeps its value in the file
unless that costs accuracy.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from ..export.mjcf_changes import DIGITS, TERMS, Change
from ..export.xml_text import Edits, Elements, read_tags
from ..fit.needed_changes import with_needed_changes
from ..robot_files.mjcf import compile_mjcf
from ..text_table import NORMAL_95
from .trial import Trial
from .windows import errors, windows

STEPS = 6
"""Maximum number of Gauss-Newton steps."""
ENOUGH = 0.01
"""Relative decrease of the rms error below which no further step is made."""
DIFFERENCE = 0.05
"""Step of a finite difference, relative to the scale of a number."""
RIDGE = 0.01
"""Share of the initial squared error that a change by the scale of a number costs: numbers that the
simulation does not show stay as they are."""
FARTHEST = 0.005
"""Largest change of a delay by simulation [s]: two periods of usual logs."""
TRIES = 4
"""Maximum number of step sizes in one direction."""
FIELDS = {"armature": "dof_armature", "damping": "dof_damping", "dry": "dof_frictionloss"}
"""Term of a joint -> field of the compiled model."""


@dataclass
class Refinement:
    """Joint numbers of a file, fitted to runs in simulation."""

    trial: Trial  # the file, and the runs to which the numbers are fitted
    text: bytes  # text of the version of the file that is refined
    start: np.ndarray  # armature, damping and dry friction with which the fit starts, shape (3, n)
    std: np.ndarray  # standard deviations of the start, shape (3, n); infinite where only the file states it
    scale: np.ndarray  # size of each number, shape (3, n): a change of this size shows in the simulation

    def __post_init__(self) -> None:
        self.simulator = self.trial.simulator(self.text)
        joints = self.trial.model.robot.joints
        self.dofs = dofs_of(self.simulator.model, joints)
        self.windows = windows(self.trial.runs)
        source = self.trial.source
        self.old = joint_numbers(compile_mjcf(source.text.decode(), source.folder), joints)

    def refined(self) -> tuple[bytes, tuple[Change, ...]]:
        """The text with refined numbers, and what they change in the file."""
        first = self._residual(self.start)
        if not np.all(np.isfinite(first)):
            return self.text, ()
        values, jacobian = self._optimum(self.start, first, np.ones(self.start.shape, bool))
        residual = self._residual(values)
        needed, halves = self._needed(values, jacobian, residual)
        needed, _ = self._optimum(needed, self._residual(needed), needed != self.old)
        return self._written(needed, halves)

    def delay_shift(self) -> float:
        """Change of all delays that brings the simulation with the start nearest to the runs [s]."""
        delay = self.simulator.delay

        def error(shift: float) -> float:
            self.simulator.delay = np.maximum(delay + shift, 0.0)
            return float(np.linalg.norm(self._residual(self.start)))

        best = minimize_scalar(error, bounds=(-FARTHEST, FARTHEST), options={"xatol": 5e-5})
        return float(best.x) if best.fun < error(0.0) else 0.0

    def _optimum(
        self, values: np.ndarray, residual: np.ndarray, free: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the least squared error, of which some are free (3, n), and the last Jacobian."""
        damping = 1e-3
        for _ in range(STEPS):
            jacobian, before = self._jacobian(values, residual, free), residual
            information, prior = jacobian.T @ jacobian, np.diag(self._prior(residual))
            moved = ((values - self.start) / self.scale).ravel()
            for _ in range(TRIES):
                matrix = information + prior + damping * np.diag(np.diag(information))
                step = -np.linalg.solve(matrix, jacobian.T @ residual + prior @ moved) * free.ravel()
                new = np.maximum(values + step.reshape(values.shape) * self.scale, 0.0)
                now = self._residual(new)
                if np.all(np.isfinite(now)) and now @ now < residual @ residual:
                    values, residual, damping = new, now, damping / 3.0
                    break
                damping *= 10.0
            if np.linalg.norm(residual) > (1.0 - ENOUGH) * np.linalg.norm(before):
                break
        return values, jacobian

    def _prior(self, residual: np.ndarray) -> np.ndarray:
        """Information about the start in units of the residual and of the scales, shape (3 n,)."""
        squares = float(residual @ residual)
        return np.asarray((RIDGE + (self.scale / self.std) ** 2 / len(self.windows)).ravel() * squares)

    def _needed(
        self, values: np.ndarray, jacobian: np.ndarray, residual: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Values with insignificant changes of the file undone, and halves of their 95 % intervals, (3, n).

        The error of a window counts as one sample, since errors within a window are correlated.
        """
        variance = float(residual @ residual) / len(self.windows)
        precision = (jacobian.T @ jacobian + np.diag(self._prior(residual))) / variance
        scale = self.scale.ravel()
        covariance = np.linalg.inv(precision) * np.outer(scale, scale)
        covariance[: self.scale.shape[1], : self.scale.shape[1]] += np.diag(self.trial.numerical_inertia**2)
        groups = [np.array([place]) for place in range(len(scale))]
        needed, covariance = with_needed_changes(values.ravel(), covariance, self.old.ravel(), groups)
        halves = NORMAL_95 * np.sqrt(np.maximum(np.diag(covariance), 0.0))
        return np.maximum(needed, 0.0).reshape(values.shape), halves.reshape(values.shape)

    def _jacobian(self, values: np.ndarray, residual: np.ndarray, free: np.ndarray) -> np.ndarray:
        """Derivative of the residual by the numbers over their scales, shape (r, 3 n); zero if not free."""
        columns = []
        for place in np.ndindex(values.shape):
            if not free[place]:
                columns.append(np.zeros(len(residual)))
                continue
            moved = values.copy()
            moved[place] += DIFFERENCE * self.scale[place]
            change = (self._residual(moved) - residual) / DIFFERENCE
            columns.append(change if np.all(np.isfinite(change)) else np.zeros(len(residual)))
        return np.stack(columns, axis=1)

    def _residual(self, values: np.ndarray) -> np.ndarray:
        """Simulated minus recorded positions over the motion of the joints, shape (r,)."""
        for name, numbers in zip(FIELDS.values(), values, strict=True):
            getattr(self.simulator.model, name)[self.dofs] = numbers
        self.simulator.renew()
        return errors(self.windows, self.simulator.roll_all(self.windows))

    def _written(self, values: np.ndarray, halves: np.ndarray) -> tuple[bytes, tuple[Change, ...]]:
        source, robot = self.trial.source, self.trial.model.robot
        compiled = compile_mjcf(self.text.decode(), source.folder)
        elements, edits = (
            Elements(read_tags(self.text, source.where), compiled, source.where),
            Edits(self.text),
        )
        present, changes = joint_numbers(compiled, robot.joints), []
        for row, place in np.ndindex(values.shape):
            attribute, unit = TERMS[list(FIELDS)[row]]
            name, new, old = robot.joints[place], float(values[row, place]), float(self.old[row, place])
            if new != present[row, place]:
                tag = elements.joint(int(compiled.joint(name).id))
                edits.set(tag, **{attribute: f"{new:.{DIGITS}g}"})
            if new != old:
                half = float(halves[row, place])
                changes.append(Change(f"joint '{name}'", attribute, robot.unit(place, unit), old, new, half))
        return edits.text(), tuple(changes)


def dofs_of(compiled: Any, joints: Sequence[str]) -> list[int]:
    """Index of the degree of freedom of each joint."""
    return [int(compiled.joint(name).dofadr[0]) for name in joints]


def joint_numbers(compiled: Any, joints: Sequence[str]) -> np.ndarray:
    """Armature, damping and dry friction of joints in a compiled model, shape (3, n)."""
    dofs = dofs_of(compiled, joints)
    return np.array([getattr(compiled, name)[dofs] for name in FIELDS.values()])
