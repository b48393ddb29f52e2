"""Coulomb friction other than in the model: more or less of it, or some that changes its sign gradually."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...effects import CoulombFriction, Effect, Shape
from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from ..runs.rows import REVERSALS
from .parts.motors import on_motors
from .parts.of_effect import of_effect, on_each_joint

WIDE = (0.04, 0.1, 0.25)
"""Velocities over which dry friction may change its sign that are tried [rad/s]: film lubrication."""
WIDEST = 0.3
"""The largest [rad/s]: what needs more is viscous friction that becomes less."""
GRADUAL = "gradual"


def frictions(model: Model) -> Iterator[Candidate]:
    """On each joint, more or less than in the model, and what changes its sign gradually."""
    yield from on_each_joint(model, "coulomb_friction", KIND)
    for joint in range(model.robot.dof):
        for velocity in WIDE:
            yield _gradual(model, joint, velocity)


def _gradual(model: Model, joint: int, velocity: float) -> Candidate:
    """Friction that changes its sign gradually, in the place of as much that does so at once in the model."""
    robot, sudden = model.robot, _sudden(model, joint)

    def also(candidate: Candidate, effect: Effect) -> Candidate:
        assert isinstance(effect, CoulombFriction)

        def columns(run: Driven) -> np.ndarray:
            instead = (replace(one, joints=effect.joints).regressor(robot, run.motion) for one in sudden)
            return candidate.columns(run) - sum(on_motors(robot, one) for one in instead)

        return replace(
            candidate,
            columns=columns,
            kind=GRADUAL,
            shape={"reversal": effect.reversal},
            bounds={"reversal": Shape("rad/s", REVERSALS[-1], WIDEST)},  # less is a nuisance
        )

    effect = CoulombFriction((robot.joints[joint],), velocity, gradual=True)
    return of_effect(model, "coulomb_friction", effect, KIND, (joint,), also)


def _sudden(model: Model, joint: int) -> list[CoulombFriction]:
    """The Coulomb friction of a joint that changes its sign at once, if the model has any."""
    dry = [one for one in model.effects if isinstance(one, CoulombFriction) and not one.gradual]
    return [one for one in dry if joint in one.columns(model.robot)]


def _held(arm: Arm, finding: Finding) -> Arm | None:
    """With more of it; what changes its sign gradually is not there as what does so at once."""
    effect, joint = finding.candidate.instance, finding.joints[0]
    assert effect is not None
    more = {name: q.value for name, q in finding.parameters.items() if name.startswith(("Fc", "Fg"))}
    held = arm.with_effect(effect, more)
    sudden = f"Fc{joint + 1}"
    if held is None or finding.candidate.kind != GRADUAL or sudden not in held.by_name:
        return held
    return held.with_values({sudden: -more[f"Fg{joint + 1}"]})


KIND = Kind(
    sentence="{joint} has a Coulomb friction[ {Fc:size} {Fc:higher|lower} than in the model][ of which {Fg} "
    "changes its sign][ gradually, over {reversal}]",
    drawn_against=("velocity", "speed"),
    ask=frictions,
    reducible=True,
    dry=True,
    held=_held,
    mistaken_for=("stribeck_friction", "load_dependent_friction", "hysteresis"),
)
