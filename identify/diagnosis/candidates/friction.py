"""Friction of all kinds."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...effects import CoulombFriction, Effect, LoadDependentFriction, Shape
from ...effects.smooth_sign import smooth_sign
from ...model import Model
from ...simulation.plant.gears import link_size
from ..findings.arm import Arm
from ..findings.finding import Finding, Hypothesis
from ..findings.kind import Kind
from ..findings.quantities import together
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from ..runs.rows import REVERSALS
from .parts import by_another, of_effect, on_each_joint, on_motors
from .torque_ripple import MULTIPLES, amplitude

WIDE = (0.04, 0.1, 0.25)
"""Velocity ranges for the reversal of dry friction under film lubrication that are tried [rad/s]."""
WIDEST = 0.3
"""Largest velocity range [rad/s]: a wider one is viscous friction that decreases with speed."""
GRADUAL = "gradual"
PRELOADED = 1.0
"""Preload of teeth and bearings that is tried besides zero, over a joint's usual load [-]."""
MOST_PRELOAD = 3.0
"""Largest preload, over a joint's usual load [-]: beyond it, friction grows with the square of the load."""
EXPONENTS = (1.0, 1.5, 2.0)
"""Exponents of Stribeck friction that are tried [-]: those in the literature, which differ by a tenth."""
DRY = ("Fc", "coulomb_friction Fc", "coulomb_friction Fg", "hysteresis Fh")
"""Unknowns for dry friction of full size, that of the model first; the joint number follows."""
VARYING = 0.3
"""Expected variation of dry friction with position, share of the joint's usual torque [-]: friction always
opposes motion, so it varies by less than its mean. Nothing else limits waves where a joint did not move."""


def _coulomb(model: Model) -> Iterator[Candidate]:
    """Coulomb friction on each joint, more or less than in the model, or with a gradual change of sign."""
    yield from on_each_joint(model, "coulomb_friction", KINDS["coulomb_friction"])
    for joint in range(model.robot.dof):
        for velocity in WIDE:
            yield _gradual(model, joint, velocity)


def _gradual(model: Model, joint: int, velocity: float) -> Candidate:
    """Friction with a gradual change of sign, in place of an equal amount of sudden friction."""
    robot = model.robot
    coulomb = [effect for effect in model.effects if isinstance(effect, CoulombFriction)]
    sudden = [effect for effect in coulomb if not effect.gradual and joint in effect.columns(robot)]

    def also(candidate: Candidate, effect: Effect) -> Candidate:
        assert isinstance(effect, CoulombFriction)

        def columns(run: Driven) -> np.ndarray:
            replaced = (replace(old, joints=effect.joints).regressor(robot, run.motion) for old in sudden)
            return candidate.columns(run) - sum(on_motors(robot, columns) for columns in replaced)

        return replace(
            candidate,
            columns=columns,
            kind=GRADUAL,
            shape={"reversal": effect.reversal},
            bounds={"reversal": Shape("rad/s", REVERSALS[-1], WIDEST)},  # less is a nuisance
        )

    effect = CoulombFriction((robot.joints[joint],), velocity, gradual=True)
    return of_effect(model, "coulomb_friction", effect, KINDS["coulomb_friction"], (joint,), also)


def _with_coulomb(arm: Arm, finding: Hypothesis) -> Arm | None:
    """The arm with this friction; gradual friction replaces an equal amount of sudden friction."""
    effect, joint = finding.term, finding.joints[0]
    assert effect is not None
    more = {name: q.value for name, q in finding.parameters.items() if name.startswith(("Fc", "Fg"))}
    held = arm.with_effect(effect, more)
    sudden = f"Fc{joint + 1}"
    if held is None or finding.kind != GRADUAL or sudden not in held.by_name:
        return held
    return held.with_values({sudden: -more[f"Fg{joint + 1}"]})


