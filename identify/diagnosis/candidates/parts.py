"""Parts: building blocks of candidates."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, fields, replace
from typing import Any

import numpy as np

from ...arm.robot import Robot
from ...effects import EFFECTS, Effect, JointEffect, Parameter
from ...errors import NotRecorded
from ...model import Model
from ..findings.kind import Kind
from ..questions.candidate import UNNAMED, Candidate
from ..runs.driven import Driven
from ..runs.rows import REVERSAL_STD, TURNS, dry_friction, reversal_differences

FORGOTTEN = 5.0
"""Prior weight of a term that the model has on other joints but not on this one [-]."""
RARE = 0.3
"""Prior weight of an effect that is not in the vocabulary, relative to one that is [-].

A hose looks like a spring on every joint, and a sagging supply like saturating motors: each explains the
torque that several listed effects would otherwise share. Such an effect is reported in words."""
NUISANCES = ("reversal",)
"""Shape parameters that `with_nuisances` fits on every joint, so that no hypothesis varies them."""

Also = Callable[[Candidate, Effect], Candidate]
"""Adds properties to a candidate in any shape, given the effect in that shape."""


# Torque of joints and of motors, which differ where a motor turns with several joints.


def coupled(robot: Robot) -> bool:
    """Whether a motor turns with several joints."""
    return not np.array_equal(robot.to_motors, np.eye(robot.dof))


def on_motors(robot: Robot, columns: np.ndarray) -> np.ndarray:
    """Columns (t, n, p) of joint torque converted to motor torque."""
    return np.einsum("ij,tjp->tip", robot.to_motors, columns) if coupled(robot) else columns


def on_joint(run: Driven, joint: int, torque: np.ndarray) -> np.ndarray:
    """Columns (t, n, p) that act on one joint, from its torque (t,) or (t, p) [N m]."""
    values = torque[:, None] if torque.ndim == 1 else torque
    columns = np.zeros((*run.torque.shape, values.shape[1]))
    columns[:, joint] = values
    return columns


def require_current(run: Driven) -> None:
    """Check that a run recorded current; torque has no drive gain.

    Raises:
        NotRecorded: If torque was recorded instead.
    """
    if run.prepared.measures != "current":
        raise NotRecorded("current was not recorded")


def by_another(
    model: Model, name: str, torque: Callable[[Driven, int, int], np.ndarray], names: tuple[str, ...]
) -> Iterator[Candidate]:
    """Candidates for torque (t,) or (t, p) of one joint that depends on another, for every pair of joints."""
    count, dof = len(names), model.robot.dof
    units = ("1",) if count == 1 else ("N m",) * count
    for joint in range(dof):
        for other in [k for k in range(dof) if k != joint]:

            def columns(run: Driven, joint: int = joint, other: int = other) -> np.ndarray:
                return on_joint(run, joint, torque(run, joint, other))

            yield Candidate(
                name, (joint,), columns, names, units, (-np.inf,) * count, {"other_joint": other + 1.0},
                rows=(joint,), prior=RARE, listed=False,
            )  # fmt: skip


# Effects that a model can contain.


def on_single_joints(kind: type[Effect]) -> bool:
    """Whether an effect can be tested on each joint in turn, with its default shape."""
    has_defaults = all(f.default is not MISSING or f.default_factory is not MISSING for f in fields(kind))
    return issubclass(kind, JointEffect) and has_defaults


def _as_it_is(candidate: Candidate, effect: Effect) -> Candidate:
    return candidate


def on_each_joint(model: Model, name: str, kind: Kind, also: Also = _as_it_is) -> Iterator[Candidate]:
    """An effect of `EFFECTS` on each joint in turn, in each of its shapes."""
    nuisances = dry_friction(model, model.nominal_values)
    for place, joint in enumerate(model.robot.joints):
        for shape in kind.shapes:
            effect = EFFECTS[name](joints=(joint,), **shape)  # type: ignore[call-arg]
            candidate = of_effect(model, name, effect, kind, (place,), also)
            free_reversal = kind.dry and place not in nuisances
            yield _with_free_reversal(model, place, candidate) if free_reversal else candidate


def of_effect(
    model: Model, name: str, effect: Effect, kind: Kind, joints: Sequence[int], also: Also = _as_it_is
) -> Candidate:
    """The candidate for an effect in one shape on some joints.

    `also` adds further properties to the candidate in any shape.
    """
    robot, parameters = model.robot, effect.parameters(model.robot)
    declared = {f.name for f in fields(effect)}
    waves = () if getattr(effect, "count", 1) > 1 else ("harmonic",)
    shapes = {key: shape for key, shape in effect.shapes().items() if key not in NUISANCES}
    bounds = {**shapes, **kind.bounds}

    def columns(run: Driven) -> np.ndarray:
        return on_motors(robot, effect.regressor(robot, run.motion))

    def reshaped(shape: Mapping[str, Any]) -> Candidate:
        return of_effect(model, name, replace(effect, **shape), kind, joints, also)

    candidate = Candidate(
        effect=name,
        joints=tuple(joints),
        columns=columns,
        names=tuple(parameter.name for parameter in parameters),
        units=tuple(parameter.unit for parameter in parameters),
        lower=_lower(model, parameters, kind.reducible),
        shape={key: float(getattr(effect, key)) for key in (*bounds, *waves) if key in declared},
        bounds=bounds,
        reshape=reshaped,
        instance=effect,
        prior=_prior(model, parameters),
        rows=None if coupled(robot) else tuple(joints),
        smooth=effect.smooth,
        loaded=effect.needs_load,
        carried=effect.transmitted,
        gear_ratio=float(abs(robot.gear_ratio[joints[0]])) if joints else 1.0,
    )
    return also(candidate, effect)


def _prior(model: Model, parameters: Sequence[Parameter]) -> float:
    """Prior weight: a term that the model has on other joints is missing most often."""
    kinds = {parameter.name.rstrip("0123456789") for parameter in parameters}
    present = {name.rstrip("0123456789") for name in model.names}
    missing = not {parameter.name for parameter in parameters} & set(model.names)
    return FORGOTTEN if kinds <= present and missing else 1.0


def _lower(model: Model, parameters: Sequence[Parameter], reducible: bool) -> tuple[float, ...]:
    """Lower limit of each parameter: a reducible one may cancel its nominal value, others stay positive."""
    if not reducible:
        return tuple(parameter.minimum for parameter in parameters)
    nominal = dict(zip(model.names, model.nominal_values, strict=True))
    return tuple(-max(float(nominal.get(parameter.name, 0.0)), 0.0) for parameter in parameters)


def _with_free_reversal(model: Model, joint: int, candidate: Candidate) -> Candidate:
    """Dry friction with unknowns for its reversal, on a joint whose nuisances have none."""

    def columns(run: Driven) -> np.ndarray:
        reversal = on_motors(model.robot, reversal_differences(model, run, joint))
        return np.concatenate([candidate.columns(run), reversal], axis=2)

    def reshaped(shape: Mapping[str, float]) -> Candidate:
        return _with_free_reversal(model, joint, candidate.reshaped(shape))

    return replace(
        candidate,
        columns=columns,
        names=(*candidate.names, *(f"{UNNAMED}{k + 1}" for k in range(TURNS))),
        units=(*candidate.units, *("N m",) * TURNS),
        lower=(*candidate.lower, *(-np.inf,) * TURNS),
        proportion=(1.0, *(REVERSAL_STD,) * TURNS),
        led=1,
        reshape=reshaped,
    )
