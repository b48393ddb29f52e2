"""Candidates that are gears which give way: the link lags behind its motor, and swings on its gear.

With motors where their encoders say, every link but one follows its motor, and that one leads or lags by a
twist whose equation is row j of the arm's: M_jj twist'' + d twist' + (K + dtau_j/dq_j) twist = load_j. What
all motors give for it more than for a rigid gear is minus the links' torque for a twist. The stiffness
shapes it: little matters below the resonance but the load over the stiffness, and near it the link's own
swing.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...effects import Shape
from ...model import Model
from ..candidate import Candidate
from ..driven import Driven
from ..tangent import carrying
from ..twisted import bent

STEP = 1.3
"""From one resonance to the next that is tried [-]."""
RESONANCES = tuple(3.0 * STEP**step for step in range(12))
"""Of the mean link on its gear [Hz], up to 54: below, no drive holds its arm; above, the fastest motion
twists its gears by less than a fifteenth of a link's acceleration."""
RATIO = 0.1
"""Damping ratio of a gear [-]: 0.02 for steel, 0.2 for much grease. Near its resonance a link swings where
its motor hardly moves; with less damping, what is made of that would be noise."""
SCATTER = 0.1
"""Of the coefficient around 1, since the stiffness says how large the effect is [-]: as much as link's
inertia and damping are wrong."""
LEAST = 0.5
"""Coefficient below which what fits is something else that swings [-]."""
POSES = 64
"""Over which the inertia of a link is averaged."""


def gears(model: Model) -> Iterator[Candidate]:
    """Every joint's gear, from soft to stiff."""
    for joint, inertia in enumerate(link_size(model)[0]):
        # A joint that moves nothing has nothing to bend.
        for resonance in RESONANCES if inertia > 0.0 else ():
            yield _gear(model, joint, inertia, resonance, RATIO)


def _gear(model: Model, joint: int, inertia: float, resonance: float, ratio: float) -> Candidate:
    angular = 2 * np.pi * resonance
    stiffness, loss = inertia * angular**2, 2 * ratio * inertia * angular

    def columns(run: Driven) -> np.ndarray:
        return bending(model, run, joint, (stiffness, loss))[:, :, None]

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return _gear(model, joint, inertia, given["resonance"], given["damping_ratio"])

    return Candidate(
        "joint_elasticity",
        (joint,),
        columns,
        ("share",),
        ("1",),
        (LEAST,),
        {"resonance": resonance, "damping_ratio": ratio, "stiffness": stiffness},
        {
            "resonance": Shape("Hz", resonance / STEP, resonance * STEP),
            "damping_ratio": Shape("1", 0.005, 0.5),
        },
        reshaped,
        expected=((1.0, SCATTER),),
        told={"stiffness": (stiffness, "N m/rad")},
    )


def of_stiffness(model: Model, joint: int, stiffness: float, std: float) -> Candidate:
    """The gear of a stiffness that was measured [N m/rad], with its deviation."""
    inertia = max(float(link_size(model)[0][joint]), 1e-9)
    resonance = float(np.sqrt(stiffness / inertia) / (2 * np.pi))
    gear = _gear(model, joint, inertia, resonance, RATIO)
    return replace(gear, bounds={}, told={"stiffness": (stiffness, "N m/rad")}, known={"stiffness": std})


def bending(model: Model, run: Driven, joint: int, gear: tuple[float, float]) -> np.ndarray:
    """Torque of the motors beyond that of a rigid gear, shape (t, n) [N m].

    Args:
        model: For which joints motors turn.
        run: The motion, and the load.
        joint: The elastic one.
        gear: Its stiffness [N m/rad] and damping [N m s/rad].
    """
    weight, drag, inertia = run.tangent.own(joint)
    step = float(np.median(np.diff(run.motion.time)))
    twist = bent(inertia, gear[1] + drag, gear[0] + weight, run.motion.load[:, joint], step)
    return -run.tangent.torque(joint, *twist) @ model.robot.to_motors.T


def link_size(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Inertia [kg m^2] and load [N m] of each joint, its rotor apart, means over poses, each (n,).

    The load is that of gravity and of 1 rad/s^2.
    """
    kinematics = carrying(model, model.believed_values, "")
    data, limits = kinematics.createData(), model.robot.limits
    lower, upper = np.maximum(limits.position_lower, -np.pi), np.minimum(limits.position_upper, np.pi)
    poses = np.random.default_rng(0).uniform(lower, upper, (POSES, model.robot.dof))
    inertia = np.mean([np.diagonal(pin.crba(kinematics, data, pose)) for pose in poses], axis=0)
    weights = [pin.computeGeneralizedGravity(kinematics, data, pose) for pose in poses]
    return inertia, np.mean(np.abs(weights), axis=0) + inertia
