"""Backlash: while the teeth of a gear change sides, its link floats and no motor carries it."""

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
from ..runs.kept import kept
from .gears import bending

STEP = 1.5
"""From one width to the next that is tried [-]."""
PLAYS = tuple(1.2e-4 * STEP**step for step in range(16))
"""Whole width of the play [rad], up to 3 degrees: a good gear has 0.3 mrad, a worn one some. How long a link
floats grows with its cube root, so that each is right within 7 %, some milliseconds."""
SCATTER = 0.15
"""Deviation of the coefficient from 1, since the play gives the size of the effect [-]."""
STIFF = 60.0
"""Resonance of a link on teeth that are as soft as they are expected to be [Hz]: their bending, far below
it, is in proportion to their compliance."""
NOTHING = 0.01
"""Compliance of teeth over that expected, up to which they are rigid [-]: it explains nothing."""
SOFT = 16.0
"""Resonance of a link on soft teeth that is tried [Hz]: between an elastic gear and hard teeth."""
SOFTEST = 8.0
"""Least resonance of a link on its teeth [Hz]: on softer ones no drive holds its arm."""
VISIBLE = 1.0
"""Width of a play over the usual twist of soft teeth from which on it shows beside that twist [-]."""
BOTH = 0.05
"""How likely a gear is to give way and have play too, beside one that only gives way [-]: it always fits as
well, and must show its play to be named."""
SHIFT = 0.05
"""Share of a joint's usual load by which the nominal load may be wrong [-]; a few thousandths, where it
changes slowly, make a link float sooner or later by the time that it floats."""


class Play(NamedTuple):
    """Shape of one gear's play: its width [rad], what the load is more than nominal [N m], and its teeth."""

    gap: float
    load_shift: float = 0.0
    damping_ratio: float = RATIO
    resonance: float = TEETH


class Gear(NamedTuple):
    """One joint: what is known of it before its play."""

    model: Model  # the arm
    joint: int  # which, from 0
    stiffness: float  # expected of the teeth [N m/rad]
    load_uncertainty: float  # how wrong its load may be [N m]
    bent: Callable[[Driven], np.ndarray]  # motors' torque in a run for teeth of that stiffness, (t, n) [N m]


def plays(model: Model) -> Iterator[Candidate]:
    """Every joint's gear with little and with much play, on hard teeth and on soft ones."""
    for joint, (inertia, load) in enumerate(zip(*link_size(model), strict=True)):
        if not (inertia > 0.0 and model.robot.geared[joint]):
            continue
        gear = _gear(model, joint, inertia, SHIFT * load)
        yield from (_play(gear, Play(width)) for width in PLAYS)
        twist = load / (inertia * (2 * np.pi * SOFT) ** 2)
        # Soft teeth strike less sharply, so that half as many widths will do.
        visible = [width for width in PLAYS[1::2] if width > VISIBLE * twist]
        yield from (_play(gear, Play(width, resonance=SOFT)) for width in visible)


def _gear(model: Model, joint: int, inertia: float, load_uncertainty: float) -> Gear:
    angular = 2 * np.pi * STIFF
    stiffness = inertia * angular**2

    @kept
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
    # What bends beyond hard teeth has a coefficient of its own; soft ones bend by their resonance.
    names, units = ("share", "compliance"), ("1", "rad/(N m)")
    expected = (1.0, SCATTER), (0.0, 1.0 / gear.stiffness)
    count = 1 if soft else 2
    if soft:
        bounds["resonance"] = Shape("Hz", SOFTEST, TEETH - 1.0)
    return Candidate(
        "backlash", (joint,), columns, names[:count], units[:count], (0.0,) * count,
        {name: getattr(play, name) for name in bounds}, bounds, lambda given: _play(gear, Play(**given)),
        expected=expected[:count], loaded=True, prior=BOTH if soft else 1.0,
    )  # fmt: skip


def _held(arm: Arm, finding: Hypothesis) -> Arm:
    """A gear with play, and the spring that its teeth are."""
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
