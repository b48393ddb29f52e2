"""Rows: measured minus nominal torque, and the columns of all unknowns that may explain the difference."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from ...arm.motion import differentiate
from ...effects import CoulombFriction, JointEffect, Prior
from ...effects.hysteresis import Hysteresis
from ...effects.smooth_sign import smooth_sign
from ...fit.base_parameters import BaseParameters
from ...fit.equations import decimated_regressor
from ...model import Model
from ...positive_definite import factored, solve
from .driven import Driven, Unloaded, cached, slices


@dataclass(frozen=True, eq=False)
class Rows:
    """Stacked rows of several runs."""

    runs: tuple[slice, ...]  # rows of each run
    difference: np.ndarray  # measured minus nominal torque, shape (r, n) [N m]
    weight: np.ndarray  # 0 where a joint sticks, else 1, shape (r, n)
    parts: tuple[np.ndarray, ...]  # torque per unit of each unknown, shapes (r, n, p), b unknowns in all
    names: tuple[str, ...]  # names of the unknowns
    std: np.ndarray  # prior standard deviation, (b,); infinite without a prior
    mean: np.ndarray  # prior mean, (b,); not zero for findings of known size
    lower: np.ndarray  # smallest value that physics allows, (b,)
    bounded: np.ndarray  # whether each is certain to lie within sqrt(3) standard deviations, (b,)
    passive: tuple[int, ...] = ()  # joints without a motor, whose measured torque is zero by definition

    def row_variance(self, variance: np.ndarray) -> np.ndarray:
        """Variance of each joint's rows, (n,) [(N m)^2], from the variance of their residual (n,).

        The residual of a passive joint shows no noise, since zero parameters fit its zero torque exactly. Its
        rows therefore get the variance of the least certain motor, as in `identify`.
        """
        motors = np.setdiff1d(np.arange(len(variance)), self.passive)
        largest = np.max(variance[motors], initial=0.0)
        return np.where(np.isin(np.arange(len(variance)), motors), variance, np.maximum(variance, largest))

    @cached_property
    def columns(self) -> np.ndarray:
        """Torque per unit of each unknown, shape (r, n, b); a copy, which takes as long as a fit."""
        return np.concatenate(self.parts, axis=2) if len(self.parts) > 1 else self.parts[0]

    def columns_at(self, places: np.ndarray) -> np.ndarray:
        """Columns of some unknowns, whose indices (p,) ascend, shape (r, n, p)."""
        ends = np.cumsum([part.shape[2] for part in self.parts])
        within = np.searchsorted(ends, places, side="right")
        chosen = [self.parts[0][:, :, :0]]
        for number, (part, end) in enumerate(zip(self.parts, ends, strict=True)):
            here = places[within == number] - end + part.shape[2]
            if len(here):
                chosen.append(part if len(here) == part.shape[2] else part[:, :, here])
        return np.concatenate(chosen[1:], axis=2) if len(chosen) > 2 else chosen[-1]

    def torque(self, values: np.ndarray) -> np.ndarray:
        """Torque of unknowns (b,), shape (r, n) [N m]."""
        own = np.split(values, np.cumsum([part.shape[2] for part in self.parts])[:-1])
        return np.sum([part @ some for part, some in zip(self.parts, own, strict=True)], axis=0)

    @property
    def limited(self) -> np.ndarray:
        """Indices of the unknowns that physics limits."""
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
        """Rows with p more unknowns: columns (r, n, p), prior standard deviations, means and limits."""
        return replace(
            self,
            parts=(*self.parts, columns),
            names=(*self.names, *names),
            std=np.concatenate([self.std, std]),
            mean=np.concatenate([self.mean, np.zeros(len(std)) if mean is None else mean]),
            lower=np.append(self.lower, np.full(len(std), -np.inf) if lower is None else lower),
            bounded=np.append(self.bounded, np.full(len(std), bounded)),
        )


def model_rows(model: Model, runs: Sequence[Driven], values: np.ndarray | None = None) -> Rows:
    """Rows whose unknowns are the deviations of the model's parameters from their priors.

    The load in gear friction is that at the values (p,), nominal by default.
    """
    carrying = model
    if values is not None:
        priors = {name: Prior(float(value)) for name, value in zip(model.names, values, strict=True)}
        carrying = replace(model, stated=priors)
    nominal, all_parameters = model.nominal_values, np.arange(len(model.names))
    # Priors make the system regular, so that no base parameters are needed.
    base = BaseParameters(tuple(model.parameters), all_parameters, np.eye(len(all_parameters)), (1.0, 0.0))
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
        (np.concatenate(columns),),
        tuple(model.names),
        np.array([prior.std for prior in model.priors]),
        np.zeros(len(model.names)),
        _limits(model) - nominal,
        np.array([name in model.bounded for name in model.names]),
        tuple(model.robot.index(joint) for joint in model.robot.passive),
    )


def _limits(model: Model) -> np.ndarray:
    """Smallest value of each parameter, shape (p,); none for bodies and rotors, which share inertia."""
    limits: list[float] = []
    for effect in model.effects:
        massless = isinstance(effect, JointEffect) and effect.massless
        parameters = effect.parameters(model.robot)
        limits += [parameter.minimum if massless else -np.inf for parameter in parameters]
    return np.array(limits)


REVERSALS = (0.001, 0.003, 0.01, 0.03)
"""Velocity ranges over which dry friction may change its sign [rad/s]: this depends on the surfaces, and no
model is right at low speed."""
REVERSAL_STD = 0.5
"""Prior deviation of the share of Coulomb friction that reverses over a different range than nominal [-]."""
PRESLIDING = (5e-5, 2e-4, 6e-4)
"""Displacements over which dry friction may build up [rad]: surfaces bend before they slide, by a few
thousandths of a gear's radius. A longer displacement is a property of the gear, with an effect of its own."""
LEADS = ((0.006, 0.003), (0.01, 0.03))
"""Times by which dry friction may turn before the velocity does [s], with velocity ranges [rad/s]: surfaces
that bend also damp (the bristles of LuGre's model), and MuJoCo turns `frictionloss` up to 10 ms early."""
TURNS = len(REVERSALS) - 1 + len(PRESLIDING) + len(LEADS)
"""Number of unknowns of a joint for the reversal of dry friction."""
UNKNOWN_GAIN = 1.0
"""Relative prior deviation of a drive gain that is not stated [-]."""
GAIN = "gain"
"""Name of the unknown relative error of a drive gain; the joint number follows."""
REVERSAL = "reversal"
"""Prefix of the unknowns for the reversal of dry friction; the joint number follows."""
CLOCK = "clock"
"""Name of the unknown clock error of all drives; with a joint number, that of one drive."""
CLOCKS = 2.5e-4
"""Prior deviation of the time between currents and positions, of all drives or of one [s]: one sample of a
drive's control loop at 4 kHz. A time shift within a 2 ms cycle that exceeds it is a delay."""


