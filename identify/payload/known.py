"""What is known of the arm before the run with the payload: base parameters and drive gains.

Three sources: a fit of the arm; a robot description, whose links and gains have tolerances; and the same
description beside a run without the payload, which the equations contain. The first comes with the covariance
of the fit, including that of the gains, so that an uncertain gain makes the mass equally uncertain.
"""

from dataclasses import dataclass

import numpy as np

from ..arm.rigid_regressor import INERTIAL
from ..errors import FitError
from ..fit.estimators.least_squares import gain_deviation, prior
from ..fit.fit import Fit
from ..fit.settled_gains import settled
from ..model import Model
from ..positive_definite import root
from .body import MASS, MOMENTS
from .rows import Rows

FRICTION_CHANGES = 0.3
"""Standard deviation of the relative change of friction between two runs [-]. Viscous friction of harmonic
drives falls by half between a cold and a warm arm."""
OFFSET_CHANGES = 0.02
"""Standard deviation of the change of current offsets between two runs, over the joint's rms torque [-]: the
linearity of current sensors is 3 %."""
BARE = 0.4
"""Relative standard deviation of the inertias of a description that states none [-], such as a bare URDF.
With that of a UR10e, the empty arm appears to carry 1.0 kg; those of other arms have links that are wrong by
more."""
RULER = 0.002
"""Standard deviation of a stated center of mass [m]: it was measured with a ruler or is drawn."""
GAIN_CHANGES = 0.015
"""Standard deviation of the relative change of drive gains between a fit and a run [-]. The remanence of
NdFeB magnets falls by 0.11 % per kelvin, so that 10 to 20 K between a cold and a warm arm are 1 to 2 %."""
ALIKE = 0.5
"""Correlation between the errors of two nominal gains, and of two links. Gains of one source share errors,
such as a wrong torque constant or rms amperes for peak amperes: those published for a UR10e are 1 to 20 % too
high, all six. Errors that were independent would average out in the mass."""


@dataclass(frozen=True, eq=False)
class Known:
    """Prior of all unknowns: mean, and a root of the covariance."""

    mean: np.ndarray  # base parameters of the arm, payload, changes, relative errors of the gains, shape (k,)
    root: np.ndarray  # matrix R with covariance R R^T, shape (k, k)
    scaled: bool  # whether errors of the arm scale with the gains; those of a fit depend on them already


def known_from_fit(fit: Fit, rows: Rows) -> tuple[np.ndarray, np.ndarray]:
    """Mean (b + n,) and covariance (b + n, b + n) of base parameters and relative errors of gains.

    Raises:
        FitError: Drive gains are unknown.
    """
    if fit.unscaled:
        raise FitError(
            f"{fit.model.robot.name}: the fit has no drive gains, so masses are not in kilograms. State them "
            "in the robot file, or identify them with a payload that was weighed, then fit again"
        )
    gains, base = settled(fit), fit.structure or fit.base
    named = dict(zip(base.kept, base.names, strict=True))
    places = [base.names.index(named[column]) for column in fit.base.kept]
    count, arm, n = len(base.kept), rows.arm, len(gains.gain)
    mean, slope = np.zeros(arm + n), np.zeros((arm, n))
    covariance = np.zeros((arm + n, arm + n))
    mean[places], slope[places] = gains.values, gains.by_gain
    covariance[np.ix_(places, places)] = gains.conditional
    # A parameter that was dropped is zero to within the value that it had.
    for place, name in enumerate(base.names):
        covariance[place, place] += fit.dropped.get(name, 0.0) ** 2
    nominal = prior(rows.equations)
    new = np.arange(count, arm)  # friction under load, which the fit does not have
    friction = np.diag(nominal[1])[new]
    mean[new], covariance[new, new] = nominal[0][new], friction
    if len(new) and fit.gear_friction_bias is not None:
        # True minus fitted unknowns per friction that the fit lacked.
        towards = np.zeros((arm + n, n))
        bias = fit.gear_friction_bias[: len(places)]
        towards[places], towards[new, np.arange(n)] = -bias, 1.0
        towards[arm:] = fit.gear_friction_bias[len(places) :] / gains.gain[:, None]
        # From the second pass on, the nominal value is the estimate of the pass before; the fit, which the
        # other unknowns come from, is unbiased at zero friction.
        mean[new], covariance[new, new] = 0.0, 0.0
        covariance += (towards * friction) @ towards.T
    if fit.measures == "current":
        scale = -gains.gain  # change of the gain per relative error of the torque
        spread = np.concatenate([slope * scale, np.eye(n)])
        relative = gains.gain_covariance / np.outer(scale, scale)
        if fit.estimate.nominal_gains:
            relative = alike(np.sqrt(np.diag(relative)))
        covariance += spread @ relative @ spread.T
        # The arm stays what it is while gains change, so that its torque shows the change.
        covariance[arm:, arm:] += alike(np.full(n, GAIN_CHANGES))
    return mean, covariance


