"""A two-joint arm with a spring at its elbow that its nominal model lacks, and its diagnosis in words."""

from dataclasses import fields, replace
from functools import cache
from types import SimpleNamespace

import numpy as np

from exidyn.identification.diagnosis import Diagnosis, Finding, Hypothesis, Remainder, diagnose
from exidyn.identification.diagnosis.candidates import hypotheses
from exidyn.identification.diagnosis.findings.quantities import alternative
from exidyn.identification.effects import JointSpring, Prior
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.simulation.simulate import simulate
from exidyn.trajectories.random_motion import random_fourier

from . import two_joints

STIFFNESS = 12.0
"""Of the spring [N m/rad]."""
GEARS = np.array([100.0, 80.0])
"""With a ratio of one, a ripple of the motor is a wave along the joint, and looks like a spring."""
PLANT = two_joints.model(JointSpring(("elbow",)))
TRUE = {"Fv1": 3.0, "Fv2": 1.5, "Fc1": 4.0, "Fc2": 2.0, "Off1": 1.0, "Off2": -0.5}
ROLES = ("identify", "identify", "validate")


def nominal_model() -> Model:
    """Without the spring; friction as a guess, within a fifth."""
    model = two_joints.model()
    stated = {name: Prior(0.95 * TRUE[name], 0.2 * TRUE[name]) for name in ("Fv1", "Fv2", "Fc1", "Fc2")}
    robot = replace(model.robot, inertial_tolerance=0.02, drive_gain_tolerance=0.02, gear_ratio=GEARS)
    return replace(model, robot=robot, stated=stated)


@cache
def recording(role: str, seed: int, spring: float = STIFFNESS, length: float = 16.0) -> Recording:
    path = random_fourier(two_joints.arm().limits, length, period=4.0, seed=seed)
    values = TRUE | {"Ks2": spring}
    given = np.array([values.get(n, b) for n, b in zip(PLANT.names, PLANT.nominal_values, strict=True)])
    motion = path.at(np.arange(0.0, length, 0.004))
    made = simulate(PLANT, given, two_joints.GAIN, motion, nominal_model(), name=f"{role}{seed}", seed=seed)
    return replace(made, settings={**made.settings, "role": role})


def recordings(spring: float = STIFFNESS) -> list[Recording]:
    lengths = {"validate": 8.0}
    return [recording(role, seed, spring, lengths.get(role, 16.0)) for seed, role in enumerate(ROLES)]


@cache
def diagnosis(spring: float = STIFFNESS) -> Diagnosis:
    runs = [(run.settings["role"], run) for run in recordings(spring)]
    return diagnose(nominal_model(), runs, "small")


@cache
def with_remainder() -> Diagnosis:
    """The same, and something without a name on the shoulder."""
    return replace(diagnosis(), remainders=(Remainder(0, 1.6, 0.99, "position"),))


def instead(effect: str, joint: int | None, probability: float = 0.2) -> Hypothesis:
    """What a finding might be instead, with coefficients of one."""
    candidate = next(
        one for one in hypotheses(effect, nominal_model()) if joint is None or one.joints == (joint,)
    )
    answer = SimpleNamespace(candidate=candidate, values=np.ones(len(candidate.names)))
    return alternative(answer, probability)


def as_finding(hypothesis: Hypothesis) -> Finding:
    """The hypothesis as if it had been found."""
    held = {field.name: getattr(hypothesis, field.name) for field in fields(hypothesis)}
    return Finding(**held, torque_rms=np.zeros(2), held_out=np.nan)
