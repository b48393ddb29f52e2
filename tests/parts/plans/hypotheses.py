"""Hypotheses about a two-joint arm, and fits of them written out row by row."""

from dataclasses import replace

import numpy as np

from exidyn.identification.effects import (
    CoulombFriction,
    CurrentOffset,
    JointSpring,
    LoadDependentFriction,
    NonlinearViscousFriction,
    Payload,
    RigidBody,
    SpringBalancer,
    StribeckFriction,
    ViscousFriction,
    known_parameters,
)
from exidyn.identification.model import Model
from exidyn.trajectories.discrimination.separation import Hypothesis, Observation, explain
from exidyn.trajectories.search.experiment import DriveGains
from exidyn.trajectories.search.problem import Basis

from ..small.two_joints import arm

NOISE = np.array([0.5, 0.3])
OBSERVATION = Observation(NOISE, rows=200.0)
BODY = known_parameters(2.0, (0.1, 0.0, 0.05), (0.01, 0.0, 0.0, 0.02, 0.0, 0.02))
COMMON = (RigidBody(), ViscousFriction(), CoulombFriction(reversal=0.05), CurrentOffset())
FRICTION = {"Fv1": 3.0, "Fv2": 1.5, "Fc1": 4.0, "Fc2": 2.0}


def model(*more):
    return Model(arm(), (*COMMON, *more))


def hypothesis(name, *more, values=None, deviations=None):
    return hypothesis_of(name, model(*more), FRICTION | (values or {}), deviations or {})


def hypothesis_of(name, of, values, deviations):
    """A hypothesis with the priors of a model, except for the parameters that are named."""
    center = [values.get(key, prior.value) for key, prior in zip(of.names, of.priors, strict=True)]
    std = [deviations.get(key, prior.std) for key, prior in zip(of.names, of.priors, strict=True)]
    with np.errstate(divide="ignore"):
        precision = np.diag(np.array(std, float) ** -2.0)
    return replace(Hypothesis.of_priors(name, of), values=np.array(center), precision=precision)


def separation(true, rival, motion, observation):
    """How the rival explains a run in which another hypothesis is true."""
    seen, share = observation.seen(rival, motion), observation.rows / len(motion)
    return explain(rival, seen, observation.seen(true, motion).torque, share)


def motion(seed=0, samples=60, size=1.0):
    """Unrelated to any optimum."""
    random = np.random.default_rng(seed)
    basis = Basis(5.0, 3, samples)
    return basis.motion(size * random.normal(size=(basis.rows, 2)) / 3)


def balancer():
    return hypothesis(
        "balancer", SpringBalancer("shoulder", 0.3, 0.2, 0.4), values={"Kr": 100.0, "K0": 10.0}, deviations={}
    )


def spring():
    return hypothesis("spring", JointSpring(("shoulder",)), values={"Ks1": 5.0})


def stribeck():
    return hypothesis("stribeck", StribeckFriction(("elbow",), reversal=0.05), values={"Fs2": 2.0})


def grease():
    return hypothesis("grease", NonlinearViscousFriction(("elbow",), 2.0), values={"Fn2": 1.0})


def gain():
    of = model()
    held = {"gain1": 0.0, "gain2": 0.1}
    return hypothesis_of("gain", of + DriveGains(of), FRICTION | {"gain2": 0.05}, held)


def load_friction():
    return hypothesis("load friction", LoadDependentFriction(), values={"mu1": 0.05, "mu2": 0.04})


def as_told_by(true, rival, at):
    """The rival as it would be if it were true: with the values that explain the other best."""
    return replace(rival, values=separation(true, rival, at, OBSERVATION).hypothesis.values)


def carrying(one):
    return one.changed(lambda m: m + Payload("L", BODY))


def stacked(one, at):
    """Rows of a hypothesis in units of noise, written out: columns (r, p) and torque (r,)."""
    columns = (one.model.regressor(at) / NOISE[:, None]).reshape(-1, len(one.values))
    return columns, columns @ one.values + (one.model.known_torque(at) / NOISE).ravel()


def refitted(one, columns, torque, own):
    """Chi-squared and values of a fit with the priors as further rows, by singular values."""
    free = one.free
    held = np.diag(np.sqrt(np.diag(one.precision)[free]))
    rows = np.concatenate([columns[:, free], held])
    right = np.concatenate(
        [torque - own[:, None] if torque.ndim > 1 else torque - own, np.zeros((len(held), *torque.shape[1:]))]
    )
    move = np.linalg.lstsq(rows, right, rcond=1e-9)[0]
    return np.sum((right - rows @ move) ** 2, axis=0), move
