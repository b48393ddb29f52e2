"""Summary: what one run says about its arm, without its samples. All later questions are small solves."""

from dataclasses import dataclass, replace

import numpy as np

from ..effects import Prior
from ..fit.equations import Equations, assemble
from ..fit.estimators.bayesian import posterior, slowness
from ..fit.estimators.compressed import Compressed
from ..fit.estimators.drive_gains import linearised
from ..fit.identification import solvable, with_payloads
from ..model import Model
from ..preparation.prepare import prepare
from ..recordings.recording import Recording
from ..recordings.recording_checks import check, check_alive
from .kind import Kind

SPANNED = 1e-9
"""Singular value, over the largest of columns of one length, below which a column is made up by others."""


@dataclass(frozen=True, eq=False)
class Summary:
    """One run.

    Attributes:
        factors: Triangular factor of each joint's rows of [regressor, known torque, current], shape
            (n, b + 2, b + 2); see `Compressed`.
        counts: Rows of each joint, shape (n,).
        noise: Standard deviation of the white noise that would leave values as uncertain as the coloured
            residual does, shape (n,) [A] or [N m].
        residual: Root mean square of the residual, shape (n,) [N m].
        temperature: Mean of the run, shape (n,) [degC]; NaN where it was not measured.
        payload: Name of the body carried; empty for none.
        known: Whether all of that body is known.
        seconds: Duration [s].
    """

    factors: np.ndarray
    counts: np.ndarray
    noise: np.ndarray
    residual: np.ndarray
    temperature: np.ndarray
    payload: str
    known: bool
    seconds: float

    def normal(self, kind: Kind, values: np.ndarray, gain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Normal matrix (m, m) and right-hand side (m,) of the unknowns of `Kind`.

        Torque is a product of gains and values: it is linearised about values (b,) and gains (n,). A body
        of which not all is known is found with these first, since gains scale its torque too; whatever its
        ten parameters could make up then says nothing of the arm.
        """
        compressed, inverse = Compressed(tuple(self.factors), self.counts), 1.0 / gain
        rows, right = linearised(compressed, values, inverse, self.noise)
        if not self.known:
            own = rows[:, : len(values)] @ kind.body
            change = np.linalg.lstsq(own, right, rcond=None)[0]
            rows, right = linearised(compressed, values + kind.body @ change, inverse, self.noise)
            taken = _spanned(own)
            rows, right = rows - taken @ (taken.T @ rows), right - taken @ (taken.T @ right)
        rows[:, len(values) :] *= -inverse  # from inverse gains to logarithms of gains
        reference = np.concatenate([values, np.log(gain / kind.gain)])
        normal = rows.T @ rows
        return normal, rows.T @ right + normal @ reference


def summarised(recording: Recording, kind: Kind) -> Summary:
    """Identify a run by what its robot file states, and keep what later questions need.

    Raises:
        RecordingError: A run that cannot be what it claims to be.
        NotExcited: No motion to identify from.
    """
    run = check_alive(check(recording))
    model = with_payloads(kind.model, [run])
    run = replace(run, model=model)
    prepared = prepare(run, kind.filtering)
    known = all(not body.parameters(model.robot) for body in model.payloads.values())
    equations = held(assemble(model, kind.base, [prepared]), kind, known)
    if not known:
        carrying = _carrying(model, kind, equations)
        equations = held(assemble(carrying, kind.base, [prepared]), kind, known)
    temperature = np.mean(prepared.motion.temperature, axis=0)
    return reduced(equations, temperature, prepared.motion.payload, known, recording.duration)


def reduced(
    equations: Equations, temperature: np.ndarray, payload: str, known: bool, seconds: float
) -> Summary:
    """Summary of a run's equations; see its attributes for the rest."""
    estimate = solvable(posterior)(equations)
    slow = slowness(equations, estimate.values, 1.0 / estimate.gain)
    compressed = Compressed.of(equations)
    return Summary(
        factors=np.stack([_square(factor) for factor in compressed.factors]),
        counts=compressed.counts,
        noise=slow * estimate.noise / np.abs(estimate.gain),
        residual=estimate.noise,
        temperature=temperature,
        payload=payload,
        known=known,
        seconds=seconds,
    )


def held(equations: Equations, kind: Kind, known: bool) -> Equations:
    """Equations with the nominal values of the arm alone; an unknown body makes the last link unknown."""
    model = kind.model
    tolerance = np.array([prior.std for prior in model.priors])
    if not known:
        tolerance[model.inertias[-1]] = np.inf
    return replace(equations, nominal=model.nominal_values, tolerance=tolerance)


def _carrying(model: Model, kind: Kind, equations: Equations) -> Model:
    """The model whose last link is what the run shows of it and its body, so that gears bear that load."""
    standard = solvable(posterior)(equations).standard
    assert standard is not None  # that estimator finds them
    last = kind.model.inertias[-1]
    link = {name: Prior(value) for name, value in zip(kind.model.names[last], standard[last], strict=True)}
    return replace(model, stated={**model.stated, **link})


def _spanned(columns: np.ndarray) -> np.ndarray:
    """Orthonormal columns that span these."""
    size = np.linalg.norm(columns, axis=0)
    left, values, _ = np.linalg.svd(columns / np.where(size > 0.0, size, 1.0), full_matrices=False)
    return left[:, values > SPANNED * values[0]]


def _square(factor: np.ndarray) -> np.ndarray:
    """A factor with as many rows as columns: a joint that hardly moved has fewer."""
    return np.pad(factor, ((0, factor.shape[1] - len(factor)), (0, 0)))
