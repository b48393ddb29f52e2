"""Kinematic coupling: a motor that also turns with a neighbor of its joint, u_j = q_j + c q_o.

With u = C q, friction and inertia f(u) of the motors and torque tau(q) of the links, the motor torque is
m = C^-T tau + f(u), from virtual work (C dq)^T m = dq^T tau. What a recording shows depends on what its
controller takes into account:

* Positions and torques of the joints: C^T m = tau + C^T f(C q). Inertia and friction of the motor act on
  both joints.
* Positions of the joints, currents of the motors: the motor of the other joint also carries -c tau_j, but
  no friction of this joint.
* Positions and currents of the motors: the link is displaced, C^-T tau(C^-1 u) instead of tau(u).
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...effects import Effect, KinematicCoupling, Shape
from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Finding, Hypothesis
from ..findings.kind import Kind
from ..questions.candidate import UNNAMED, Candidate
from ..runs.driven import Driven, link_torque
from .parts import coupled, of_effect, on_motors

NAME = "kinematic_coupling"
RATIOS = (-2.0, -1.0, -0.5, -0.2, 0.2, 0.5, 1.0, 2.0)
"""Coupling ratios c that are tried [-]."""
MOVED = (-1.0, -0.5, 0.5, 1.0)
"""Coupling ratios that are tried for displaced links, as of belts and bevel gears [-]."""
TURNS = np.array([0.05, 3.0])
"""Smallest and largest coupling ratio [-]: of a belt that another joint displaces a little, and of a gear."""
SCATTER = 0.1
"""Standard deviation of the coefficient from 1, since the ratio gives the size [-]: the error of bodies."""


def couplings(model: Model) -> Iterator[Candidate]:
    """Motors that also turn with a neighboring joint, in either direction."""
    joints = range(model.robot.dof)
    for first, second in zip(joints[:-1], joints[1:], strict=True):
        for motor, other in ((first, second), (second, first)):
            names = (model.robot.joints[motor], model.robot.joints[other])
            for ratio in RATIOS:
                effect = KinematicCoupling(*names, ratio=ratio)
                yield of_effect(model, NAME, effect, KINDS[NAME], (first, second), _one_motor)
                if not coupled(model.robot):
                    yield _by_motors(model, motor, other, ratio)
            for ratio in MOVED:
                yield _displaced(model, motor, other, ratio)


def _one_motor(candidate: Candidate, effect: Effect) -> Candidate:
    """The candidate with inertia or drag of the shared motor; products with the ratio have its sign."""
    assert isinstance(effect, KinematicCoupling)
    signs = np.array([*[np.sign(effect.ratio)] * 2, 1.0])

    def columns(run: Driven) -> np.ndarray:
        return candidate.columns(run) * signs

    def products(values: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return signs * values, std

    return replace(candidate, columns=columns, lower=(0.0, 0.0, 0.0), led=2, reported_as=products)


def _by_motors(model: Model, motor: int, other: int, ratio: float) -> Candidate:
    """Coupling in a recording with positions of the joints and currents of the motors."""
    effect = KinematicCoupling(model.robot.joints[motor], model.robot.joints[other], ratio=ratio)

    def columns(run: Driven) -> np.ndarray:
        drag = effect.regressor(model.robot, run.motion)
        drag[:, other] = 0.0
        link = np.zeros((*run.torque.shape, 1))
        link[:, other, 0] = -ratio * run.motion.load[:, motor]
        return np.concatenate([link, np.sign(ratio) * drag[:, :, :2], drag[:, :, 2:]], axis=2)

    names, units = zip(*((p.name, p.unit) for p in effect.parameters(model.robot)), strict=True)
    pair = min(motor, other), max(motor, other)
    return Candidate(
        NAME, pair, columns, (UNNAMED, *names), ("1", *units), (0.0,) * 4,
        {"ratio": ratio, "motor": motor + 1.0}, {"ratio": Shape("1", *sorted(np.sign(ratio) * TURNS))},
        lambda shape: _by_motors(model, motor, other, shape["ratio"]), rows=pair,
        expected=((1.0, SCATTER), *((0.0, np.inf),) * 3), loaded=True,
        reported_as=lambda values, std: (values * [1.0, *[np.sign(ratio)] * 2, 1.0], std),
    )  # fmt: skip


def _displaced(model: Model, motor: int, other: int, ratio: float) -> Candidate:
    """Coupling in a recording with positions of the motors, so that the links are displaced."""
    to_joints = np.eye(model.robot.dof)
    to_joints[motor, other] = -ratio

    def columns(run: Driven) -> np.ndarray:
        motion = run.motion
        states = (x @ to_joints.T for x in (motion.position, motion.velocity, motion.acceleration))
        change = link_torque(run.unloaded.bodies, *states) @ to_joints - run.unloaded.of_links
        return on_motors(model.robot, change[:, :, None])

    bounds = {"ratio": Shape("1", ratio - 0.5, ratio + 0.5)}
    return Candidate(
        NAME, (min(motor, other), max(motor, other)), columns, (UNNAMED,), ("1",), (0.0,),
        {"ratio": ratio, "moved": motor + 1.0}, bounds,
        lambda shape: _displaced(model, motor, other, shape["ratio"]), smooth=True,
        expected=((1.0, SCATTER),), carried=True,
    )  # fmt: skip


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Number of the displaced link, or of the joint whose motor turns with both."""
    words = (("link", "moved"), ("turning", "motor"))
    return {word: f"{known[name].value:.0f}" for word, name in words if name in known}


def _held(arm: Arm, finding: Hypothesis) -> Arm | None:
    """The arm with the effect, and with its coupling if motors carry other torques than their joints.

    A joint that moves alone then also turns the other motor, in proportion to the coupling.
    """
    values = finding.numbers
    if finding.term is not None:
        names = [parameter.name for parameter in finding.term.parameters(arm.model.robot)]
        return arm.with_effect(finding.term, {name: values[name] for name in names})
    if "motor" not in values:
        return None
    motor, ratio = round(values["motor"]) - 1, values["ratio"]
    [other] = set(finding.joints) - {motor}
    coupling = arm.model.robot.coupling.copy()
    coupling[motor, other] += ratio
    held = arm.on(replace(arm.model.robot, coupling=coupling))
    robot = held.model.robot
    effect = KinematicCoupling(robot.joints[motor], robot.joints[other], ratio=ratio)
    more = {parameter.name: values[parameter.name] for parameter in effect.parameters(robot)}
    terms = zip(("Ia", "Fv", "Fc"), more.values(), (ratio, ratio, abs(ratio)), strict=True)
    alone = {f"{kind}{other + 1}": share * value for kind, value, share in terms}
    with_pair = held.with_effect(effect, more)
    return None if with_pair is None else with_pair.with_values(alone)


KINDS = {
    NAME: Kind(
        family="other joints",
        sentence="{joint} and {other} are kinematically coupled: the motor of either also turns with the "
        "other[, {ratio:bare} times as far][; the recorded position of joint {link} is that of its motor, "
        "and the link stands elsewhere][; the motor of joint {turning} turns with both, and the recorded "
        "currents are those of the motors]",
        drawn_against=("velocity", "acceleration"),
        ask=couplings,
        derived=_derived,
        held=_held,
        settled_by="one joint at a time (exidyn excite --kind single-joint)",
    )
}
