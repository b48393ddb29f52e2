"""Small arms with one effect by exidyn's own formula: do 95 % intervals of its numbers contain the truth?

Two joints in a vertical plane. Masses, friction and drive gains are drawn within what the nominal model
states of them; half of the current noise is white, and half lasts for `MEMORY`.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from scipy import signal

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.effects import (
    CoulombFriction,
    CurrentOffset,
    Effect,
    FrictionAsymmetry,
    Hysteresis,
    JointSpring,
    LoadDependentFriction,
    NonlinearViscousFriction,
    PositionDependentFriction,
    Prior,
    RigidBody,
    StribeckFriction,
    ViscousFriction,
)
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.simulation.simulate import simulate
from exidyn.trajectories.random_motion import random_fourier

from .scoring.coverage import Number

GAIN = np.array([-40.0, 25.0])
"""Nominal drive gains [N m/A]."""
TOLERANCE, FRICTION = 0.05, 0.2
"""Relative standard deviation of masses and gains, and of friction [-]."""
JOINTS, USUAL = ("shoulder", "elbow"), (20.0, 6.0)
"""Joints, and the torque that an effect is drawn in shares of [N m]."""
STATED = {"Fv1": 3.0, "Fv2": 1.5, "Fc1": 4.0, "Fc2": 2.0}
ROLES = {"identify": (16.0, 3), "validate": (8.0, 1)}
"""Role -> length [s] and number of runs."""
PERIOD, RATE, NOISE, MEMORY = 5.0, 250.0, 0.01, 0.05
"""Of the motion [s], samples a second [Hz], each half of the noise over the rms current [-], and after which
37 % is left of the half that lasts [s]."""


class Drawn(NamedTuple):
    """An effect, the values of its parameters, and the numbers of its shape."""

    effect: Effect
    values: dict[str, float]
    shape: dict[str, float]


Random = np.random.Generator
Draw = Callable[[str, int, float, Random], Drawn]
"""By name, number and usual torque of a joint."""


def _stribeck(joint: str, number: int, usual: float, rng: Random) -> Drawn:
    fade = rng.uniform(0.05, 0.2)
    values = {f"Fs{number}": rng.uniform(0.1, 0.3) * usual}
    return Drawn(StribeckFriction((joint,), fade=fade), values, {"fade": fade})


def _drag(joint: str, number: int, usual: float, rng: Random) -> Drawn:
    exponent, values = float(rng.choice([0.5, 1.7, 2.2])), {f"Fn{number}": rng.uniform(0.1, 0.3) * usual}
    return Drawn(NonlinearViscousFriction((joint,), exponent=exponent), values, {"exponent": exponent})


def _hysteresis(joint: str, number: int, usual: float, rng: Random) -> Drawn:
    way, values = rng.uniform(2e-3, 1e-2), {f"Fh{number}": rng.uniform(0.1, 0.3) * usual}
    return Drawn(Hysteresis((joint,), presliding=way), values, {"presliding": way})


DRAWS: Mapping[str, Draw] = {
    "load_dependent_friction": lambda joint, number, usual, rng: Drawn(
        LoadDependentFriction((joint,)), {f"mu{number}": rng.uniform(0.05, 0.2)}, {}
    ),
    "stribeck_friction": _stribeck,
    "nonlinear_viscous_friction": _drag,
    "joint_spring": lambda joint, number, usual, rng: Drawn(
        JointSpring((joint,)), {f"Ks{number}": rng.uniform(0.1, 0.4) * usual, f"Ts{number}": 0.0}, {}
    ),
    "hysteresis": _hysteresis,
    "position_dependent_friction": lambda joint, number, usual, rng: Drawn(
        PositionDependentFriction((joint,)),
        {
            f"Fcos1_{number}": rng.uniform(0.05, 0.15) * usual,
            f"Fsin1_{number}": rng.uniform(-0.1, 0.1) * usual,
        },
        {},
    ),
    "friction_asymmetry": lambda joint, number, usual, rng: Drawn(
        FrictionAsymmetry((joint,), viscous=True),
        {f"Fa{number}": rng.uniform(0.03, 0.1) * usual, f"Fva{number}": rng.uniform(0.03, 0.1) * usual},
        {},
    ),
}  # fmt: skip
"""Effect of the vocabulary -> how it is drawn."""


def nominal() -> Model:
    """The arm as it is stated."""
    kinematics = pin.Model()
    for place, (name, x) in enumerate(zip(JOINTS, (0.0, 0.4), strict=True)):
        joint = kinematics.addJoint(
            place, pin.JointModelRY(), pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])), name
        )
        body = pin.Inertia(5.0 - x, np.array([0.2, 0.01, 0.03]), 0.05 * np.eye(3))
        kinematics.appendBodyToJoint(joint, body, pin.SE3.Identity())
    limits = Limits(*np.outer([-2.5, 2.5, 3.0, 12.0, 200.0, 200.0], np.ones(2)))
    robot = Robot(
        "two joints", kinematics, limits=limits, drive_gain=GAIN, drive_gain_tolerance=np.array(TOLERANCE),
        inertial_tolerance=TOLERANCE, gear_ratio=np.array([100.0, 80.0]),
    )  # fmt: skip
    stated = {name: Prior(value, FRICTION * value) for name, value in STATED.items()}
    return Model(robot, (RigidBody(), ViscousFriction(), CoulombFriction(), CurrentOffset()), stated)


def diagnosed_numbers(seed: int) -> list[Number]:
    """Draw an arm, record and diagnose it; numbers of its effect, none where that was not found."""
    rng, effect = np.random.default_rng(seed), list(DRAWS)[seed % len(DRAWS)]
    place, model = int(rng.integers(2)), nominal()
    drawn = DRAWS[effect](JOINTS[place], place + 1, USUAL[place], rng)
    known = {"Off1": 1.0, "Off2": -0.5} | drawn.values
    known |= {
        name: prior.value + prior.std * rng.normal()
        for name, prior in zip(model.names, model.priors, strict=True)
        if name not in known
    }
    gain = GAIN * (1.0 + TOLERANCE * rng.normal(size=2))
    roles = [role for role, (_, count) in ROLES.items() for _ in range(count)]
    runs = [
        (role, _recorded(model, drawn.effect, known, gain, ROLES[role][0], 100 * seed + k))
        for k, role in enumerate(roles)
    ]
    found = diagnose(model, runs, as_recorded=True)
    right = [
        one for one in (*found.findings, *found.undecided) if (one.effect, one.joints) == (effect, (place,))
    ]
    truth = drawn.values | drawn.shape
    return [
        Number(effect, name.rstrip("12").rstrip("_"), float(truth[name]), one.value, one.std)
        for finding in right[:1]
        for name, one in finding.determined.items()
        if name in truth
    ]


def _recorded(
    model: Model, effect: Effect, known: Mapping[str, float], gain: np.ndarray, seconds: float, seed: int
) -> Recording:
    plant = model + effect
    path = random_fourier(model.robot.limits, seconds, period=PERIOD, seed=seed)
    motion, values = path.at(np.arange(0.0, seconds, 1.0 / RATE)), np.array([known[n] for n in plant.names])
    run = simulate(plant, values, gain, motion, model, name=f"run {seed}", seed=seed)
    current = run.signals["current"]
    keep, white = (
        np.exp(-1.0 / (RATE * MEMORY)),
        np.random.default_rng(seed).normal(size=current.values.shape),
    )
    lasting = signal.lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], white, axis=0)
    size = NOISE * np.sqrt(np.mean(current.values**2, axis=0))
    return replace(
        run, signals=run.signals | {"current": replace(current, values=current.values + size * lasting)}
    )
