"""Rows: what was measured, what is nominal, and the columns of all unknowns that explain the difference."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np

from ...arm.derivatives import differentiate
from ...effects import JointEffect, Prior
from ...effects.hysteresis import Hysteresis
from ...effects.smooth_sign import smooth_sign
from ...fit.base_parameters import BaseParameters
from ...fit.equations import decimated_regressor
from ...model import Model
from ...positive_definite import factored, solve
from .driven import Driven, Unloaded, slices


@dataclass(frozen=True, eq=False)
class Rows:
    """Stacked rows of some runs."""

    runs: tuple[slice, ...]  # rows of each run
    difference: np.ndarray  # measured torque minus that of the nominal model, shape (r, n) [N m]
    weight: np.ndarray  # 0 where a joint sticks, else 1, shape (r, n)
    columns: np.ndarray  # torque per unit of each unknown, shape (r, n, b)
    names: tuple[str, ...]  # of the unknowns
    std: np.ndarray  # how far each may be from its mean, (b,); infinite without a prior
    mean: np.ndarray  # prior mean, (b,); not zero for what was found and has a known size
    lower: np.ndarray  # smallest value that physics allows, (b,)
    bounded: np.ndarray  # whether each is certain to be within the square root of three deviations, (b,)
    passive: tuple[int, ...] = ()  # joints without a motor, whose measured torque is zero by definition

    def row_variance(self, variance: np.ndarray) -> np.ndarray:
        """Variance of each joint's rows, (n,) [(N m)^2], from that of what a fit leaves of them.

        Values of zero solve 0 = 0, so what is left of a passive joint shows no noise: its rows are as
        uncertain as those of the least certain motor, as in `identify`.
        """
        motors = np.setdiff1d(np.arange(len(variance)), self.passive)
        least = np.max(variance[motors], initial=0.0)
        return np.where(np.isin(np.arange(len(variance)), motors), variance, np.maximum(variance, least))

    @property
    def limited(self) -> np.ndarray:
        """Places of the unknowns that physics limits."""
        return np.flatnonzero(np.isfinite(self.lower))

    def plus(
        self,
        names: Sequence[str],
        columns: np.ndarray,
        std: np.ndarray,
        mean: np.ndarray | None = None,
        lower: Sequence[float] | None = None,
        bounded: bool = False,
    ) -> "Rows":
        """These rows with more unknowns: columns (r, n, p), deviations (p,) from a mean (p,), and limits."""
        return replace(
            self,
            columns=np.concatenate([self.columns, columns], axis=2),
            names=(*self.names, *names),
            std=np.concatenate([self.std, std]),
            mean=np.concatenate([self.mean, np.zeros(len(std)) if mean is None else mean]),
            lower=np.append(self.lower, np.full(len(std), -np.inf) if lower is None else lower),
            bounded=np.append(self.bounded, np.full(len(std), bounded)),
        )


def model_rows(model: Model, runs: Sequence[Driven], values: np.ndarray | None = None) -> Rows:
    """Rows whose unknowns are the deviations of the model's parameters from their priors.

    Args:
        model: With its priors.
        runs: Runs that are stacked.
        values: Parameters (p,) that give the load for the friction of gears; nominal ones by default.
    """
    carrying = model
    if values is not None:
        priors = {name: Prior(float(value)) for name, value in zip(model.names, values, strict=True)}
        carrying = replace(model, stated=priors)
    nominal, every = model.nominal_values, np.arange(len(model.names))
    # Priors make the system regular, so that no base parameters are needed.
    base = BaseParameters(tuple(model.parameters), every, np.eye(len(every)), (1.0, 0.0))
    columns, difference = [], []
    for run in runs:
        regressor, known = decimated_regressor(carrying, base, run.prepared, run.motion)
        measured = run.prepared.gain * run.prepared.decimated_current
        columns.append(regressor)
        difference.append(measured - known - regressor @ nominal)
    return Rows(
        slices(runs),
        np.concatenate(difference),
        np.concatenate([run.prepared.weight for run in runs]),
        np.concatenate(columns),
        tuple(model.names),
        np.array([prior.std for prior in model.priors]),
        np.zeros(len(model.names)),
        _limits(model) - nominal,
        np.array([name in model.bounded for name in model.names]),
        tuple(model.robot.index(joint) for joint in model.robot.passive),
    )


def _limits(model: Model) -> np.ndarray:
    """Smallest value of each parameter, shape (p,); none of bodies and rotors, which share their inertia."""
    found: list[float] = []
    for effect in model.effects:
        own = isinstance(effect, JointEffect) and effect.massless
        found += [one.minimum if own else -np.inf for one in effect.parameters(model.robot)]
    return np.array(found)


REVERSALS = (0.001, 0.003, 0.01, 0.03)
"""Velocities over which dry friction may change its sign [rad/s]: how it does is a matter of surfaces, and no
model's shape is right at low speed."""
REVERSAL_STD = 0.5
"""Share of Coulomb friction that may reverse over another of them than nominal."""
PRESLIDING = (5e-5, 2e-4, 6e-4)
"""Displacements over which dry friction may build up [rad]: surfaces bend before they slide, as far as some
thousandths of a gear's radius. What takes longer is a property of the gear and has a name."""
UNKNOWN_GAIN = 1.0
"""Share by which an unstated drive gain may be another, beside those of the other drives [-]."""
GAIN = "gain"
"""How the unknown is called by whose share a drive gain is larger; the number of the joint is behind."""
REVERSAL = "reversal"
"""How the unknowns begin by which dry friction turns otherwise; the number of the joint is behind."""
CLOCK = "clock"
"""How the unknown is called by which all drives' clocks are wrong; each drive's own has its number behind."""
CLOCKS = 2.5e-4
"""Time by which currents may be older or younger than positions, of all drives or of one [s]: a sample of a
drive's own loop, at 4 kHz or more; what comes later in a cycle of 2 ms than it should is a delay."""


