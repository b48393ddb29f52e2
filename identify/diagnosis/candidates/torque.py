"""Candidates that are effects of the model's own kind: friction, springs, ripple, rotors, coupling."""

from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, replace
from typing import Any

import numpy as np

from ...effects import EFFECTS, Effect, JointEffect, JointSpring, KinematicCoupling, Shape, SpringBalancer
from ...model import Model
from ..candidate import UNNAMED, Candidate
from ..driven import Driven
from ..nuisances import PRESLIDING, REVERSAL_STD, REVERSALS, dry, turning
from .elastic import link_size
from .motors import coupled, on_motors

MULTIPLES = 6
"""Of a wave along a turn that are asked for together; what is sharper has little torque in those beyond."""
GRIDS: dict[str, tuple[dict[str, Any], ...]] = {
    "stribeck_friction": tuple({"fade": speed} for speed in (0.02, 0.05, 0.12, 0.3)),
    "hysteresis": tuple({"presliding": way} for way in (1.5e-3, 4e-3, 1e-2, 2.5e-2)),
    "nonlinear_viscous_friction": tuple({"exponent": power} for power in (0.5, 0.8, 1.5, 2.0, 3.0)),
    "torque_ripple": (*({"harmonic": float(k)} for k in (1, 2, 3, 4, 6)), {"count": MULTIPLES}),
    "position_dependent_friction": (*({"harmonic": float(k)} for k in (1, 2, 3)), {"count": MULTIPLES}),
    "friction_asymmetry": ({}, {"viscous": True}),
    "joint_spring": ({}, {"stiffening": True}),
}
"""Shapes that are tried; each within half a step of any other is refined."""
RATIOS = (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0)
"""Turns of a motor with its neighbour for one with its own joint that are tried [-]."""
FORGOTTEN = 5.0
"""How much likelier a model lacks what it has on other joints than what it has nowhere [-]."""
CABLE = 0.1
"""Torque of a hose or a cable, share of a joint's usual one [-]; what carries weight is a balancer."""
BALANCED = 0.05
"""Weight that a joint carries over the most that one does, from which on somebody may balance it [-]."""
WEIGHTLESS = 1e-4
"""How likely a balancer is on any other joint, beside one on the joint that carries most [-]."""
LIMITS = {"presliding": Shape("rad", 1e-3, 5e-2)}
"""Narrower bounds than an effect's own: less presliding is a nuisance."""


def on_single_joints(kind: type[Effect]) -> bool:
    """Whether an effect can be asked for on each joint in turn: as it is where nobody says more of it."""
    given = all(f.default is not MISSING or f.default_factory is not MISSING for f in fields(kind))
    return issubclass(kind, JointEffect) and given


def on_each_joint(model: Model, name: str) -> Iterator[Candidate]:
    """An effect on each joint in turn, in each shape of its grid."""
    for joint in model.robot.joints:
        for given in GRIDS.get(name, ({},)):
            yield of_effect(model, name, EFFECTS[name](joints=(joint,), **given))  # type: ignore[call-arg]


def dry_frictions(model: Model) -> Iterator[Candidate]:
    """Dry friction of each joint; where the model has none, it turns its sign in some way or other."""
    believed = dry(model, model.believed_values)
    for joint, candidate in enumerate(on_each_joint(model, "coulomb_friction")):
        yield candidate if joint in believed else _turning(model, joint, candidate)


def _turning(model: Model, joint: int, candidate: Candidate) -> Candidate:
    def columns(run: Driven) -> np.ndarray:
        turns = on_motors(model.robot, turning(model, run, joint))
        return np.concatenate([candidate.columns(run), turns], axis=2)

    count = len(REVERSALS) - 1 + len(PRESLIDING)
    return replace(
        candidate,
        columns=columns,
        names=(*candidate.names, *(f"{UNNAMED}{k + 1}" for k in range(count))),
        units=(*candidate.units, *("N m",) * count),
        lower=(*candidate.lower, *(-np.inf,) * count),
        proportion=(1.0, *(REVERSAL_STD,) * count),
        led=1,
    )


def couplings(model: Model) -> Iterator[Candidate]:
    """Motors that also turn with the next joint, one way or the other."""
    joints = model.robot.joints
    for first, second in zip(joints[:-1], joints[1:], strict=True):
        for pair in ((first, second), (second, first)):
            for ratio in RATIOS:
                yield _coupling(model, KinematicCoupling(*pair, ratio=ratio))


