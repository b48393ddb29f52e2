"""A two-joint arm in a vertical plane, and equations of it with noise of known colour."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.effects import CoulombFriction, CurrentOffset, Payload, RigidBody, ViscousFriction
from exidyn.identification.fit.base_parameters import base_parameters
from exidyn.identification.fit.equations import Equations
from exidyn.identification.model import Model
from exidyn.trajectories.random_motion import random_fourier

GAIN = np.array([-40.0, 25.0])
"""Nominal and true drive gains [N m/A]."""
MASS = (("M", 3.0),)
"""The payload by a scale."""


def arm(gain=GAIN):
    kinematics = pin.Model()
    for name, parent, x in (("shoulder", 0, 0.0), ("elbow", 1, 0.4)):
        offset = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        joint = kinematics.addJoint(parent, pin.JointModelRY(), offset, name)
        kinematics.appendBodyToJoint(
            joint, pin.Inertia(5.0 - x, np.array([0.2, 0.01, 0.03]), 0.05 * np.eye(3)), pin.SE3.Identity()
        )
    limits = Limits(*np.outer([-2.5, 2.5, 3.0, 12.0, 200.0, 200.0], np.ones(2)))
    flange = pin.SE3(np.eye(3), np.array([0.3, 0.0, 0.0]))
    return Robot("two joints", kinematics, limits=limits, drive_gain=gain, flange=flange)


def model(*more, gain=GAIN):
    return Model(arm(gain), (RigidBody(), ViscousFriction(), CoulombFriction(), CurrentOffset(), *more))


def true_values(of, mass_payload=0.0):
    """A value for every parameter; friction and offsets have no prior."""
    given = {"Fv1": 3.0, "Fv2": 1.5, "Fc1": 4.0, "Fc2": 2.0, "Off1": 1.0, "Off2": -0.5}
    given |= {"MXL": 0.1 * mass_payload, "MZL": 0.05 * mass_payload, "YYL": 0.02 * mass_payload}
    return np.array([given.get(n, v) for n, v in zip(of.names, of.nominal_values, strict=True)])


def trajectory(duration=20.0, seed=0):
    return random_fourier(arm().limits, duration, period=5.0, seed=seed)


def motion(rows, seed=0, payload="", rate=20.0):
    """Rows of a Fourier motion in its middle, at the decimated rate."""
    time = 5.0 + np.arange(rows) / rate
    return replace(trajectory(rows / rate + 10.0, seed).at(time), payload=payload)


def equations(rows=800, payload=False, rate=20.0, gain_tolerance=0.0):
    """Equations without noise, and the true base parameters; with a payload half the rows carry it."""
    of = model(Payload("L", MASS)) if payload else model()
    base = base_parameters(of, ["", "L"] if payload else [""])
    parts = [motion(rows // 2, 0, "", rate), motion(rows // 2, 1, "L" if payload else "", rate)]
    regressor = np.concatenate([of.regressor(part)[:, :, base.kept] for part in parts])
    known = np.concatenate([of.known_torque(part) for part in parts])
    values = base.regrouping @ true_values(of, 3.0)
    found = Equations(
        base=base,
        regressor=regressor,
        current=(regressor @ values + known) / GAIN,
        known=known,
        weight=np.ones((len(regressor), 2)),
        gain=GAIN,
        gain_known=False,
        gain_tolerance=gain_tolerance,
        runs=(slice(0, rows // 2), slice(rows // 2, len(regressor))),
        rate=rate,
        noise=np.full(2, 1e-3),
        first=np.arange(len(regressor)),
        nominal=of.nominal_values,
        tolerance=np.full(len(of.names), np.inf),
        bodies=tuple(of.inertias),
    )
    return found, values


MIX = np.array([[0.02, 0.0], [0.012, 0.03]])
"""Square root of the innovation's covariance [A]."""
POLES = 0.7 * np.eye(2) + np.array([[0.0, 0.15], [-0.1, 0.0]])
"""Noise is x(k) = POLES x(k-1) + MIX e(k): remembered for some rows, and shared by the joints."""


def coloured(count, random):
    """Coloured, cross-correlated current noise, shape (count, 2) [A]."""
    white = random.normal(size=(count + 100, 2)) @ MIX.T
    out = np.zeros((count + 100, 2))
    for k in range(1, len(out)):
        out[k] = POLES @ out[k - 1] + white[k]
    return out[100:]


def colour_covariance():
    """Stationary covariance of `coloured`, shape (2, 2)."""
    return np.linalg.solve(np.eye(4) - np.kron(POLES, POLES), (MIX @ MIX.T).ravel()).reshape(2, 2)


def white(equations, deviation, seed=0):
    """The same with white current noise of the given standard deviations (2,)."""
    noise = np.random.default_rng(seed).normal(size=equations.current.shape) * deviation
    return replace(equations, current=equations.current + noise)