def with_nuisances(rows: Rows, model: Model, runs: Sequence[Driven], values: np.ndarray) -> Rows:
    """The rows with low-speed friction, drive gains and clocks as unknowns too; values (p,) are a fit's."""
    turning = reversals(model, runs, dry(model, values))
    rows = rows.plus(*turning)
    rows = rows.plus(*_gains(model, runs, rows), bounded=model.robot.drive_gain_bounded)
    return rows.plus(*_clock(model, runs))


def dry(model: Model, values: np.ndarray) -> dict[int, float]:
    """Dry friction among parameters (p,), joint -> [N m]."""
    friction, robot = dict(zip(model.names, values, strict=True)), model.robot
    found: dict[int, float] = {}
    for effect in [one for one in model.effects if isinstance(one, JointEffect) and one.dry]:
        for joint, parameter in zip(effect.columns(robot), effect.parameters(robot), strict=True):
            found[joint] = found.get(joint, 0.0) + abs(float(friction[parameter.name]))
    return dict(sorted(found.items()))


def reversals(
    model: Model, runs: Sequence[Driven], friction: Mapping[int, float]
) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Differences between one way of turning the sign of dry friction, joint -> [N m], and the next."""
    robot, count = model.robot, len(REVERSALS) - 1 + len(PRESLIDING)
    names = [f"{REVERSAL}{joint + 1}_{k + 1}" for joint in friction for k in range(count)]
    parts = []
    for run in runs:
        columns = np.zeros((run.rows, robot.dof, len(names)))
        change = run.thinned(_turns(model, run)) if friction else np.zeros((run.rows, robot.dof, count))
        for place, (joint, torque) in enumerate(friction.items()):
            own = slice(place * count, (place + 1) * count)
            columns[:, joint, own] = change[:, joint] * torque
        parts.append(np.einsum("ij,tjb->tib", robot.to_motors, columns))
    return names, np.concatenate(parts), np.full(len(names), REVERSAL_STD)


def turning(model: Model, run: Driven, joint: int) -> np.ndarray:
    """One way in which a joint's unit of dry friction changes its sign less another, (t, n, k) [-]."""
    whole = np.zeros((len(run.motion), model.robot.dof, len(REVERSALS) - 1 + len(PRESLIDING)))
    whole[:, joint] = _turns(model, run)[:, joint]
    return whole


