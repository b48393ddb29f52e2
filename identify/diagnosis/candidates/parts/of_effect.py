"""Candidates that are effects of the model's own kind."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, fields, replace
from typing import Any

import numpy as np

from ....effects import EFFECTS, Effect, JointEffect
from ....model import Model
from ...findings.kind import Kind
from ...questions.candidate import Candidate
from ...runs.driven import Driven
from .motors import coupled, on_motors
from .turning import with_turning

FORGOTTEN = 5.0
"""How much likelier a model lacks what it has on other joints than what it has nowhere [-]."""
NUISANCES = ("reversal",)
"""Numbers of shapes that `with_nuisances` leaves open on every joint, so that no hypothesis is about them."""

Also = Callable[[Candidate, Effect], Candidate]
"""What else is known of a candidate in any shape, by the effect in that shape."""


def on_single_joints(kind: type[Effect]) -> bool:
    """Whether an effect can be asked for on each joint in turn: as it is where no file adds to it."""
    given = all(f.default is not MISSING or f.default_factory is not MISSING for f in fields(kind))
    return issubclass(kind, JointEffect) and given


def as_it_is(candidate: Candidate, effect: Effect) -> Candidate:
    """Nothing else."""
    return candidate


def on_each_joint(model: Model, name: str, kind: Kind, also: Also = as_it_is) -> Iterator[Candidate]:
    """An effect of `EFFECTS` on each joint in turn, in each of its shapes."""
    for joint in model.robot.joints:
        for given in kind.shapes:
            effect = EFFECTS[name](joints=(joint,), **given)  # type: ignore[call-arg]
            place = model.robot.index(joint)
            one = of_effect(model, name, effect, kind, (place,), also)
            yield with_turning(model, place, one) if kind.dry else one


def of_effect(
    model: Model, name: str, effect: Effect, kind: Kind, joints: Sequence[int], also: Also = as_it_is
) -> Candidate:
    """The candidate that an effect is.

    Args:
        model: The arm.
        name: Of the candidate.
        effect: In one shape.
        kind: What is known of the candidate.
        joints: Where it acts.
        also: What else is known of it in any shape.
    """
    robot, parameters = model.robot, effect.parameters(model.robot)
    own = {f.name for f in fields(effect)}
    waves = () if getattr(effect, "count", 1) > 1 else ("harmonic",)
    bounds = {key: kind.bounds.get(key, one) for key, one in effect.shapes().items() if key not in NUISANCES}
    shape = {key: float(getattr(effect, key)) for key in (*bounds, *waves) if key in own}

    def columns(run: Driven) -> np.ndarray:
        return on_motors(robot, effect.regressor(robot, run.motion))

    def reshaped(given: Mapping[str, Any]) -> Candidate:
        return of_effect(model, name, replace(effect, **given), kind, joints, also)

    found = Candidate(
        effect=name,
        joints=tuple(joints),
        columns=columns,
        names=tuple(parameter.name for parameter in parameters),
        units=tuple(parameter.unit for parameter in parameters),
        lower=_lower(model, parameters, kind.reducible),
        shape=shape,
        bounds=bounds,
        reshaped=reshaped,
        instance=effect,
        prior=_prior(model, parameters),
        rows=None if coupled(robot) else tuple(joints),
        smooth=effect.smooth,
        loaded=effect.needs_load,
        carried=effect.transmitted,
        gear_ratio=float(abs(robot.gear_ratio[joints[0]])) if joints else 1.0,
    )
    return also(found, effect)


def _prior(model: Model, parameters: list[Any]) -> float:
    """A term that the model has on other joints is what is missing most often."""
    kinds = {parameter.name.rstrip("0123456789") for parameter in parameters}
    there = {name.rstrip("0123456789") for name in model.names}
    missing = not {parameter.name for parameter in parameters} & set(model.names)
    return FORGOTTEN if kinds <= there and missing else 1.0


def _lower(model: Model, parameters: list[Any], reducible: bool) -> tuple[float, ...]:
    """What the model already has may be less than nominal, if it is such; nothing else may be negative."""
    if not reducible:
        return tuple(parameter.minimum for parameter in parameters)
    nominal = dict(zip(model.names, model.nominal_values, strict=True))
    return tuple(-max(float(nominal.get(parameter.name, 0.0)), 0.0) for parameter in parameters)
