"""Summary of one run without its samples, from which all later questions are small linear systems."""

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
from ..recordings.effort_checks import check_alive
from ..recordings.recording import Recording
from ..recordings.recording_checks import check
from .kind import Kind

SPANNED = 1e-9
"""Relative singular value of normalized columns below which columns are linearly dependent."""


@dataclass(frozen=True, eq=False)
class Summary:
    """Summary of one run.

    Attributes:
        factors: Triangular factor of each joint's rows of [regressor, known torque, current], shape
            (n, b + 2, b + 2); see `Compressed`.
        counts: Number of rows of each joint, shape (n,).
        noise: Standard deviation of white noise that gives the same uncertainty of values as the colored
            residual, shape (n,) [A] or [N m].
        residual: RMS residual, shape (n,) [N m].
        temperature: Mean temperature of the run, shape (n,) [degC]; NaN if it was not measured.
        payload: Name of the payload; empty for none.
        known: Whether the payload is completely known.
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

        Torque is a product of gains and values, so it is linearized about values (b,) and gains (n,). A
        payload that is not completely known is estimated with these first, because gains scale its torque
        too. Then everything that its ten parameters can explain is projected out, since it gives no
        information about the arm.
        """
        compressed, inverse = Compressed(tuple(self.factors), self.counts), 1.0 / gain
        rows, right = linearised(compressed, values, inverse, self.noise)
        if not self.known:
            of_payload = rows[:, : len(values)] @ kind.body
            change = np.linalg.lstsq(of_payload, right, rcond=None)[0]
            rows, right = linearised(compressed, values + kind.body @ change, inverse, self.noise)
            basis = _spanned(of_payload)
            rows, right = rows - basis @ (basis.T @ rows), right - basis @ (basis.T @ right)
        rows[:, len(values) :] *= -inverse  # from inverse gains to logarithms of gains
        reference = np.concatenate([values, np.log(gain / kind.gain)])
        normal = rows.T @ rows
        return normal, rows.T @ right + normal @ reference


def summarised(recording: Recording, kind: Kind) -> Summary:
    """Identify a run with the priors of its robot file, and reduce it to a summary.

    Raises:
        RecordingError: If the signals of the run are implausible.
        NotExcited: If there is no motion to identify from.
    """
    run = check_alive(check(recording))
    model = with_payloads(kind.model, [run])
    run = replace(run, model=model)
    prepared = prepare(run, kind.filtering)
    known = all(not payload.parameters(model.robot) for payload in model.payloads.values())
    equations = held(assemble(model, kind.base, [prepared]), kind, known)
    if not known:
        carrying = _carrying(model, kind, equations)
        equations = held(assemble(carrying, kind.base, [prepared]), kind, known)
    temperature = np.mean(prepared.motion.temperature, axis=0)
    return reduced(equations, temperature, prepared.motion.payload, known, recording.duration)


def reduced(
    equations: Equations, temperature: np.ndarray, payload: str, known: bool, seconds: float
) -> Summary:
    """Summary of a run's equations; the other arguments are attributes of the summary."""
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
    """Equations with the arm's nominal values as prior, except for a last link with an unknown payload."""
    model = kind.model
    tolerance = np.array([prior.std for prior in model.priors])
    if not known:
        tolerance[model.inertias[-1]] = np.inf
    return replace(equations, nominal=model.nominal_values, tolerance=tolerance)


def _carrying(model: Model, kind: Kind, equations: Equations) -> Model:
    """The model with the last link and its payload as estimated from the run, for the load of the gears."""
    standard = solvable(posterior)(equations).standard
    assert standard is not None  # that estimator provides them
    last = kind.model.inertias[-1]
    link = {name: Prior(value) for name, value in zip(kind.model.names[last], standard[last], strict=True)}
    return replace(model, stated={**model.stated, **link})


def _spanned(columns: np.ndarray) -> np.ndarray:
    """Orthonormal basis of the span of some columns."""
    size = np.linalg.norm(columns, axis=0)
    basis, values, _ = np.linalg.svd(columns / np.where(size > 0.0, size, 1.0), full_matrices=False)
    return basis[:, values > SPANNED * values[0]]


def _square(factor: np.ndarray) -> np.ndarray:
    """A factor padded to a square: a joint that hardly moved has fewer rows."""
    return np.pad(factor, ((0, factor.shape[1] - len(factor)), (0, 0)))
