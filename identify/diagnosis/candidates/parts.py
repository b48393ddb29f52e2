"""Parts: what candidates are made of."""

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
from ..runs.rows import PRESLIDING, REVERSAL_STD, REVERSALS, dry, turning

FORGOTTEN = 5.0
"""How much likelier a model lacks what it has on other joints than what it has nowhere [-]."""
RARE = 0.3
"""How likely what has no name in the vocabulary is before the data, beside an effect that has one [-].

A hose looks like a spring on every joint, a supply that sags like motors that saturate: each of these takes
the torque that several listed effects would otherwise share. It is reported in words."""
NUISANCES = ("reversal",)
"""Numbers of shapes that `with_nuisances` leaves open on every joint, so that no hypothesis is about them."""
TURNS = len(REVERSALS) - 1 + len(PRESLIDING)
"""Ways of turning the sign of dry friction."""

Also = Callable[[Candidate, Effect], Candidate]
"""What else is known of a candidate in any shape, by the effect in that shape."""


# Torque of joints, and the same seen from the motors, which differ where a motor turns with several.


def coupled(robot: Robot) -> bool:
    """Whether a motor turns with several joints."""
    return not np.array_equal(robot.to_motors, np.eye(robot.dof))


def on_motors(robot: Robot, columns: np.ndarray) -> np.ndarray:
    """Columns (t, n, p) of joint torque as those of motor torque."""
    return np.einsum("ij,tjp->tip", robot.to_motors, columns) if coupled(robot) else columns


def on_joint(run: Driven, joint: int, torque: np.ndarray) -> np.ndarray:
    """Columns (t, n, p) that act on one joint, of its torque (t,) or (t, p) [N m]."""
    own = torque[:, None] if torque.ndim == 1 else torque
    columns = np.zeros((*run.torque.shape, own.shape[1]))
    columns[:, joint] = own
    return columns


def require_current(run: Driven) -> None:
    """Raise where torque was recorded, which has no gain.

    Raises:
        NotRecorded: It was.
    """
    if run.prepared.measures != "current":
        raise NotRecorded("current was not recorded")


def by_another(
    model: Model, name: str, torque: Callable[[Driven, int, int], np.ndarray], names: tuple[str, ...]
) -> Iterator[Candidate]:
    """One joint's torque (t,) or (t, p) that depends on another joint, whichever it is."""
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


# Effects of the model's own kind.


def on_single_joints(kind: type[Effect]) -> bool:
    """Whether an effect can be asked for on each joint in turn, with its default numbers."""
    given = all(f.default is not MISSING or f.default_factory is not MISSING for f in fields(kind))
    return issubclass(kind, JointEffect) and given


def _as_it_is(candidate: Candidate, effect: Effect) -> Candidate:
    return candidate


def on_each_joint(model: Model, name: str, kind: Kind, also: Also = _as_it_is) -> Iterator[Candidate]:
    """An effect of `EFFECTS` on each joint in turn, in each of its shapes."""
    nuisances = dry(model, model.nominal_values)
    for place, joint in enumerate(model.robot.joints):
        for given in kind.shapes:
            effect = EFFECTS[name](joints=(joint,), **given)  # type: ignore[call-arg]
            one = of_effect(model, name, effect, kind, (place,), also)
            yield _with_turning(model, place, one) if kind.dry and place not in nuisances else one


def of_effect(
    model: Model, name: str, effect: Effect, kind: Kind, joints: Sequence[int], also: Also = _as_it_is
) -> Candidate:
    """The candidate that an effect is, in one shape, on some joints.

    Args:
        model: The arm.
        name: Name of the candidate in the vocabulary.
        effect: In one shape.
        kind: What is known of the candidate.
        joints: Where it acts.
        also: What else is known of it in any shape.
    """
    robot, parameters = model.robot, effect.parameters(model.robot)
    own = {f.name for f in fields(effect)}
    waves = () if getattr(effect, "count", 1) > 1 else ("harmonic",)
    bounds = {key: kind.bounds.get(key, one) for key, one in effect.shapes().items() if key not in NUISANCES}

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
        shape={key: float(getattr(effect, key)) for key in (*bounds, *waves) if key in own},
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
    return also(found, effect)


def _prior(model: Model, parameters: Sequence[Parameter]) -> float:
    """A term that the model has on other joints is what is missing most often."""
    kinds = {parameter.name.rstrip("0123456789") for parameter in parameters}
    there = {name.rstrip("0123456789") for name in model.names}
    missing = not {parameter.name for parameter in parameters} & set(model.names)
    return FORGOTTEN if kinds <= there and missing else 1.0


def _lower(model: Model, parameters: Sequence[Parameter], reducible: bool) -> tuple[float, ...]:
    """What the model already has may be less than nominal, if it is such; nothing else may be negative."""
    if not reducible:
        return tuple(parameter.minimum for parameter in parameters)
    nominal = dict(zip(model.names, model.nominal_values, strict=True))
    return tuple(-max(float(nominal.get(parameter.name, 0.0)), 0.0) for parameter in parameters)


def _with_turning(model: Model, joint: int, candidate: Candidate) -> Candidate:
    """Dry friction with other ways of turning its sign beside it, on a joint whose nuisances have none."""

    def columns(run: Driven) -> np.ndarray:
        turns = on_motors(model.robot, turning(model, run, joint))
        return np.concatenate([candidate.columns(run), turns], axis=2)

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return _with_turning(model, joint, candidate.reshaped(given))

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
