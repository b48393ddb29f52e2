"""What tests of excitation share: small goals and settings, motions that fit nothing else, differences."""

from dataclasses import replace

import numpy as np

from exidyn.identification.effects import CoulombFriction, CurrentOffset, RigidBody, ViscousFriction
from exidyn.identification.model import Model
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.limits.check import check
from exidyn.trajectories.limits.usable_limits import usable
from exidyn.trajectories.search.delivery import Setting
from exidyn.trajectories.search.experiment import Experiment
from exidyn.trajectories.search.goals import Identify
from exidyn.trajectories.search.problem import Basis
from exidyn.trajectories.search.torque_bound import TorqueBound

from ..small import two_joints

TICK = 0.004


def smooth_model(*more):
    """The two-joint arm with friction that turns slowly enough for differences."""
    friction = (ViscousFriction(), CoulombFriction(reversal=0.08))
    return Model(two_joints.arm(), (RigidBody(), *friction, CurrentOffset(), *more))


def weak(torque, **robot):
    """The two-joint arm with drives of little torque, and other fields of its robot."""
    of = two_joints.model()
    within = replace(of.robot.limits, torque=np.array(torque))
    return replace(of, robot=replace(of.robot, limits=within, **robot))


def core(run):
    """The periodic part of a run."""
    return next(part for part in run.parts if isinstance(part, Fourier))


def coefficients(basis, dof, seed=0, size=0.5):
    """Random, with fading harmonics, shape (k, n)."""
    fade = 1.0 / np.arange(1, basis.harmonics + 1)
    one = np.concatenate([[0.5], fade, fade])
    random = np.random.default_rng(seed).normal(size=(basis.rows, dof))
    return size * random * np.tile(one, basis.series)[:, None]


def small_basis(series=1, period=4.0, harmonics=3):
    return Basis(period, harmonics, 12 * harmonics, series)


def limits(robot=None):
    return usable(robot or two_joints.arm()).limits


def goal(model=None, **options):
    return Identify(Experiment.of(model or two_joints.model()), **options)


def setting(**options):
    """Two harmonics in four seconds: a start takes a second."""
    return replace(Setting(limits(), harmonics=2, periods=(4.0,), tick=TICK), **options)


def along(function, at, direction, step=1e-6):
    """Central difference of a function along a direction."""
    return (function(at + step * direction) - function(at - step * direction)) / (2 * step)


def kinematic_share(series, kept):
    """Largest share of a kinematic limit that a series about its centre uses, by joint."""
    reached = series.extremes()
    shares = [
        (reached.position.upper - series.centre) / (kept.position_upper - series.centre),
        (reached.position.lower - series.centre) / (kept.position_lower - series.centre),
        reached.velocity.upper / kept.velocity,
        reached.velocity.lower / kept.velocity_lower,
        reached.acceleration.upper / kept.acceleration,
        reached.acceleration.lower / kept.acceleration_lower,
        reached.jerk.upper / kept.jerk,
        -reached.jerk.lower / kept.jerk,
    ]
    return np.max(shares, axis=0)


def nothing_violated(motion, of, kept, clearances=()):
    """Whether a motion of a goal keeps to all limits with every payload, and clear of everything."""
    bound = TorqueBound(of.model, kept.torque, of.payloads)
    for payload in of.payloads:
        assert not check(motion, kept, TICK, bound.of(payload))
    for clearance in clearances:
        assert clearance.worst(motion).allowed


def shifted(function, motion, random, step=1e-6):
    """A random direction of position, velocity and acceleration, and the function's slope along it."""
    names = ("position", "velocity", "acceleration")
    shift = {name: random.normal(size=motion.position.shape) for name in names}
    sides = [
        function(replace(motion, **{name: getattr(motion, name) + side * by for name, by in shift.items()}))
        for side in (step, -step)
    ]
    return shift, (sides[0] - sides[1]) / (2 * step)
