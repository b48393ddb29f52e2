"""Kinematic coupling: a motor that also turns with a neighbour of its joint."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...effects import Effect, KinematicCoupling
from ...model import Model
from ..candidate import Candidate
from ..driven import Driven
from ..kind import Kind
from .parts.of_effect import of_effect

RATIOS = (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0)
"""Turns of a motor with its neighbour for one with its own joint that are tried [-]."""


def couplings(model: Model) -> Iterator[Candidate]:
    """Motors that also turn with the next joint, one way or the other."""
    joints = range(model.robot.dof)
    for first, second in zip(joints[:-1], joints[1:], strict=True):
        for pair in ((first, second), (second, first)):
            for ratio in RATIOS:
                motor, other = (model.robot.joints[joint] for joint in pair)
                effect = KinematicCoupling(motor, other, ratio=ratio)
                yield of_effect(model, "kinematic_coupling", effect, KIND, (first, second), _one_motor)


def _one_motor(candidate: Candidate, effect: Effect) -> Candidate:
    """With inertia and drag of the shared motor, not without both; products with the ratio have its sign."""
    assert isinstance(effect, KinematicCoupling)
    signs = np.array([*[np.sign(effect.ratio)] * 2, 1.0])

    def columns(run: Driven) -> np.ndarray:
        return candidate.columns(run) * signs

    def products(values: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return signs * values, std

    return replace(candidate, columns=columns, lower=(0.0, 0.0, 0.0), led=2, told_as=products)


KIND = Kind(
    sentence="{joint} and {other} are kinematically coupled: the motor of either also turns with the "
    "other[, {ratio:bare} times as far]",
    drawn_against=("velocity", "acceleration"),
    ask=couplings,
    mistaken_for=("rotor_inertia", "viscous_friction"),
)
