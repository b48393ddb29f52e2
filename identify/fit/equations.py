"""Equations: the overdetermined system of a model and its runs, filtered and decimated.

Each row is gain * current = regressor @ values + known torque. If a motor drives several joints (the paper's
(22)), the rows are motor torques: coupling^-T times joint torques.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..arm.motion import Motion
from ..errors import RecordingError
from ..model import Model
from ..preparation.filters import Decimation
from ..preparation.prepare import Prepared
from ..preparation.repeated_motion import first_rows
from .base_parameters import BaseParameters

SMOOTH = 8.0
"""Samples per period of the positions' cutoff that resolve a smooth effect [-]: inertia that rotates with two
joints, times squared velocity, contains up to about four times their frequencies."""


@dataclass(frozen=True)
class Equations:
    """Stacked equations of all runs."""

    base: BaseParameters  # base parameters, one per column
    regressor: np.ndarray  # torque per unit of each base parameter, shape (r, n, b) [N m / unit]
    current: np.ndarray  # measured current, shape (r, n) [A], or torque [N m] if torque was recorded
    known: np.ndarray  # torque that no parameter scales, shape (r, n) [N m]
    weight: np.ndarray  # 0 where a joint sticks, else 1, shape (r, n)
    gain: np.ndarray  # nominal torque per unit of current, shape (n,)
    # Relative standard deviation of the nominal gains, one number or shape (n,) [-].
    gain_tolerance: float | np.ndarray
    gain_known: bool  # whether torque was recorded, so that gains are one by definition
    runs: tuple[slice, ...]  # rows of each run
    rate: float  # rows per second [Hz]
    noise: np.ndarray  # noise floor of `current`, shape (n,)
    first: np.ndarray  # row in which the motion of each row was made for the first time, shape (r,)
    # Nominal value of each standard parameter, shape (p,).
    nominal: np.ndarray = field(default_factory=lambda: np.empty(0))
    # Standard deviation of the nominal values, infinite without a prior, shape (p,).
    tolerance: np.ndarray = field(default_factory=lambda: np.empty(0))
    bodies: tuple[slice, ...] = ()  # standard parameters of each rigid body, ten per body

    @property
    def names(self) -> list[str]:
        """Names of the base parameters, one per column."""
        return self.base.names

    def without(self, columns: Sequence[int]) -> "Equations":
        """Equations with some base parameters held at zero."""
        remaining = np.setdiff1d(np.arange(len(self.base.kept)), columns)
        base = replace(self.base, kept=self.base.kept[remaining], regrouping=self.base.regrouping[remaining])
        return replace(self, base=base, regressor=self.regressor[:, :, remaining])


def assemble(model: Model, base: BaseParameters, runs: Sequence[Prepared]) -> Equations:
    """Equations of a model over prepared runs.

    Raises:
        RecordingError: The runs measure different quantities, or are filtered differently.
    """
    kinds = {run.measures for run in runs}
    if len(kinds) != 1:
        raise RecordingError(f"runs measure {' and '.join(sorted(kinds))}; identify them separately")
    rates = {round(run.decimation.output_rate, 6) for run in runs}
    if len(rates) != 1:
        raise RecordingError(
            f"runs are decimated to different rates ({', '.join(f'{r:g} Hz' for r in sorted(rates))}); "
            "give one torque cutoff for all"
        )
    parts = [decimated_regressor(model, base, run, run.motion) for run in runs]
    stops = np.cumsum([0, *(len(regressor) for regressor, _ in parts)])
    return Equations(
        base=base,
        regressor=np.concatenate([regressor for regressor, _ in parts]),
        current=np.concatenate([run.decimated_current for run in runs]),
        known=np.concatenate([known for _, known in parts]),
        weight=np.concatenate([run.weight for run in runs]),
        gain=runs[0].gain,
        gain_tolerance=model.robot.drive_gain_tolerance if runs[0].measures == "current" else 0.0,
        gain_known=runs[0].measures == "torque",
        runs=tuple(slice(a, b) for a, b in zip(stops[:-1], stops[1:], strict=True)),
        rate=runs[0].decimation.output_rate,
        noise=np.sqrt(np.mean([run.noise**2 for run in runs], axis=0)),
        first=first_rows([run.decimated_position for run in runs], [run.motion.payload for run in runs]),
        nominal=model.prior_values,
        tolerance=np.array([prior.std for prior in model.priors]),
        bodies=tuple(model.inertias),
    )


def decimated_regressor(
    model: Model, base: BaseParameters, run: Prepared, motion: Motion
) -> tuple[np.ndarray, np.ndarray]:
    """Base regressor (r, n, b) and known torque (r, n) of one run, at the decimated rate.

    The regressor is computed at full rate and then filtered: it is nonlinear in position, so the two steps
    do not commute.
    """
    rows = len(run.decimation.centres(len(motion)))
    columns = np.zeros((rows, motion.position.shape[1], len(base.kept) + 1))
    for part, part_columns, decimation in _parts(model, run):
        places = np.flatnonzero(np.isin(base.kept, part_columns))
        selected = np.searchsorted(part_columns, base.kept[places])
        pieces = (
            np.concatenate([np.take(columns, selected, axis=2), known[:, :, None]], axis=2)
            for columns, known in part.pieces(motion[:: decimation.step], model)
        )
        ready = decimation.stream(pieces)[:rows]
        columns[:, :, places] = ready[:, :, :-1]
        columns[:, :, -1] += ready[:, :, -1]
    to_motors = model.robot.to_motors
    if not np.array_equal(to_motors, np.eye(len(to_motors))):
        columns = np.einsum("ij,tjb->tib", to_motors, columns)
    return columns[:, :, :-1], columns[:, :, -1]


def _parts(model: Model, run: Prepared) -> Iterator[tuple[Model, np.ndarray, Decimation]]:
    """Split the model into smooth and abrupt effects: each part with its columns and its decimation."""
    smooth = np.array([effect.smooth and effect.pointwise for effect in model.effects], bool)
    for kind, rate in ((smooth, SMOOTH * run.position_cutoff), (~smooth, np.inf)):
        effects = tuple(effect for effect, wanted in zip(model.effects, kind, strict=True) if wanted)
        if effects:
            columns = np.concatenate(
                [np.r_[c] for c, wanted in zip(model.columns, kind, strict=True) if wanted]
            )
            yield replace(model, effects=effects), columns, run.decimation.thinned(rate)
