"""Fit of shapes: the nonlinear parameters of effects, such as the velocity over which friction reverses.

Each trial of a shape solves for the linear parameters (variable projection), so the search has one variable
at a time. It maximizes the likelihood with the noise of each joint.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy import optimize

from ..effects import Effect, name_of
from ..errors import RobotError
from ..model import Model
from ..preparation.prepare import Prepared
from .base_parameters import BaseParameters, base_parameters
from .equations import Equations, assemble
from .estimators.compressed import Compressed
from .estimators.least_squares import weighted_solution


def fit_shapes(
    model: Model,
    runs: Sequence[Prepared],
    effects: Sequence[str],
    progress: Callable[[str], None] = lambda _: None,
) -> Model:
    """Model with the shapes of some effects, named by their keys in `EFFECTS`, fitted joint by joint.

    Raises:
        RobotError: A name is not an effect of the model with shapes.
    """
    model = _apart(model, effects)
    base = base_parameters(model, sorted({run.motion.payload for run in runs}))
    equations = assemble(model, base, runs)
    for place, effect in enumerate(model.effects):
        if name_of(effect) not in effects:
            continue
        for name, bounds in effect.shapes().items():
            trial = _Trial(model, place, base, runs, equations)
            best = _search(partial(trial.cost, name), getattr(effect, name), bounds)
            effect = replace(effect, **{name: best})
            equations = trial.equations_with(effect)
            model = replace(model, effects=(*model.effects[:place], effect, *model.effects[place + 1 :]))
            joints = dict.fromkeys(effect.parameter_joints(model.robot))
            where = ", ".join(model.robot.joints[joint] for joint in joints if joint is not None)
            progress(f"{name_of(effect)} {where}: {name} {best:.3g}")
    return model


def _apart(model: Model, names: Sequence[str]) -> Model:
    """Model with each of the named effects split into one effect per joint."""
    shaped = {name_of(effect): None for effect in model.effects if effect.shapes()}
    for name in names:
        if name not in shaped:
            raise RobotError(
                f"the model has no effect '{name}' with shapes to fit; its effects with shapes are: "
                f"{', '.join(shaped) or 'none'}"
            )
    effects: list[Effect] = []
    for effect in model.effects:
        effects += effect.apart(model.robot) if name_of(effect) in names else [effect]
    return replace(model, effects=tuple(effects))


class _Trial:
    """Cost of the shapes of one effect, with everything else fixed."""

    def __init__(
        self, model: Model, place: int, base: BaseParameters, runs: Sequence[Prepared], equations: Equations
    ) -> None:
        self.model, self.effect, self.runs = model, model.effects[place], runs
        self.equations = equations
        columns = range(len(model.names))[model.columns[place]]
        self.in_effect = [k for k, column in enumerate(columns) if column in base.kept]
        self.in_base = [int(np.flatnonzero(base.kept == columns[k])[0]) for k in self.in_effect]
        self.compressed = Compressed.of(equations)
        acts = np.any(equations.regressor[:, :, self.in_base], axis=(0, 2))
        self.joints = np.flatnonzero(acts if acts.any() else np.ones_like(acts))

    def equations_with(self, effect: Effect) -> Equations:
        """Equations with the effect's columns replaced."""
        regressor = self.equations.regressor.copy()
        for run, rows in zip(self.runs, self.equations.runs, strict=True):
            columns = effect.regressor(self.model.robot, self.model.loaded(run.motion))[:, :, self.in_effect]
            on_motors = np.einsum("mj,tjk->tmk", self.model.robot.to_motors[self.joints], columns)
            filtered = run.decimation.apply(on_motors)
            for place, joint in enumerate(self.joints):
                regressor[rows][:, joint, self.in_base] = filtered[:, place]
        return replace(self.equations, regressor=regressor)

    def cost(self, name: str, value: float) -> float:
        """Negative log-likelihood up to a constant."""
        equations = self.equations_with(replace(self.effect, **{name: value}))
        # Only the rows of joints on which the effect acts have changed.
        compressed = self.compressed.updated(equations, self.joints)
        return float(equations.weight.sum(axis=0) @ np.log(weighted_solution(equations, compressed)[1]))


def _search(cost: Callable[[float], float], start: float, bounds: tuple) -> float:
    """Best value within the bounds, or the start if none is better; positive bounds use a log scale."""
    _, low, high = bounds
    by_decades = low > 0
    ends, step = (np.log([low, high]), 0.05) if by_decades else ((low, high), 1e-3 * (high - low))

    def at(x: float) -> float:
        return float(np.exp(x)) if by_decades else float(x)

    options = {"xatol": step}
    result = optimize.minimize_scalar(lambda x: cost(at(x)), bounds=ends, method="bounded", options=options)
    best = at(result.x)
    return best if result.fun < cost(start) else start