def known_from_description(model: Model, rows: Rows) -> tuple[np.ndarray, np.ndarray]:
    """Mean (b + n,) and covariance (b + n, b + n) from the tolerances of a robot description.

    Errors of the links have a common part, as those of the gains have: a description without motors or cables
    has links that are all too light. Inertias that were identified with the nominal gains are wrong by as
    much as these: they do not determine the gains. So their tolerance includes that of the gains.
    """
    equations, arm = rows.equations, rows.arm
    mean, covariance = prior(equations)
    deviation = gain_deviation(equations) / np.abs(equations.gain)
    n = len(deviation)
    full = np.zeros((arm + n, arm + n))
    full[:arm, :arm] = covariance[:arm, :arm]
    full[arm:, arm:] = alike(deviation)
    links = _torque_of_links(model, rows)
    common = np.concatenate([links, np.zeros(n)]) * model.robot.inertial_tolerance * np.sqrt(ALIKE)
    full += np.outer(common, common)
    if model.robot.inertias_by_gain and np.any(deviation):
        shift = np.concatenate([links, np.full(n, -1.0)]) * float(np.max(deviation))
        full += np.outer(shift, shift)
    return np.concatenate([mean[:arm], np.zeros(n)]), full


def _torque_of_links(model: Model, rows: Rows) -> np.ndarray:
    """Nominal base parameters of the arm (b,) that its links cause, without rotors and friction."""
    links = np.zeros(len(model.names))
    for effect, columns in zip(model.effects, model.columns, strict=True):
        if effect.of_links:
            links[columns] = model.nominal_values[columns]
    return np.asarray((rows.equations.base.regrouping @ links)[: rows.arm])


def alike(deviation: np.ndarray) -> np.ndarray:
    """Covariance (n, n) of nominal gains from their standard deviations (n,); see `ALIKE`."""
    return np.outer(deviation, deviation) * (ALIKE + (1.0 - ALIKE) * np.eye(len(deviation)))


def complete(
    rows: Rows, mean: np.ndarray, covariance: np.ndarray, center: np.ndarray | None, mass: float, scaled: bool
) -> Known:
    """Prior of all unknowns from that of arm and gains, mean (b + n,) and covariance (b + n, b + n).

    `center` (3,) [m] is the center of mass, None if it is unknown, and `mass` a guess of the mass [kg]; for
    `scaled` see `Known`.
    """
    body, changes = rows.payload, len(rows.changing)
    _, nominal = prior(rows.equations)
    total = len(mean) + len(INERTIAL) + changes
    full_mean, full = np.zeros(total), np.zeros((total, total))
    outer = np.r_[: rows.arm, body.stop + changes : total]
    full_mean[outer], full[np.ix_(outer, outer)] = mean, covariance
    variance = np.diag(nominal)[body]
    full[body, body] = np.diag(variance)
    if center is not None:  # it ties the moments to the mass
        slope = np.append(center, 1.0)
        moments = np.outer(slope, slope) * variance[MASS]
        moments[np.arange(3), np.arange(3)] += (RULER * mass) ** 2
        tied = slice(body.start + MOMENTS.start, body.stop)
        full[tied, tied] = moments
    places = body.stop + np.arange(changes)
    full[places, places] = _change(rows, mean[: rows.arm]) ** 2
    return Known(full_mean, root(full), scaled)


def _change(rows: Rows, values: np.ndarray) -> np.ndarray:
    """Standard deviation of the change of each changing parameter between runs, shape (c,).

    The base parameters (b,) of the arm and its drive gains give the size of changes.
    """
    equations = rows.equations
    columns = equations.regressor[:, :, rows.changing]
    rms = np.sqrt(np.mean(np.sum(columns**2, axis=1), axis=0))
    level = np.sqrt(np.mean((equations.gain * equations.current) ** 2, axis=0))
    joint = np.argmax(np.mean(columns**2, axis=0), axis=0)
    least = OFFSET_CHANGES * level[joint] / np.maximum(rms, np.finfo(float).tiny)
    return np.maximum(FRICTION_CHANGES * np.abs(values[rows.changing]), least)
