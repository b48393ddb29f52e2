"""Joint elasticity: a gear that gives way, on which its link lags behind the motor, and swings.

With motors where their encoders measure, every link but one follows its motor, and that one leads or lags
by a twist whose equation is row j of the arm's: M_jj twist'' + d twist' + (K + dtau_j/dq_j) twist = load_j.
What all motors give for it more than for a rigid gear is minus the links' torque for a twist. The stiffness
shapes it: little matters below the resonance but the load over the stiffness, and near it the link's own
swing.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from ...effects import Shape
from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..questions.candidate_fit import FORMULA, STRANGE
from ..runs.driven import Driven
from .parts.gears import bending, link_size

STEP = 1.3
"""From one resonance to the next that is tried [-]."""
RESONANCES = tuple(3.0 * STEP**step for step in range(12))
"""Of the mean link on its gear [Hz], up to 54: below, no drive holds its arm; above, the fastest motion
twists its gears by less than a fifteenth of a link's acceleration."""
RATIO = (STEP - 1.0) / 2.0
"""Damping ratio of the first look [-], 0.02 for steel and 0.2 for much grease: the width of a resonance,
twice its damping ratio, is the step to the next that is tried, so that no gear lies between two."""
SCATTER = 0.1
"""Of the coefficient around 1, since the stiffness gives the size of the effect [-]: as much as link's
inertia and damping are wrong."""
LEAST = 0.5
"""Coefficient below which what fits is something else that swings [-]."""


def gears(model: Model) -> Iterator[Candidate]:
    """Every joint's gear, from soft to stiff."""
    for joint, inertia in enumerate(link_size(model)[0]):
        # A joint that moves nothing has nothing to bend.
        for resonance in RESONANCES if inertia > 0.0 and model.robot.geared[joint] else ():
            yield _gear(model, joint, inertia, resonance, RATIO)


def _gear(
    model: Model, joint: int, inertia: float, resonance: float, ratio: float, within: Shape | None = None
) -> Candidate:
    """A gear whose mean link has that resonance [Hz]; refined about it, or within bounds."""
    angular = 2 * np.pi * resonance
    stiffness, loss = inertia * angular**2, 2 * ratio * inertia * angular

    def columns(run: Driven) -> np.ndarray:
        return bending(model, run, joint, (stiffness, loss))[:, :, None]

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return _gear(model, joint, inertia, given["resonance"], given["damping_ratio"], within)

    return Candidate(
        "joint_elasticity",
        (joint,),
        columns,
        ("share",),
        ("1",),
        (LEAST,),
        {"resonance": resonance, "damping_ratio": ratio, "stiffness": stiffness},
        {
            "resonance": within or Shape("Hz", resonance / STEP, resonance * STEP),
            "damping_ratio": Shape("1", 0.005, 0.5),
        },
        reshaped,
        expected=((1.0, SCATTER),),
        reported={"stiffness": (stiffness, "N m/rad")},
        loaded=True,
    )


def of_stiffness(model: Model, joint: int, stiffness: float, std: float) -> Candidate:
    """The gear of a stiffness that was measured, with its standard deviation [N m/rad]; refined within it."""
    inertia = max(float(link_size(model)[0][joint]), 1e-9)
    share = min(max(STRANGE * std / stiffness, FORMULA), 1.0 - FORMULA)
    least, resonance, most = np.sqrt(stiffness * np.array([1.0 - share, 1.0, 1.0 + share]) / inertia) / (
        2 * np.pi
    )
    return _gear(model, joint, inertia, float(resonance), RATIO, Shape("Hz", float(least), float(most)))


def _held(arm: Arm, finding: Finding) -> Arm:
    """A gear that gives way; the more of the effect was found, the softer it is."""
    known = {name: quantity.value for name, quantity in finding.parameters.items()}
    stiffness = known["stiffness"] / max(known["share"], 0.1)
    damping = 2 * known["damping_ratio"] * stiffness / (2 * np.pi * known["resonance"])
    return arm.with_gear(finding.joints[0], stiffness, damping, 0.0)


KIND = Kind(
    sentence="{joint} has an elastic gear[: {stiffness}][, resonant at {resonance}]",
    drawn_against=("acceleration", "load"),
    ask=gears,
    held=_held,
    gear=True,
    mistaken_for=("backlash", "time_delay", "rotor_inertia"),
    settled_by="a swept sine (exidyn excite --kind chirp)",
)
