"""Detection of runs with an unstated payload, or with a payload that contradicts what is stated.

The bodies of the arm are free and common to all runs; the payload is the additional body that one run needs.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..arm.rigid_regressor import INERTIAL, body_regressor
from ..model import Model
from ..recordings.recording import Recording
from ..text_table import NORMAL_95, digits
from .evidence import RESOLVED
from .samples import Sampled, joined, sampled_torques
from .shares import EXACT, Columns, Fit
from .suspicion import Suspicion

MOST = 400
"""Maximum number of samples of a run."""
PRIOR = 0.01
"""Prior probability that a run carries an unstated payload."""
SURE = 5.0
"""Minimum mass in standard deviations: friction that changes between runs looks like a small payload."""
FEW = 6
"""Largest number of runs for which each is tested; with more runs, the diagnosis compares them."""
SCALE, RULER = 0.02, 0.005
"""Relative error of a weighed mass, and error of a measured center [m]."""
DIFFERS = 5.0
"""A stated number is contradicted if the estimate differs by this many standard deviations. Chance does not
cause that, but friction missing from the model can move an estimate by some of them."""
MASS, MOMENTS = INERTIAL.index("M"), [INERTIAL.index(name) for name in ("MX", "MY", "MZ")]
HELD_BACK = 1e-7
"""Ridge parameter, noise variance over column variance: values that no data distinguish stay small."""


class FlangeBody(NamedTuple):
    """A body on the flange."""

    gain: float  # increase in log-likelihood of the run compared with no payload
    mass: float  # mass [kg]
    mass_std: float  # standard deviation of the mass [kg]
    center: np.ndarray  # center of mass in the flange frame, shape (3,) [m]
    center_std: np.ndarray  # standard deviation of the center of mass, shape (3,) [m]


def flange_body(model: Model, logs: Sequence[Sampled], loaded: int) -> FlangeBody:
    """Payload that run `loaded` carries in addition to what all runs carry; efforts are torques."""
    log = joined(logs)
    begin = sum(len(other.effort) for other in logs[:loaded])
    rows = slice(begin, begin + len(logs[loaded].effort))
    body = np.zeros((*log.effort.shape, len(INERTIAL)))
    body[rows] = body_regressor(model.robot.kinematics, log.motion[rows], model.robot.flange)
    columns = Columns.of(model, log, body)
    fits = [each.fit(log.effort, alone=False) for each in (Columns.of(model, log), columns)]
    losses = [np.log(fit.share(fit.together) + RESOLVED) for fit in fits]
    gain = float(0.5 * log.pieces @ (losses[0] - losses[1]))
    values, covariance = _fitted(columns, log, fits[1])
    mass, moments = values[MASS], values[MOMENTS]
    if mass == 0.0:  # the motion does not reveal a mass
        return FlangeBody(gain, 0.0, np.inf, np.zeros(3), np.full(3, np.inf))
    slope = np.zeros((3, len(values)))
    slope[range(3), MOMENTS], slope[:, MASS] = 1.0 / mass, -moments / mass**2
    center_std = np.sqrt(np.einsum("ap,pq,aq->a", slope, covariance, slope))
    mass_std = float(np.sqrt(covariance[MASS, MASS]))
    return FlangeBody(gain, float(mass), mass_std, moments / mass, center_std)


def _fitted(columns: Columns, log: Sampled, fit: Fit) -> tuple[np.ndarray, np.ndarray]:
    """Parameters of the payload and their covariance, by least squares over all joints."""
    known = fit.variance > 0.0  # a constant effort was not measured
    level = (fit.together + EXACT * fit.variance) / np.maximum(columns.sliding.sum(axis=0), 1)
    weight = np.divide(1.0, level, out=np.zeros_like(level), where=known)
    matrix, right = columns.normal_equations(log.effort, weight)
    inverse = np.linalg.inv(matrix + np.diag(HELD_BACK * np.diag(matrix) + (np.diag(matrix) == 0.0)))
    solution = inverse @ right
    power = float(weight @ ((log.effort * columns.sliding) ** 2).sum(axis=0))
    # The number of independent samples determines the variance.
    variance = (power - float(right @ solution)) / max(float(log.pieces.sum()), 1.0)
    body, scale = slice(len(INERTIAL)), columns.scale[: len(INERTIAL)]
    return solution[body] / scale, variance * inverse[body, body] / np.outer(scale, scale)


def body_suspicions(runs: Sequence[Recording], model: Model) -> Iterator[tuple[Recording, Suspicion]]:
    """Runs with an unstated payload, or one that contradicts what is stated, if torques are known."""
    if len(runs) < 2:
        return
    usable, logs, stated = sampled_torques(runs, model.robot)
    if not stated or len(usable) < 2:
        return
    logs = [log.thinned(MOST) for log in logs]
    bare = [place for place, run in enumerate(usable) if run.payload is None]
    for place, run in enumerate(usable):
        if run.payload is not None and bare:
            body = flange_body(model, [*(logs[k] for k in bare), logs[place]], len(bare))
            known = dict(run.payload.known)
            if words := _contradicted(body, known):
                yield (
                    run,
                    Suspicion(
                        "payload", (), words, "correct --mass or --com; exidyn payload identifies both", None
                    ),
                )
    if len(bare) > 1 and len(bare) <= FEW:
        yield from _unstated([usable[k] for k in bare], [logs[k] for k in bare], model)


def _unstated(
    runs: Sequence[Recording], logs: Sequence[Sampled], model: Model
) -> Iterator[tuple[Recording, Suspicion]]:
    bodies = [flange_body(model, logs, place) for place in range(len(runs))]
    real = [k for k, body in enumerate(bodies) if body.mass > SURE * body.mass_std]
    if not real:
        return
    best = max(real, key=lambda k: bodies[k].gain)
    odds = bodies[best].gain + np.log(PRIOR)
    if odds > 0:
        others = "the other runs do" if len(runs) > 2 else f"{runs[1 - best].name} does"
        words = f"it carries a body on the flange that {others} not: {body_words(bodies[best])}"
        probability = float(1.0 / (1.0 + np.exp(-min(odds, 99.0))))
        cure = (
            f"give it as --payload {runs[best].name}.mcap, and --mass KG if the body was weighed; exidyn "
            "payload identifies it"
        )
        yield runs[best], Suspicion("payload", (), words, cure, min(probability, 0.95))


def body_words(body: FlangeBody) -> str:
    """Words for mass and center of a body."""
    center = ", ".join(f"{1e3 * value:.0f}" for value in body.center + 0.0)
    spread = 1e3 * NORMAL_95 * float(body.center_std.max())
    mass = f"{digits(body.mass, 3)} ± {digits(NORMAL_95 * body.mass_std, 1)} kg"
    return f"{mass}, its center of mass at ({center}) ± {digits(spread, 1)} mm"


def _contradicted(body: FlangeBody, known: Mapping[str, float]) -> str:
    """Words on how the runs contradict a stated payload; empty if they do not."""
    mass = known.get("M")
    if mass is None:
        return ""
    heavier = abs(body.mass - mass) > DIFFERS * np.hypot(body.mass_std, SCALE * mass)
    center = np.array([known.get(name, np.nan) for name in ("MX", "MY", "MZ")]) / mass
    away = np.abs(body.center - center) > DIFFERS * np.hypot(body.center_std, RULER)
    if not heavier and not away.any():
        return ""
    stated = f"{digits(mass, 3)} kg"
    if np.isfinite(center).all():
        stated += f" at ({', '.join(f'{1e3 * value + 0.0:.0f}' for value in center)}) mm"
    return f"according to the runs, it carries {body_words(body)}; stated is {stated}"
