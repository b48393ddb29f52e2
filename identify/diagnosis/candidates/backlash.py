"""Backlash: while the teeth of a gear change sides, the link floats and the motor does not carry it."""

from collections.abc import Callable, Iterator
from dataclasses import fields
from typing import NamedTuple

import numpy as np

from ...effects import Shape
from ...measurements import Backlash, JointElasticity
from ...measurements.gears import RATIO, TEETH
from ...model import Model
from ...simulation.plant.gears import link_size
from ..findings.arm import Arm
from ..findings.finding import Hypothesis
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven, cached
from .joint_elasticity import gear_torque

STEP = 1.5
"""Ratio between successive widths [-]."""
PLAYS = tuple(1.2e-4 * STEP**step for step in range(16))
"""Widths of the gap that are tried [rad], up to 3 degrees: a good gear has 0.3 mrad, a worn one a few. The
time that a link floats grows with the cube root, so the grid is within 7 %, a few milliseconds."""
SCATTER = 0.15
"""Standard deviation of the coefficient from 1, since the gap gives the size of the effect [-]."""
STIFF = 60.0
"""Resonance of a link on teeth of the expected stiffness [Hz]: far below it, bending is proportional to
compliance."""
NOTHING = 0.01
"""Compliance of teeth, relative to the expected one, up to which they count as rigid [-]."""
SOFT = 16.0
"""Resonance of a link on soft teeth [Hz]: between an elastic gear and hard teeth."""
SOFTEST = 8.0
"""Lowest resonance of a link on its teeth [Hz]: with softer teeth, no drive can control the arm."""
VISIBLE = 1.0
"""Width of a gap, relative to the usual twist of soft teeth, above which it is visible [-]."""
BOTH = 0.05
"""Prior weight of a gear that is soft and has play, relative to one that is only soft [-]: it always fits at
least as well, so its play must be visible to be named."""
SHIFT = 0.05
"""Error of the nominal load, share of a joint's usual load [-]; where the load changes slowly, an error of a
few thousandths shifts the float by its own duration."""


class Teeth(NamedTuple):
    """Expected teeth of one joint's gear."""

    stiffness: float  # stiffness [N m/rad]
    load_uncertainty: float  # error that the load of the gear may have [N m]
    bent: Callable[[Driven], np.ndarray]  # motor torque of a run from their bending, shape (t, n) [N m]


def plays(model: Model) -> Iterator[Candidate]:
    """Gears of all joints with narrow to wide gaps, on hard teeth and on soft ones."""
    for joint, (inertia, load) in enumerate(zip(*link_size(model), strict=True)):
        if not (inertia > 0.0 and model.robot.geared[joint]):
            continue
        name, teeth = model.robot.joints[joint], _teeth(model, joint, inertia, SHIFT * load)
        yield from (_play(model, Backlash(name, width), teeth) for width in PLAYS)
        twist = load / (inertia * (2 * np.pi * SOFT) ** 2)
        # Soft teeth strike less sharply, so half as many widths suffice.
        visible = [width for width in PLAYS[1::2] if width > VISIBLE * twist]
        yield from (_play(model, Backlash(name, width, resonance=SOFT), teeth) for width in visible)


def _teeth(model: Model, joint: int, inertia: float, load_uncertainty: float) -> Teeth:
    angular = 2 * np.pi * STIFF
    stiffness = inertia * angular**2
    gear = JointElasticity(model.robot.joints[joint], stiffness, 2 * RATIO * inertia * angular)
    return Teeth(stiffness, load_uncertainty, cached(lambda run: gear_torque(model, run, gear)))


def _play(model: Model, play: Backlash, teeth: Teeth) -> Candidate:
    soft = play.resonance < TEETH

    def columns(run: Driven) -> np.ndarray:
        torque = gear_torque(model, run, play)
        return torque[:, :, None] if soft else np.stack([torque, teeth.stiffness * teeth.bent(run)], axis=2)

    bounds = {
        "gap": Shape("rad", play.gap / STEP, play.gap * STEP),
        "load_shift": Shape("N m", -teeth.load_uncertainty, teeth.load_uncertainty),
        "damping_ratio": Shape("1", 0.05, 1.0),
    }
    # Bending of hard teeth has a coefficient of its own; that of soft teeth follows from their resonance.
    names, units = ("share", "compliance"), ("1", "rad/(N m)")
    expected = (1.0, SCATTER), (0.0, 1.0 / teeth.stiffness)
    count = 1 if soft else 2
    if soft:
        bounds["resonance"] = Shape("Hz", SOFTEST, TEETH - 1.0)
    return Candidate(
        "backlash", (model.robot.index(play.joint),), columns, names[:count], units[:count], (0.0,) * count,
        {name: getattr(play, name) for name in bounds}, bounds,
        lambda shape: _play(model, Backlash(play.joint, **shape), teeth),
        expected=expected[:count], loaded=True, prior=BOTH if soft else 1.0,
    )  # fmt: skip


def _held(arm: Arm, finding: Hypothesis) -> Arm:
    """The arm with play in a gear, and with the spring of its teeth."""
    [joint], known = finding.joints, finding.numbers
    name, compliance = arm.model.robot.joints[joint], known.get("compliance", 0.0)
    shape = {field.name: known[field.name] for field in fields(Backlash) if field.name in known}
    arm = arm.with_measurement(Backlash(name, **shape))
    inertia = float(link_size(arm.model)[0][joint])
    if not compliance * inertia * (2 * np.pi * STIFF) ** 2 > NOTHING:
        return arm
    damping = 2 * RATIO / (compliance * 2 * np.pi * STIFF)
    return arm.with_measurement(JointElasticity(name, 1.0 / compliance, damping))


KINDS = {
    "backlash": Kind(
        family="elasticity",
        sentence="{joint} has backlash in its gear[: {gap:mrad}][, on teeth resonant at {resonance}]",
        drawn_against=("load", "acceleration"),
        ask=plays,
        held=_held,
        gear=True,
        settled_by="a swept sine (exidyn excite --kind chirp)",
    )
}