def _warming(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Change of dry and viscous friction together at 1 rad/s, which tells whether friction rises."""
    return {"warm": together(known, "Fvt", "Fct")} if "Fvt" in known else {}


def _load_dependent(model: Model) -> Iterator[Candidate]:
    """Load-dependent friction on each joint, with and without a preload of teeth and bearings."""
    robot, loads = model.robot, np.maximum(link_size(model)[1], 0.0)

    def with_preload(candidate: Candidate, effect: Effect) -> Candidate:
        assert isinstance(effect, LoadDependentFriction)
        place = candidate.joints[0]
        bounds = {"preload": Shape(robot.unit(place, "N m"), 0.0, MOST_PRELOAD * float(loads[place]))}
        return replace(candidate, shape={**candidate.shape, "preload": effect.preload}, bounds=bounds)

    name = "load_dependent_friction"
    for candidate in on_each_joint(model, name, KINDS[name], with_preload):
        yield candidate
        load = float(loads[candidate.joints[0]])
        if load > 0.0:
            yield candidate.reshaped({"preload": PRELOADED * load})


def _position_dependent(model: Model) -> Iterator[Candidate]:
    """On each joint, one wave, or a bump of any form, whose harmonics decrease as those of a step do."""

    def smaller(candidate: Candidate, effect: Effect) -> Candidate:
        multiples = range(1, getattr(effect, "count", 1) + 1)
        proportion = tuple(1.0 / multiple for multiple in multiples for _ in range(2))
        dry = tuple(f"{name}{candidate.joints[0] + 1}" for name in DRY)
        return replace(candidate, size=VARYING, proportion=proportion, varies=dry)

    name = "position_dependent_friction"
    return on_each_joint(model, name, KINDS[name], smaller)


def _neighbors(model: Model) -> Iterator[Candidate]:
    """Dry friction of each joint that depends on the position of another joint, which bends its bearing."""

    def torque(run: Driven, joint: int, other: int) -> np.ndarray:
        sign, q = smooth_sign(run.motion.velocity[:, joint]), run.motion.position[:, other]
        return np.stack([sign * np.cos(q), sign * np.sin(q)], axis=1)

    return by_another(model, "neighbour_friction", torque, ("Ncos", "Nsin"))


KINDS = {
    "viscous_friction": Kind(
        family="friction level",
        sentence="{joint} has a viscous friction {Fv:size} {Fv:higher|lower} than in the model",
        drawn_against=("velocity", "speed"),
        reducible=True,
        settled_by="constant speeds up to the limit (exidyn excite --kind sweeps)",
    ),
    "coulomb_friction": Kind(
        family=lambda candidate: "sublinear" if candidate.kind == GRADUAL else "friction level",
        sentence="{joint} has a Coulomb friction[ {Fc:size} {Fc:higher|lower} than in the model][ of which "
        "{Fg} changes its sign][ gradually, over {reversal}]",
        drawn_against=("velocity", "speed"),
        ask=_coulomb,
        reducible=True,
        dry=True,
        held=_with_coulomb,
        settled_by="constant speeds, including low ones (exidyn excite --kind sweeps)",
    ),
    "friction_asymmetry": Kind(
        family="direction",
        sentence="{joint} has asymmetric friction[: {Fa:forwards|backwards} its dry friction is {Fa:size} "
        "above the mean of both directions][, {Fva:forwards|backwards} its viscous friction {Fva:size} above "
        "the mean]",
        drawn_against=("velocity", "position"),
        shapes=({}, {"viscous": True}),
        settled_by="constant speeds both ways (exidyn excite --kind sweeps)",
    ),
    "stribeck_friction": Kind(
        family="low speed",
        sentence="{joint} has Stribeck friction: friction rises by {Fs} towards standstill[, most of which "
        "is gone at {fade}]",
        drawn_against=("speed", "velocity"),
        shapes=tuple(
            {"fade": speed, "exponent": power} for power in EXPONENTS for speed in (0.02, 0.05, 0.12, 0.3)
        ),
        bounds={"exponent": Shape("", EXPONENTS[0], EXPONENTS[-1])},
        dry=True,
        settled_by="constant low speeds (exidyn excite --kind sweeps)",
    ),
    "hysteresis": Kind(
        family="history",
        sentence="{joint} has friction with hysteresis: {Fh} of it builds up[ over about {presliding:mrad}] "
        "after each reversal",
        drawn_against=("velocity", "position"),
        shapes=tuple({"presliding": distance} for distance in (1.5e-3, 4e-3, 1e-2, 2.5e-2)),
        bounds={"presliding": Shape("rad", 1e-3, 5e-2)},  # less is a nuisance
        settled_by="constant low speeds (exidyn excite --kind sweeps)",
    ),
    "nonlinear_viscous_friction": Kind(
        family=lambda candidate: "sublinear" if candidate.shape["exponent"] < 1.0 else "superlinear",
        sentence="{joint} has nonlinear viscous friction[: {Fn} at {one}][, growing with speed to the power "
        "{exponent:bare}]",
        drawn_against=("speed", "velocity"),
        shapes=tuple({"exponent": power} for power in (0.5, 0.8, 1.5, 2.0, 3.0)),
        settled_by="constant speeds up to the limit (exidyn excite --kind sweeps)",
    ),
    "load_dependent_friction": Kind(
        family="load",
        sentence="{joint} has load-dependent friction: Coulomb friction grows by {mu} {effort} per {effort} "
        "that the gear transmits[, where that is far above a preload of {preload}]",
        drawn_against=("size of the load", "velocity"),
        ask=_load_dependent,
        settled_by="a run with a body of known mass on the flange (exidyn excite --mass)",
    ),
    "temperature_dependent_friction": Kind(
        family="temperature",
        sentence="{joint} has friction that {warm:rises|falls} with temperature: viscous friction changes by "
        "{Fvt}[ and Coulomb friction by {Fct}]",
        drawn_against=("temperature", "time"),
        derived=_warming,
        settled_by="the same run again once the arm is warm",
    ),
    "position_dependent_friction": Kind(
        family="position and direction",
        sentence="{joint} has position-dependent friction: it varies by {wave}[, {pace}]",
        drawn_against=("where it brakes", "velocity"),
        ask=_position_dependent,
        shapes=(*({"harmonic": float(k)} for k in (1, 2, 3)), {"count": MULTIPLES}),
        derived=amplitude,
        settled_by="slow sweeps in both directions (exidyn excite --kind sweeps)",
    ),
    "neighbour_friction": Kind(
        family="other joints",
        sentence="{joint} has friction that depends on the position of joint {other_joint:bare}",
        drawn_against=("time", "velocity"),
        ask=_neighbors,
    ),
}