def with_nuisances(rows: Rows, model: Model, runs: Sequence[Driven], values: np.ndarray) -> Rows:
    """The rows with low-speed friction, drive gains and clocks as unknowns too; fitted values (p,)."""
    rows = rows.plus(*reversals(model, runs, dry_friction(model, values)))
    rows = rows.plus(*_gains(model, runs, rows), bounded=model.robot.drive_gain_bounded)
    return rows.plus(*_clock(model, runs))


def dry_friction(model: Model, values: np.ndarray) -> dict[int, float]:
    """Total dry friction of each joint, from parameters (p,): joint -> [N m]."""
    by_name, robot = dict(zip(model.names, values, strict=True)), model.robot
    total: dict[int, float] = {}
    joint_effects = (effect for effect in model.effects if isinstance(effect, JointEffect))
    for effect in (effect for effect in joint_effects if effect.dry):
        for joint, parameter in zip(effect.columns(robot), effect.parameters(robot), strict=True):
            total[joint] = total.get(joint, 0.0) + abs(float(by_name[parameter.name]))
    return dict(sorted(total.items()))


def reversals(
    model: Model, runs: Sequence[Driven], friction: Mapping[int, float]
) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Unknowns for how dry friction (joint -> [N m]) reverses: differences between successive ways."""
    robot, count = model.robot, TURNS
    names = [f"{REVERSAL}{joint + 1}_{k + 1}" for joint in friction for k in range(count)]
    parts = []
    for run in runs:
        columns = np.zeros((run.rows, robot.dof, len(names)))
        change = run.thinned(_turns(model, run)) if friction else np.zeros((run.rows, robot.dof, count))
        for place, (joint, torque) in enumerate(friction.items()):
            span = slice(place * count, (place + 1) * count)
            columns[:, joint, span] = change[:, joint] * torque
        parts.append(np.einsum("ij,tjb->tib", robot.to_motors, columns))
    return names, np.concatenate(parts), np.full(len(names), REVERSAL_STD)


def reversal_differences(model: Model, run: Driven, joint: int) -> np.ndarray:
    """Differences between ways in which unit dry friction of one joint reverses, shape (t, n, k) [-]."""
    differences = np.zeros((len(run.motion), model.robot.dof, TURNS))
    differences[:, joint] = _turns(model, run)[:, joint]
    return differences


def _turns(model: Model, run: Driven) -> np.ndarray:
    """Differences between ways in which unit dry friction reverses, shape (t, n, k) [-]."""
    if run.unloaded not in _TURNS:
        signs = np.stack([smooth_sign(run.motion.velocity, v) for v in REVERSALS], axis=2)
        hysteresis = (Hysteresis(presliding=x).regressor(model.robot, run.motion) for x in PRESLIDING)
        bent = [np.einsum("tjj->tj", columns) for columns in hysteresis]
        turns = [np.diff(signs, axis=2), np.stack(bent, axis=2) - signs[:, :, 1:2], _early(model, run)]
        _TURNS[run.unloaded] = np.concatenate(turns, axis=2)
    return _TURNS[run.unloaded]


def _early(model: Model, run: Driven) -> np.ndarray:
    """Differences between friction that turns early and friction that does not, shape (t, n, k) [-].

    They are zero on joints whose friction turns suddenly, where nothing tells them from other friction.
    """
    v, a = run.motion.velocity, run.motion.acceleration
    coulomb = [effect for effect in model.effects if isinstance(effect, CoulombFriction)]
    slow = [joint for e in coulomb if e.reversal > REVERSALS[1] for joint in e.columns(model.robot)]
    turns = np.stack([smooth_sign(v + lead * a, over) - smooth_sign(v, over) for lead, over in LEADS], axis=2)
    return np.asarray(turns * np.isin(np.arange(v.shape[1]), slow)[:, None])


_TURNS: WeakKeyDictionary[Unloaded, np.ndarray] = WeakKeyDictionary()
"""Cache of `_turns` by run, since every candidate for dry friction needs it."""


ENOUGH = 4000
"""Number of evenly spread rows from which the effect of a gain on nominal values is computed."""
UNDETERMINED = 1e-9
"""Regularization, relative to a column's square, that keeps undetermined parameters at zero."""