def _turns(model: Model, run: Driven) -> np.ndarray:
    """One way in which dry friction changes its sign less another, shape (t, n, k) [-]."""
    if run.unloaded not in _TURNS:
        signs = np.stack([smooth_sign(run.motion.velocity, v) for v in REVERSALS], axis=2)
        hysteresis = (Hysteresis(presliding=x).regressor(model.robot, run.motion) for x in PRESLIDING)
        bent = [np.einsum("tjj->tj", columns) for columns in hysteresis]
        turns = [np.diff(signs, axis=2), np.stack(bent, axis=2) - signs[:, :, 1:2]]
        _TURNS[run.unloaded] = np.concatenate(turns, axis=2)
    return _TURNS[run.unloaded]


_TURNS: WeakKeyDictionary[Unloaded, np.ndarray] = WeakKeyDictionary()
"""What `_turns` has made of the runs that are there: every candidate for dry friction asks for it."""


ENOUGH = 4000
"""Rows, evenly spread, by which it is found how nominal values move with a gain: tens a parameter."""
UNDETERMINED = 1e-9
"""Share of a column's square that keeps what no row determines at zero."""


def _gains(model: Model, runs: Sequence[Driven], rows: Rows) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Drive gains that are larger by a share show less current; torque itself has no gain.

    Where nominal values were identified with these gains they move with them: what remains is the torque that
    the nominal model does not have.
    """
    if runs[0].prepared.measures != "current":
        return [], np.zeros((sum(run.rows for run in runs), model.robot.dof, 0)), np.zeros(0)
    torque = np.concatenate([run.thinned(run.torque) for run in runs])
    names = [f"{GAIN}{joint + 1}" for joint in range(model.robot.dof)]
    columns = -torque[:, :, None] * np.eye(model.robot.dof)
    if model.robot.inertias_by_gain:
        columns = columns + _identified_with(model, rows)
    unknown = bool(np.all(model.robot.drive_gain == 1.0))
    tolerance = np.full(len(names), UNKNOWN_GAIN) if unknown else model.robot.drive_gain_tolerance
    return names, columns, tolerance


def _identified_with(model: Model, rows: Rows) -> np.ndarray:
    """Torque of the nominal model that moves with each drive gain, shape (r, n, n) [N m].

    An identification with a gain that is larger by a share finds the values that fit that joint's torque,
    larger by this share, and those of the others as they are, best: each weighed by its usual torque.
    """
    count = len(model.names)  # the first unknowns of any rows
    torque = rows.columns[:, :, :count] @ model.nominal_values
    some = slice(None, None, max(1, len(torque) // ENOUGH))
    weight = rows.weight[some] / np.maximum(np.sqrt(np.mean(torque**2, axis=0)), np.finfo(float).tiny)
    own = (rows.columns[some, :, :count] * weight[:, :, None]).reshape(-1, count)
    targets = (torque[some] * weight)[:, :, None] * np.eye(torque.shape[1])
    moved = solve(factored(own.T @ own, UNDETERMINED), own.T @ targets.reshape(len(own), -1))
    return np.asarray(rows.columns[:, :, :count] @ moved)


def _clock(model: Model, runs: Sequence[Driven]) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Currents that come later than their positions, of all drives and of each, show a torque gone by."""
    rate = np.concatenate([run.thinned(torque_rate(run)) for run in runs])
    own = rate[:, :, None] * np.eye(model.robot.dof)
    names = [CLOCK, *(f"{CLOCK}{joint + 1}" for joint in range(model.robot.dof))]
    return names, -np.concatenate([rate[:, :, None], own], axis=2), np.full(len(names), CLOCKS)


def torque_rate(run: Driven) -> np.ndarray:
    """Time derivative of the torque, shape (t, n) [N m/s]."""
    return differentiate(run.torque, run.prepared.decimation.rate)[0]
