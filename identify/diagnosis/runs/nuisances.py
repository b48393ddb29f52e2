"""Nuisances: what is never quite as the model has it and is not worth a name."""

from collections.abc import Mapping, Sequence

import numpy as np

from ...effects import JointEffect
from ...effects.hysteresis import Hysteresis
from ...effects.smooth_sign import smooth_sign
from ...model import Model
from ...preparation.filters import differentiate
from .driven import Driven
from .rows import Rows

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
    rows = rows.plus(*_gains(model, runs), bounded=model.robot.drive_gain_bounded)
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
    signs = np.stack([smooth_sign(run.motion.velocity, v) for v in REVERSALS], axis=2)
    bent = [_on_diagonal(Hysteresis(presliding=x).regressor(model.robot, run.motion)) for x in PRESLIDING]
    return np.concatenate([np.diff(signs, axis=2), np.stack(bent, axis=2) - signs[:, :, 1:2]], axis=2)


def _on_diagonal(columns: np.ndarray) -> np.ndarray:
    """Each joint's own column, (t, n, n) -> (t, n)."""
    return np.einsum("tjj->tj", columns)


def _gains(model: Model, runs: Sequence[Driven]) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Drive gains that are larger by a share show less current; torque itself has no gain."""
    if runs[0].prepared.measures != "current":
        return [], np.zeros((sum(run.rows for run in runs), model.robot.dof, 0)), np.zeros(0)
    torque = np.concatenate([run.thinned(run.torque) for run in runs])
    names = [f"gain{joint + 1}" for joint in range(model.robot.dof)]
    columns = -torque[:, :, None] * np.eye(model.robot.dof)
    unknown = bool(np.all(model.robot.drive_gain == 1.0))
    tolerance = np.full(len(names), UNKNOWN_GAIN) if unknown else model.robot.drive_gain_tolerance
    return names, columns, tolerance


def _clock(model: Model, runs: Sequence[Driven]) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Currents that come later than their positions, of all drives and of each, show a torque gone by."""
    rate = np.concatenate([run.thinned(torque_rate(run)) for run in runs])
    own = rate[:, :, None] * np.eye(model.robot.dof)
    names = [CLOCK, *(f"{CLOCK}{joint + 1}" for joint in range(model.robot.dof))]
    return names, -np.concatenate([rate[:, :, None], own], axis=2), np.full(len(names), CLOCKS)


def torque_rate(run: Driven) -> np.ndarray:
    """Time derivative of the torque, shape (t, n) [N m/s]."""
    return differentiate(run.torque, run.prepared.decimation.rate)[0]
