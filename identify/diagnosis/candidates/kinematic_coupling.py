"""Kinematic coupling: a motor that also turns with a neighbour of its joint.

Where a controller takes that into account, positions are those of the joints, and only inertia and friction
of the motor reach both. Where it does not, the position recorded is that of the motor: the link stands
elsewhere, and its torque pulls at both motors. With motor angles u = C q that is C^-T tau(C^-1 u) in place of
tau(u).
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...effects import Effect, KinematicCoupling, Shape
from ...model import Model
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..questions.candidate import UNNAMED, Candidate
from ..runs.driven import Driven, link_torque
from .parts import of_effect, on_motors

NAME = "kinematic_coupling"
RATIOS = (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0)
"""Turns of a motor with its neighbour for one with its own joint that are tried [-]."""
MOVED = (-1.0, -0.5, 0.5, 1.0)
"""Turns that are tried where links stand elsewhere: belts and bevel gears."""
SCATTER = 0.1
"""Deviation of the coefficient from 1, as the ratio gives the size of the effect [-]: bodies are as wrong."""


def couplings(model: Model) -> Iterator[Candidate]:
    """Motors that also turn with the next joint, one way or the other."""
    joints = range(model.robot.dof)
    for first, second in zip(joints[:-1], joints[1:], strict=True):
        for motor, other in ((first, second), (second, first)):
            names = (model.robot.joints[motor], model.robot.joints[other])
            for ratio in RATIOS:
                effect = KinematicCoupling(*names, ratio=ratio)
                yield of_effect(model, NAME, effect, KINDS[NAME], (first, second), _one_motor)
            for ratio in MOVED:
                yield _elsewhere(model, motor, other, ratio)


def _one_motor(candidate: Candidate, effect: Effect) -> Candidate:
    """With inertia and drag of the shared motor, not without both; products with the ratio have its sign."""
    assert isinstance(effect, KinematicCoupling)
    signs = np.array([*[np.sign(effect.ratio)] * 2, 1.0])

    def columns(run: Driven) -> np.ndarray:
        return candidate.columns(run) * signs

    def products(values: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return signs * values, std

    return replace(candidate, columns=columns, lower=(0.0, 0.0, 0.0), led=2, reported_as=products)


def _elsewhere(model: Model, motor: int, other: int, ratio: float) -> Candidate:
    """Links that stand where the joints are, and positions that are those of the motors."""
    back = np.eye(model.robot.dof)
    back[motor, other] = -ratio

    def columns(run: Driven) -> np.ndarray:
        motion = run.motion
        states = (one @ back.T for one in (motion.position, motion.velocity, motion.acceleration))
        more = link_torque(run.bodies, *states) @ back - run.of_links
        return on_motors(model.robot, more[:, :, None])

    bounds = {"ratio": Shape("1", ratio - 0.5, ratio + 0.5)}
    return Candidate(
        NAME, (min(motor, other), max(motor, other)), columns, (UNNAMED,), ("1",), (0.0,),
        {"ratio": ratio, "moved": motor + 1.0}, bounds,
        lambda given: _elsewhere(model, motor, other, given["ratio"]), smooth=True,
        expected=((1.0, SCATTER),), carried=True,
    )  # fmt: skip


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Which link stands elsewhere."""
    return {"link": f"{known['moved'].value:.0f}"} if "moved" in known else {}


KINDS = {
    NAME: Kind(
        family="other joints",
        sentence="{joint} and {other} are kinematically coupled: the motor of either also turns with the "
        "other[, {ratio:bare} times as far][; the recorded position of joint {link} is that of its motor, "
        "and the link stands elsewhere]",
        drawn_against=("velocity", "acceleration"),
        ask=couplings,
        derived=_derived,
        mistaken_for=("rotor_inertia", "viscous_friction"),
    )
}
