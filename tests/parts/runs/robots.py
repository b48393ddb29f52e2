"""Arms without symmetry, on which a wrong axis, sign or index cannot hide."""

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Robot


def kinematics(joints="rrrrrr", parents=None, gravity=(0.0, 0.0, -9.81), seed=0):
    """Tree of revolute (r) and prismatic (p) joints; parents count from 0 for the base."""
    random = np.random.default_rng(seed)
    model = pin.Model()
    model.gravity.linear = np.array(gravity)
    for index, kind in enumerate(joints):
        axis = random.normal(size=3)
        axis /= np.linalg.norm(axis)
        unaligned = pin.JointModelRevoluteUnaligned if kind == "r" else pin.JointModelPrismaticUnaligned
        parent = index if parents is None else parents[index]
        joint = model.addJoint(parent, unaligned(axis), placement(random), f"joint{index + 1}")
        model.appendBodyToJoint(joint, body(random), pin.SE3.Identity())
    return model


def placement(random):
    quaternion = random.normal(size=4)
    rotation = pin.Quaternion(quaternion / np.linalg.norm(quaternion)).matrix()
    return pin.SE3(rotation, random.normal(size=3))


def body(random):
    """Mass of 1 to 5 kg, off-centre, with a full inertia matrix."""
    half = random.normal(size=(3, 3))
    return pin.Inertia(random.uniform(1, 5), random.normal(size=3), half @ half.T + np.eye(3))


def six_axis():
    """Six revolute joints with a coupled wrist, different gears and a flange off its link."""
    coupling = np.eye(6)
    coupling[4, 3], coupling[5, 3], coupling[5, 4] = 0.02, -0.01, 0.5
    return Robot(
        "six axis",
        kinematics(),
        gear_ratio=np.array([101.0, 120.0, 90.0, 60.0, 55.0, 40.0]),
        coupling=coupling,
        flange=placement(np.random.default_rng(7)),
    )


def sliding():
    """Base on two rails, then three revolute joints and a telescope."""
    return Robot("sliding", kinematics("pprrrp", gravity=(1.0, -2.0, -9.0), seed=3))


def random_motion(robot, samples=40, seed=0, payload=""):
    """Unrelated samples; velocities of every size from far below a reversal to fast, and zero."""
    random = np.random.default_rng(seed)
    shape = (samples, robot.dof)
    velocity = random.choice([-1.0, 1.0], shape) * 10.0 ** random.uniform(-4.5, 0.5, shape)
    velocity[0] = 0.0
    return Motion(
        time=np.arange(samples) / 500.0,
        position=random.uniform(-3, 3, shape),
        velocity=velocity,
        acceleration=random.normal(size=shape),
        load=100.0 * random.normal(size=shape),
        temperature=random.uniform(15, 60, shape),
        payload=payload,
    )
