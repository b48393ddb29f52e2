"""Backlash: while the teeth of a gear change sides, the link floats and the motor does not carry it."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ...effects import Shape
from ...measurements import Backlash, JointElasticity
from ...measurements.backlash import RATIO, TEETH, floating
from ...model import Model
from ...simulation.plant.link_size import link_size
from ..findings.arm import Arm
from ..findings.finding import Hypothesis
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from ..runs.kept import cached
from .joint_elasticity import bending

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


class Play(NamedTuple):
    """Shape of one gear's play."""

    gap: float  # width of the gap [rad]
    load_shift: float = 0.0  # load minus nominal load [N m]
    damping_ratio: float = RATIO  # damping ratio of the link on the teeth [-]
    resonance: float = TEETH  # resonance of the link on the teeth [Hz]


class Gear(NamedTuple):
    """Properties of one joint's gear, apart from its play."""

    model: Model  # model of the arm
    joint: int  # joint, from 0
    stiffness: float  # expected stiffness of the teeth [N m/rad]
    load_uncertainty: float  # error that its load may have [N m]
    bent: Callable[[Driven], np.ndarray]  # motor torque of a run from bending of such teeth, (t, n) [N m]


def plays(model: Model) -> Iterator[Candidate]:
    """Gears of all joints with narrow to wide gaps, on hard teeth and on soft ones."""
    for joint, (inertia, load) in enumerate(zip(*link_size(model), strict=True)):
        if not (inertia > 0.0 and model.robot.geared[joint]):
            continue
        gear = _gear(model, joint, inertia, SHIFT * load)
        yield from (_play(gear, Play(width)) for width in PLAYS)
        twist = load / (inertia * (2 * np.pi * SOFT) ** 2)
        # Soft teeth strike less sharply, so half as many widths suffice.
        visible = [width for width in PLAYS[1::2] if width > VISIBLE * twist]
        yield from (_play(gear, Play(width, resonance=SOFT)) for width in visible)


def _gear(model: Model, joint: int, inertia: float, load_uncertainty: float) -> Gear:
    angular = 2 * np.pi * STIFF
    stiffness = inertia * angular**2

    @cached
    def bent(run: Driven) -> np.ndarray:
        return bending(model, run, joint, (stiffness, 2 * RATIO * inertia * angular))

    return Gear(model, joint, stiffness, load_uncertainty, bent)


def _play(gear: Gear, play: Play) -> Candidate:
    joint, soft = gear.joint, play.resonance < TEETH

    def columns(run: Driven) -> np.ndarray:
        load = run.motion.load[:, joint] + play.load_shift
        weight, drag, inertia = run.tangent.own(joint)
        step = float(np.median(np.diff(run.motion.time)))
        twist = floating((inertia, drag, weight), load, step, play.gap, (play.resonance, play.damping_ratio))
        torque = -run.tangent.torque(joint, *twist) @ gear.model.robot.to_motors.T
        return torque[:, :, None] if soft else np.stack([torque, gear.stiffness * gear.bent(run)], axis=2)

    bounds = {
        "gap": Shape("rad", play.gap / STEP, play.gap * STEP),
        "load_shift": Shape("N m", -gear.load_uncertainty, gear.load_uncertainty),
        "damping_ratio": Shape("1", 0.05, 1.0),
    }
    # Bending of hard teeth has a coefficient of its own; that of soft teeth follows from their resonance.
    names, units = ("share", "compliance"), ("1", "rad/(N m)")
    expected = (1.0, SCATTER), (0.0, 1.0 / gear.stiffness)
    count = 1 if soft else 2
    if soft:
        bounds["resonance"] = Shape("Hz", SOFTEST, TEETH - 1.0)
    return Candidate(
        "backlash", (joint,), columns, names[:count], units[:count], (0.0,) * count,
        {name: getattr(play, name) for name in bounds}, bounds, lambda shape: _play(gear, Play(**shape)),
        expected=expected[:count], loaded=True, prior=BOTH if soft else 1.0,
    )  # fmt: skip


def _held(arm: Arm, finding: Hypothesis) -> Arm:
    """The arm with play in a gear, and with the spring of its teeth."""
    [joint], known = finding.joints, {name: quantity.value for name, quantity in finding.parameters.items()}
    play = Play(**{field: known[field] for field in Play._fields if field in known})
    name, compliance = arm.model.robot.joints[joint], known.get("compliance", 0.0)
    arm = arm.with_measurement(Backlash(name, play.gap, play.damping_ratio, play.load_shift, play.resonance))
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
        mistaken_for=("joint_elasticity", "hysteresis"),
        settled_by="a swept sine (exidyn excite --kind chirp)",
    )
}
