"""A run with every signal at its own rate."""

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.effects import CoulombFriction, RigidBody
from exidyn.identification.model import Model
from exidyn.identification.recordings.mcap.mcap_topics import nanoseconds
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal

SAMPLES = 2500


def model() -> Model:
    """Three joints that turn, the middle one behind a bend, and one that slides."""
    kinematics = pin.Model()
    bend = pin.SE3(pin.rpy.rpyToMatrix(0.3, -1.2, 0.5), np.array([0.1, 0.0, 0.4]))
    for place in range(3):
        joint = pin.JointModelPZ() if place == 2 else pin.JointModelRZ()
        index = kinematics.addJoint(place, joint, bend, f"achse_{place + 1}")
        kinematics.appendBodyToJoint(index, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    far = np.full(3, np.inf)
    robot = Robot("small", kinematics, Limits(np.full(3, -4.0), np.full(3, 4.0), far, far, far, far))
    return Model(robot, (RigidBody(), CoulombFriction(("achse_1",))))


def recording(host: bool = True) -> Recording:
    """A run whose signals all have their own rate and bits in every place of the mantissa."""
    random = np.random.default_rng(0)
    time = np.arange(SAMPLES) * 0.002 + random.uniform(0, 1e-4, SAMPLES)
    position = 0.5 * np.sin(np.outer(time, [3.0, 4.0, 5.0]))
    temperature = 40.0 + random.normal(size=(SAMPLES // 100, 3))
    temperature[:, 1] = np.nan
    signals = {
        "position": Signal(time, position),
        "velocity": Signal(time, np.gradient(position, time, axis=0)),
        "current": Signal(time + 1e-4, random.normal(size=position.shape)),
        "torque": Signal(time[::2], random.normal(size=position[::2].shape)),
        "temperature": Signal(time[50::100], temperature),
        "link_position": Signal(time[::4], position[::4] + 1e-4),
        "command": Signal(time - 0.004, position),
    }
    clock = 1_800_000_000_000_000_000 + nanoseconds(time) + random.integers(0, 300_000, SAMPLES)
    return Recording(
        name="a run with an ü",
        model=model(),
        signals=signals,
        payload=KnownPayload("weight", (("M", 175.0), ("MX", 1 / 3))),
        trajectory="[trajectory]\n",
        settings={"role": "identify", "units": "rad, A"},
        host_time=clock if host else None,
    )
