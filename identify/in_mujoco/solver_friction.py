"""Reversal of dry friction as MuJoCo's solver does it, which light joints show in any simulation.

`frictionloss` f is a soft constraint on acceleration: with the reference b v and the regularization R of the
joint, its force is (b v + a) / R until it reaches f (MuJoCo's documentation, "Solver parameters"). So
friction changes its sign over the velocity f R / b, which grows with the inverse of the joint's inertia.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..diagnosis.runs.rows import REVERSALS
from ..effects import CoulombFriction, Effect
from ..model import Model

TANH = 0.6
"""Velocity of a tanh over that of a ramp between -1 and 1 with the least mean squared difference [-]."""
IMPEDANCE = 1e-4
"""MuJoCo's smallest distance of an impedance from 0 and 1 [-]."""
LEAST = 2.0
"""Steps within which MuJoCo lets no constraint act faster."""


def reversal_velocities(compiled: Any, joints: Sequence[str]) -> np.ndarray:
    """Velocity over which the file's dry friction changes its sign in MuJoCo, shape (n,) [rad/s]."""
    dofs = [int(compiled.joint(name).dofadr[0]) for name in joints]
    impedance, most = np.clip(compiled.dof_solimp[dofs, :2].T, IMPEDANCE, 1.0 - IMPEDANCE)
    regularization = (1.0 - impedance) / impedance * compiled.dof_invweight0[dofs]
    times, damping = compiled.dof_solref[dofs].T
    slowest = np.maximum(times, LEAST * compiled.opt.timestep)
    damped = np.where(times > 0.0, 2.0 / slowest, -damping) / most
    return np.asarray(compiled.dof_frictionloss[dofs] * regularization / damped)


def with_solver_friction(model: Model, compiled: Any) -> Model:
    """The model with dry friction that reverses as in MuJoCo, on joints where this is slower than usual.

    It is no slower than the reversals that a diagnosis allows for, so that a real arm may have a faster one.
    """
    velocities = TANH * reversal_velocities(compiled, model.robot.joints)
    effects: list[Effect] = []
    for effect in model.effects:
        if isinstance(effect, CoulombFriction) and not effect.gradual:
            effects += _by_joint(effect, model, velocities)
        else:
            effects.append(effect)
    return replace(model, effects=tuple(effects))


def _by_joint(effect: CoulombFriction, model: Model, velocities: np.ndarray) -> list[Effect]:
    """The effect on all joints with its own reversal, and on each joint that turns more slowly."""
    names, places = model.robot.joints, effect.columns(model.robot)
    slow = [place for place in places if velocities[place] > effect.reversal]
    usual = tuple(names[place] for place in places if place not in slow)
    by_joint: list[Effect] = [replace(effect, joints=usual)] if usual else []
    for place in slow:
        reversal = float(min(velocities[place], REVERSALS[-1]))
        by_joint.append(replace(effect, joints=(names[place],), reversal=reversal))
    return by_joint
