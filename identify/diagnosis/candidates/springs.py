"""Springs: a balancer along a link, a cable or hose along a joint, and a hose that pulls the flange."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...effects import Effect, SpringBalancer
from ...model import Model
from ...simulation.plant.gears import link_size
from ...text_table import NORMAL_95, digits
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..findings.quantities import Formatted
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .contact_event import flange
from .parts import RARE, of_effect, on_each_joint, on_motors

BALANCED = 0.05
"""Weight that a joint must carry to have a balancer, relative to the largest of all joints [-]."""
RATIOS = (0.15, 0.3, 0.6)
"""Ratios of the shorter length to the longer one that are tried [-]."""
ANGLES = np.arange(-5, 7) * np.pi / 6
"""Angles between the two lengths that are tried [rad]; a coarser grid would lose several nats of evidence."""
ENDS = ("torque_least", "torque_most")
"""Names of the torque at both ends of the recorded range."""
STIFFNESS, PRELOAD, LEVERS = "Kr*d21^2", "K0*d21", "d22/d21"
"""Quantities of a spring that torque determines: lengths only relative to `d21`."""
CABLE = 0.1
"""Expected torque of a hose or cable, share of a joint's usual torque [-]."""
SPRING = 1.0
"""Expected torque of a spring that is there on purpose, share of a joint's usual torque [-]."""
TURN = 2 * np.pi
"""Width of an interval that says nothing about a joint's angle [rad]."""
REACH = 1.5
"""Expected distance of a hose's fixed end from the base [m]; evidence depends only on its logarithm."""


def balancers(model: Model) -> Iterator[Candidate]:
    """Springs along a link; only the ratio of the lengths and the angle shape their torque.

    Their prior increases with the weight that a joint carries. A joint that carries none has no balancer:
    torque that depends on the position of a wrist roll has another cause.
    """
    inertia, load = link_size(model)
    weight = load - inertia
    share = weight / max(float(np.max(weight)), 1e-9)
    for joint in np.flatnonzero(share > BALANCED):

        def also(candidate: Candidate, effect: Effect, likely: float = float(share[joint])) -> Candidate:
            # Torque does not determine the longer length, to which all others are relative.
            bounds = {name: candidate.bounds[name] for name in ("d22", "phi")}
            return replace(candidate, bounds=bounds, prior=candidate.prior * likely, cancels=True)

        for ratio in RATIOS:
            for angle in ANGLES:
                effect = SpringBalancer(model.robot.joints[joint], d21=1.0, d22=ratio, phi=float(angle))
                kind = KINDS["spring_balancer"]
                yield of_effect(model, "spring_balancer", effect, kind, (int(joint),), also)


def _balancing(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    ends = {name: digits(finding.parameters[name].value) for name in ENDS if name in finding.parameters}
    return {"rms": digits(float(np.max(finding.torque_rms, initial=0.0)), 3), **ends}


def _cables(model: Model) -> Iterator[Candidate]:
    """Springs on each joint, as weak as cables or as strong as the motor, some stiffening as they stretch."""
    for size in (CABLE, SPRING):

        def sized(candidate: Candidate, effect: Effect, size: float = size) -> Candidate:
            return replace(candidate, cancels=True, size=size)

        yield from on_each_joint(model, "joint_spring", KINDS["joint_spring"], sized)


def _pulling(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Stiffness and relaxed angle of a spring; its torque if the stiffness is not constant."""
    if "Kc" in known:
        return {"stiffer": digits(float(np.max(finding.torque_rms, initial=0.0)), 3)}
    words = {"spring": known["Ks"]} if "Ks" in known else {}
    if "Ts" in known and "Ks" in known and known["Ks"].value > 0:
        stiffness, torque = known["Ks"].value, known["Ts"]
        ease = Formatted(-torque.value / stiffness, torque.std / stiffness, "rad")
        # With a free offset in the fit, the runs may not determine this angle at all.
        words |= {"ease": ease} if NORMAL_95 * ease.std < TURN else {}
    return words


def _hoses(model: Model) -> Iterator[Candidate]:
    """A hose or dress pack fixed anywhere, which pulls the flange in proportion to the distance."""
    robot = model.robot

    def columns(run: Driven) -> np.ndarray:
        places, pushed = flange(model, run.motion)
        stretched = np.einsum("tnk,tk->tn", pushed, places)
        return on_motors(robot, np.concatenate([stretched[:, :, None], -pushed], axis=2))

    names, lower = ("stiffness", "pull_x", "pull_y", "pull_z"), (0.0, *(-np.inf,) * 3)
    yield Candidate(
        "hose_spring", (), columns, names, ("N/m", "N", "N", "N"), lower, smooth=True,
        proportion=(1.0, REACH, REACH, REACH), led=1, prior=RARE, listed=False,
    )  # fmt: skip


KINDS = {
    "spring_balancer": Kind(
        family="position",
        sentence="{joint} has a spring balancer along the arm that the model does not have[: it gives "
        "{rms} {effort}, root mean square][, from {torque_least} to {torque_most} {effort} over the recorded "
        "range]",
        drawn_against=("position", "load"),
        ask=balancers,
        derived=_balancing,
        of_body=True,
        determined_as={
            "Kr": (STIFFNESS, "N m"),
            "K0": (PRELOAD, "N m"),
            "d22": (LEVERS, "1"),
            "d21": ("", ""),
        },
        remark="Torque shows a spring's lengths up to scale. With d21 from the drawing, the distance of its "
        f"fixed end from the axis, K_r is {STIFFNESS} over d21 squared [N/m], K_0 is {PRELOAD} over d21 [N], "
        f"and d22 is {LEVERS} times d21 [m]",
        settled_by="the base at another tilt: no motion of the joints distinguishes a spring from a weight "
        "well",
    ),
    "joint_spring": Kind(
        family="position",
        sentence="{joint} has a spring that the model does not have, such as a cable or hose[: {spring}][, "
        "relaxed at {ease}][: it gives {stiffer} {effort}, root mean square, and stiffens as it "
        "stretches]",
        drawn_against=("position", "load"),
        ask=_cables,
        shapes=({}, {"stiffening": True}),
        derived=_pulling,
        settled_by="slow sweeps over the whole range (exidyn excite --kind sweeps)",
    ),
    "hose_spring": Kind(
        sentence="A spring pulls the flange towards one point, as hoses and dress packs do[: {stiffness}]",
        drawn_against=("position", "load"),
        ask=_hoses,
        of_body=True,
    ),
}
