"""An honest belief about a real arm: a fit to some of its runs, and how far that is trusted on others."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from diagnose_real_arms import Arm
from exidyn.identify.effects import EFFECTS, Belief
from exidyn.identify.effects.rigid_body import body_inertia
from exidyn.identify.estimators import consistent, posterior
from exidyn.identify.fit import Fit
from exidyn.identify.identification import identify
from exidyn.identify.model import Model
from exidyn.identify.recording import Recording
from exidyn.identify.rigid_regressor import INERTIAL
from real_payload import KNOWN, REVERSAL, loaded

NAMES = {"coulomb_friction": "Fc", "viscous_friction": "Fv", "rotor_inertia": "Ia"}
"""Effect of a joint that the belief holds -> beginning of its parameter's name."""
TOLERANCE = {"coulomb_friction": 0.2, "viscous_friction": 0.2, "rotor_inertia": 0.1}
"""Relative standard deviation of what was fitted, as in the sample cases. That of the fit itself is far
smaller and wrong on another day: friction follows the oil's temperature, and what real gears do that the law
does not say is laid on its parameters, on each motion otherwise; the table of scatter says how far. A fitted
zero is no belief: a share of it says nothing."""


def believe(arm: Arm, known: tuple[str, float] | None, as_drawn: bool = False) -> Model:
    """The model fitted to the arm's runs, with tolerances.

    Args:
        arm: With the runs.
        known: Run with a body of known mass [kg] for the drive gains; None where torque was recorded.
        as_drawn: Whether the links are left as they are drawn.
    """
    model = drawn(arm)
    runs = arm.runs(arm.believed, model)
    if known is not None:
        model = with_gains(arm, model, runs, known)
    belief = as_belief(identify(runs, model=model, estimator=consistent, drop=False), arm.tolerance)
    if not as_drawn:
        return belief
    return replace(belief, robot=replace(belief.robot, kinematics=model.robot.kinematics))


def drawn(arm: Arm) -> Model:
    """The arm as its description draws it, with the terms that its sensors can see."""
    model = arm.data.model()
    unseen = tuple(EFFECTS[name] for name in NAMES if name not in arm.terms)
    seen = tuple(effect for effect in model.effects if not isinstance(effect, unseen))
    return replace(model, effects=seen, robot=replace(model.robot, inertial_tolerance=arm.drawn))


def with_gains(arm: Arm, model: Model, runs: Sequence[Recording], known: tuple[str, float]) -> Model:
    """The model with drive gains, and their tolerance, from a body of known mass.

    Gears that carry more rub more, which a fit without that would lay on the gains.
    """
    rubbing = model + EFFECTS["load_dependent_friction"](reversal=REVERSAL)
    both = [*runs, loaded(arm.data, *known, KNOWN)]
    fit = identify(both, model=rubbing, filtering=arm.data.filtering, estimator=posterior, drop=False)
    gain, share = fit.estimate.gain, fit.estimate.gain_std / fit.estimate.gain
    tolerance = float(np.sqrt(np.mean(share**2)))
    return replace(model, robot=replace(model.robot, drive_gain=gain, drive_gain_tolerance=tolerance))


def as_belief(fit: Fit, tolerance: float) -> Model:
    """A fit as what is believed: its bodies are the robot's, its friction and rotors are guesses.

    Args:
        fit: With standard parameters.
        tolerance: Relative standard deviation of the bodies.
    """
    value = values(fit)
    robot = fit.model.robot
    kinematics = robot.kinematics.copy()
    for link in range(robot.dof):
        body = np.array([value[f"{name}{link + 1}"] for name in INERTIAL])
        kinematics.inertias[link + 1] = body_inertia(body)
    stated = {
        name: Belief(value[name], TOLERANCE[effect] * abs(value[name]) or np.inf)
        for effect, start in NAMES.items()
        for name in value
        if name.startswith(start)
    }
    robot = replace(robot, kinematics=kinematics, inertial_tolerance=tolerance)
    return replace(fit.model, robot=robot, stated=stated)


def values(fit: Fit) -> dict[str, float]:
    """Standard parameters of a fit by name."""
    assert fit.estimate.standard is not None
    return dict(zip(fit.model.names, map(float, fit.estimate.standard), strict=True))


def without(model: Model, effect: str, joint: int) -> Model:
    """The model with an effect left out on one joint (from 0); with all of it where there is no effect."""
    if not effect:
        return model
    kept = tuple(name for place, name in enumerate(model.robot.joints) if place != joint)
    left = tuple(replace(e, joints=kept) if isinstance(e, EFFECTS[effect]) else e for e in model.effects)
    return replace(model, effects=left)


def scatter(arm: Arm, belief: Model, names: Sequence[str]) -> dict[str, np.ndarray]:
    """By how much fits to single runs differ, effect -> standard deviation over mean, (n,) [-]."""
    gain = belief.robot.drive_gain
    model = drawn(arm)
    model = replace(model, robot=replace(model.robot, drive_gain=gain))
    fits = [
        values(identify([run], model=model, estimator=consistent, drop=False))
        for run in arm.runs(tuple(names), model)
    ]
    found = {}
    for effect in arm.terms:
        rows = [[fit[f"{NAMES[effect]}{joint + 1}"] for joint in range(model.robot.dof)] for fit in fits]
        found[effect] = np.std(rows, axis=0, ddof=1) / np.maximum(np.abs(np.mean(rows, axis=0)), 1e-9)
    return found
