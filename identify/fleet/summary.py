"""Summary: what one run says about its arm, without its samples. All later questions are small solves."""

from dataclasses import dataclass, replace

import numpy as np

from ..effects import Payload
from ..fit.equations import Equations, assemble
from ..fit.estimators.compressed import Compressed
from ..fit.estimators.maximum_likelihood import linearised
from ..fit.estimators.posterior import posterior, slowness
from ..fit.identification import solvable, with_payloads
from ..preparation.prepare import prepare
from ..recordings.recording import Recording
from ..recordings.recording_checks import check, check_alive
from .kind import Kind


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

        Torque is a product of gains and values: it is linearised about values (b,) and gains (n,).
        """
        compressed = Compressed(tuple(self.factors), self.counts)
        rows, right = linearised(compressed, values, 1.0 / gain, self.noise)
        rows[:, len(values) :] *= -1.0 / gain  # from inverse gains to logarithms of gains
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
    known = all(not e.parameters(model.robot) for e in model.effects if isinstance(e, Payload))
    equations = held(assemble(model, kind.base, [prepared]), kind, known)
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


def _square(factor: np.ndarray) -> np.ndarray:
    """A factor with as many rows as columns: a joint that hardly moved has fewer."""
    return np.pad(factor, ((0, factor.shape[1] - len(factor)), (0, 0)))
