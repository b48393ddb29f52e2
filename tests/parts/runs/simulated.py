"""Simulated arms for tests: what they did, and small ones whose motion is known in formulas."""

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Robot
from exidyn.identification.effects import Prior, RigidBody, RotorInertia
from exidyn.identification.model import Model
from exidyn.identification.simulation.plant import DriveControl, Measured, Plant

GRAVITY = 9.81
MASS, LEVER, ROTOR = 4.0, 0.5, 0.3
"""Of the one-joint arm: mass [kg] at the end of a rod [m], and rotor inertia [kg m^2]."""


@dataclass(frozen=True)
class Run:
    """What a plant did, tick by tick."""

    motion: Motion  # as it really was
    measured: Measured  # what its sensors measured, each (t, n)


def follow(plant: Plant, position: np.ndarray, velocity: np.ndarray, tick: float = 0.002) -> Run:
    """Command positions and velocities (t, n), one a tick."""
    truths, measured = [], []
    for wanted, speed in zip(position, velocity, strict=True):
        plant.step(wanted, speed, tick)
        truths.append(plant.truth())
        measured.append(plant.measure())
    return Run(joined(truths, tick), Measured(*(np.array(rows) for rows in zip(*measured, strict=True))))


def joined(samples: list[Motion], tick: float) -> Motion:
    names = ("position", "velocity", "acceleration", "load", "temperature")
    arrays = {name: np.concatenate([getattr(one, name) for one in samples]) for name in names}
    return replace(samples[0], time=tick * np.arange(len(samples)), **arrays)


def known(model: Model, values: np.ndarray) -> Model:
    """The model with priors that are true, so that the load of its gears is that of the plant."""
    stated = {name: Prior(float(value)) for name, value in zip(model.names, values, strict=True)}
    return replace(model, stated=stated)


def stiff(joints: int, inertia: float = 1.0, bandwidth: float = 25.0) -> DriveControl:
    return DriveControl.tuned(np.full(joints, inertia), bandwidth, np.full(joints, np.inf))


def pendulum(*effects, axis: str = "y") -> Model:
    """One joint at which a rod hangs when its position is zero; about z, gravity does nothing to it."""
    kinematics = pin.Model()
    joint = {"y": pin.JointModelRY, "z": pin.JointModelRZ}[axis]()
    index = kinematics.addJoint(0, joint, pin.SE3.Identity(), "swing")
    arm = np.array([0.0, 0.0, -LEVER]) if axis == "y" else np.array([LEVER, 0.0, 0.0])
    kinematics.appendBodyToJoint(index, pin.Inertia(MASS, arm, np.zeros((3, 3))), pin.SE3.Identity())
    return Model(Robot("pendulum", kinematics), (RigidBody(), RotorInertia(), *effects))


def pendulum_values(*more: float, axis: str = "y") -> np.ndarray:
    model = pendulum(axis=axis)
    return np.concatenate([model.nominal_values[:10], [ROTOR], more])