def _coupling(model: Model, effect: KinematicCoupling) -> Candidate:
    """With inertia and drag of the shared motor, not without both; products with the ratio have its sign."""
    one, signs = of_effect(model, "kinematic_coupling", effect), np.array([*[np.sign(effect.ratio)] * 2, 1.0])

    def reshaped(given: Mapping[str, Any]) -> Candidate:
        return _coupling(model, replace(effect, **given))

    def products(values: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return signs * values, std

    return replace(
        one,
        columns=lambda run: one.columns(run) * signs,
        lower=(0.0, 0.0, 0.0),
        led=2,
        reshaped=reshaped,
        told_as=products,
    )


def balancers(model: Model) -> Iterator[Candidate]:
    """Springs along a link; only the ratio of the lengths and the angle shape their torque.

    Nobody balances what weighs nothing: how likely one is goes with the weight that a joint carries.
    """
    inertia, load = link_size(model)
    weight = load - inertia
    for joint, share in zip(model.robot.joints, weight / max(float(np.max(weight)), 1e-9), strict=True):
        for ratio in (0.15, 0.3, 0.6):
            for angle in np.arange(-3, 4) * np.pi / 4:
                effect = SpringBalancer(joint, d21=1.0, d22=ratio, phi=float(angle))
                yield _balancer(model, effect, float(share) if share > BALANCED else WEIGHTLESS)


def _balancer(model: Model, effect: SpringBalancer, share: float) -> Candidate:
    """With lengths in proportion to the longer one, which torque does not show."""
    one = of_effect(model, "spring_balancer", effect)

    def reshaped(given: Mapping[str, Any]) -> Candidate:
        return _balancer(model, replace(effect, **given), share)

    bounds = {name: one.bounds[name] for name in ("d22", "phi")}
    return replace(one, bounds=bounds, reshaped=reshaped, prior=one.prior * share)


def of_effect(model: Model, name: str, effect: Effect) -> Candidate:
    """The candidate that an effect is."""
    robot = model.robot
    parameters = effect.parameters(robot)
    own = {f.name for f in fields(effect)}
    waves = () if getattr(effect, "count", 1) > 1 else ("harmonic",)
    shape = {key: float(getattr(effect, key)) for key in (*effect.shapes(), *waves) if key in own}

    def columns(run: Driven) -> np.ndarray:
        return on_motors(robot, effect.regressor(robot, run.motion))

    def reshaped(given: Mapping[str, Any]) -> Candidate:
        return of_effect(model, name, replace(effect, **given))

    return Candidate(
        effect=name,
        joints=_joints(effect, model),
        columns=columns,
        names=tuple(parameter.name for parameter in parameters),
        units=tuple(parameter.unit for parameter in parameters),
        lower=_lower(model, name, parameters),
        shape=shape,
        bounds={key: LIMITS.get(key, bounds) for key, bounds in effect.shapes().items() if key != "reversal"},
        reshaped=reshaped,
        instance=effect,
        prior=_prior(model, parameters),
        cancels=isinstance(effect, (SpringBalancer, JointSpring)),
        size=CABLE if isinstance(effect, JointSpring) else np.inf,
        rows=None if coupled(robot) else _joints(effect, model),
        smooth=effect.smooth,
    )


def _joints(effect: Effect, model: Model) -> tuple[int, ...]:
    robot = model.robot
    if isinstance(effect, KinematicCoupling):
        return tuple(sorted((robot.index(effect.joint), robot.index(effect.other))))
    if isinstance(effect, SpringBalancer):
        return (robot.index(effect.joint),)
    return tuple(effect.columns(robot))  # type: ignore[attr-defined]


def _prior(model: Model, parameters: list[Any]) -> float:
    """A term that the model has on other joints is what is missing most often."""
    kinds = {parameter.name.rstrip("0123456789") for parameter in parameters}
    there = {name.rstrip("0123456789") for name in model.names}
    missing = not {parameter.name for parameter in parameters} & set(model.names)
    return FORGOTTEN if kinds <= there and missing else 1.0


def _lower(model: Model, name: str, parameters: list[Any]) -> tuple[float, ...]:
    """What the model already has may be less than believed; nothing else may be negative."""
    believed = dict(zip(model.names, model.believed_values, strict=True))
    if name in ("viscous_friction", "coulomb_friction", "rotor_inertia"):
        return tuple(-max(float(believed.get(parameter.name, 0.0)), 0.0) for parameter in parameters)
    return tuple(parameter.minimum for parameter in parameters)
