"""Spring balancer: a spring along a link that carries part of the arm's weight."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...effects import Effect, SpringBalancer
from ...model import Model
from ...text_table import digits
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from .parts.gears import link_size
from .parts.of_effect import of_effect

BALANCED = 0.05
"""Weight that a joint carries over the most that one does, from which on it may have a balancer [-]."""

RATIOS = (0.15, 0.3, 0.6)
"""Shorter of the two lengths over the longer that are tried [-]."""
ANGLES = np.arange(-5, 7) * np.pi / 6
"""Angles between them that are tried [rad]: the mean over coarser ones is nats below that over all angles."""


def balancers(model: Model) -> Iterator[Candidate]:
    """Springs along a link; only the ratio of the lengths and the angle shape their torque.

    Its probability increases with the weight that a joint carries. A joint without any has none: what depends
    on the position of a wrist's roll is something else.
    """
    inertia, load = link_size(model)
    weight = load - inertia
    share = weight / max(float(np.max(weight)), 1e-9)
    for joint in np.flatnonzero(share > BALANCED):

        def also(candidate: Candidate, effect: Effect, likely: float = float(share[joint])) -> Candidate:
            # Lengths are in proportion to the longer one, which torque does not show.
            bounds = {name: candidate.bounds[name] for name in ("d22", "phi")}
            return replace(candidate, bounds=bounds, prior=candidate.prior * likely, cancels=True)

        for ratio in RATIOS:
            for angle in ANGLES:
                effect = SpringBalancer(model.robot.joints[joint], d21=1.0, d22=ratio, phi=float(angle))
                yield of_effect(model, "spring_balancer", effect, KIND, (int(joint),), also)


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    ends = {name: digits(finding.parameters[name].value) for name in ENDS if name in finding.parameters}
    return {"rms": f"{np.max(finding.torque, initial=0.0):.3g}", **ends}


ENDS = ("torque_least", "torque_most")
"""Over the range that was recorded."""
STIFFNESS, PRELOAD, LEVERS = "Kr*d21^2", "K0*d21", "d22/d21"
"""What torque shows of a spring, whose lengths are in proportion to `d21`: products, and a ratio."""

KIND = Kind(
    sentence="{joint} has a spring balancer along the arm that the model does not have[: it gives {rms} "
    "{effort}, root mean square][, from {torque_least} to {torque_most} {effort} over the recorded range]",
    drawn_against=("position", "load"),
    ask=balancers,
    derived=_derived,
    of_body=True,
    determined_as={"Kr": (STIFFNESS, "N m"), "K0": (PRELOAD, "N m"), "d22": (LEVERS, "1"), "d21": ("", "")},
    remark="Torque shows a spring's lengths up to scale. With d21 from the drawing, the distance of its "
    f"fixed end from the axis, K_r is {STIFFNESS} over d21 squared [N/m], K_0 is {PRELOAD} over d21 [N], and "
    f"d22 is {LEVERS} times d21 [m]",
    mistaken_for=("link_inertia", "joint_spring"),
    settled_by="the base at another tilt: no motion of the joints distinguishes a spring from a weight well",
)