def _gains(model: Model, runs: Sequence[Driven], rows: Rows) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Unknown relative errors of drive gains; none if torque was recorded.

    Nominal values that were identified with these gains change with them, so only the torque outside the
    nominal model shows an error.
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
    """Torque of the nominal model per relative change of each drive gain, shape (r, n, n) [N m].

    If one gain is larger, an identification fits that joint's torque scaled up and the torque of the others
    unchanged. The joints are weighted by the inverse of their usual torque.
    """
    count = len(model.names)  # the first unknowns of any rows
    own = rows.columns_at(np.arange(count))
    torque = own @ model.nominal_values
    subset = slice(None, None, max(1, len(torque) // ENOUGH))
    weight = rows.weight[subset] / np.maximum(np.sqrt(np.mean(torque**2, axis=0)), np.finfo(float).tiny)
    columns = (own[subset] * weight[:, :, None]).reshape(-1, count)
    targets = (torque[subset] * weight)[:, :, None] * np.eye(torque.shape[1])
    change = solve(factored(columns.T @ columns, UNDETERMINED), columns.T @ targets.reshape(len(columns), -1))
    return np.asarray(own @ change)


def _clock(model: Model, runs: Sequence[Driven]) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Unknown delays of currents relative to positions, of all drives together and of each."""
    rate = np.concatenate([run.thinned(torque_rate(run)) for run in runs])
    by_drive = rate[:, :, None] * np.eye(model.robot.dof)
    names = [CLOCK, *(f"{CLOCK}{joint + 1}" for joint in range(model.robot.dof))]
    return names, -np.concatenate([rate[:, :, None], by_drive], axis=2), np.full(len(names), CLOCKS)


@cached
def torque_rate(run: Driven) -> np.ndarray:
    """Time derivative of the model torque, shape (t, n) [N m/s]."""
    return differentiate(run.torque, run.prepared.decimation.rate)[0]
