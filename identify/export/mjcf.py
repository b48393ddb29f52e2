r"""MJCF for MuJoCo: bodies, joints with friction, rotors and springs, balancers as tendons.

Dry friction is a constraint in MuJoCo, with a force

.. math:: -\frac{d}{1 - d} M (\ddot q + b \dot q), \quad b = \frac{2}{d\, t_c},

up to the friction loss :math:`F`, where :math:`1 / M` is the joint's element of the inverse inertia at zero
position. Time constant :math:`t_c`, at least two time steps, and impedance :math:`d` are chosen such that
friction reverses over the same velocity :math:`v_r` as in the model, :math:`2 M / (t_c (1 - d)) = F / v_r`:
along a line instead of tanh, and with as little effect of acceleration as the time step allows.
"""

from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from exidyn.quoting import xml_document

from ..arm.newton_euler import Joint, joints_of, link_frames
from ..arm.robot import Robot
from ..effects.simulator_terms import Spring
from ..positive_definite import inverse
from ..robot_files.mjcf_elements import JOINT_TERMS
from ..robot_files.robot_text import SLENDERNESS, words
from .portable import Portable

FEATURES = (
    "bodies",
    "gravity",
    "armature",
    "damping",
    "dry",
    "reversal",
    "stiffness",
    "constant",
    "balancers",
)
STEP = 1e-3
"""Time step of the integration in the file [s]."""
SOFTEST = 0.01
"""Impedance of dry friction if the time step allows it: acceleration then changes friction by 1 %."""
SMALLEST = 1e-9
"""Stiffness of a balancer without stiffness [N/m per N of preload]: MuJoCo's springs have a rest length,
which is then a million kilometers."""


def mjcf(portable: Portable) -> str:
    """An arm of capsules without collisions; one motor per joint with `ctrl` as its torque [N m]."""
    robot = portable.robot
    root = Element("mujoco", model=robot.name)
    SubElement(root, "compiler", angle="radian", autolimits="true")
    option = {"timestep": f"{STEP:g}", "integrator": "implicitfast", "gravity": words(robot.gravity)}
    SubElement(root, "option", option)
    bodies = _add_bodies(SubElement(root, "worldbody"), portable)
    if portable.balancers:
        tendons = SubElement(root, "tendon")
        for number, spring in enumerate(portable.balancers, start=1):
            _add_balancer(tendons, bodies, robot, spring, f"balancer{number}")
    actuators = SubElement(root, "actuator")
    for place in range(robot.dof):
        _add_motor(actuators, portable, place)
    return xml_document(root, declaration=False)


def _add_bodies(world: Element, portable: Portable) -> list[Element]:
    """Add the tree of bodies; returns the world, then one body per joint."""
    robot, bodies = portable.robot, [world]
    joints, frames = joints_of(robot.kinematics), link_frames(robot.kinematics)
    radius = SLENDERNESS * max(float(np.linalg.norm(joint.placement.translation)) for joint in joints)
    soft = _softness(portable)
    for place, (joint, frame) in enumerate(zip(joints, frames, strict=True)):
        parent = bodies[joint.parent + 1]
        _add_capsule(parent, joint.placement.translation, radius)
        body = SubElement(parent, "body", {"name": frame.child, **_placement(joint.placement)})
        inertia = robot.kinematics.inertias[place + 1]
        six = words(inertia.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])
        mass = repr(float(inertia.mass))
        SubElement(body, "inertial", pos=words(inertia.lever), mass=mass, fullinertia=six)
        SubElement(body, "joint", _joint(portable, place, joint, soft[place]))
        bodies.append(body)
    _add_capsule(bodies[-1], robot.flange.translation, radius)
    SubElement(bodies[-1], "site", {"name": "flange", **_placement(robot.flange)})
    return bodies


def _softness(portable: Portable) -> list[tuple[float, float]]:
    """Time constant [s] and impedance [-] of each joint's dry friction."""
    robot, joints = portable.robot, portable.joints
    kinematics = robot.kinematics.copy()
    inertia = pin.crba(kinematics, kinematics.createData(), np.zeros(robot.dof)) + np.diag(joints.armature)
    masses = 1.0 / np.diagonal(inverse(np.triu(inertia) + np.triu(inertia, 1).T))
    softness = []
    for mass, dry, reversal in zip(masses, joints.dry, joints.reversal, strict=True):
        # number of time steps in which friction stops the reversal velocity
        steps = mass * reversal / (dry * STEP) if dry else 1.0
        impedance = max(1.0 - steps, SOFTEST)
        softness.append((2.0 * STEP * max(steps / (1.0 - SOFTEST), 1.0), impedance))
    return softness


def _joint(portable: Portable, place: int, joint: Joint, soft: tuple[float, float]) -> dict[str, str]:
    joints, limits = portable.joints, portable.robot.limits
    attributes = {"name": portable.robot.joints[place], "type": "hinge" if joint.revolute else "slide"}
    attributes |= {"axis": words(joint.axis)}
    bounds = np.array([limits.position_lower[place], limits.position_upper[place]])
    if np.all(np.isfinite(bounds)):
        attributes["range"] = words(bounds)
    attributes |= {
        number.attribute: repr(float(value))
        for term, number in JOINT_TERMS.items()
        if (value := getattr(joints, term)[place])
    }
    if joints.dry[place]:
        attributes |= {
            "solreffriction": words((soft[0], 1.0)),
            "solimpfriction": words((soft[1], soft[1], 1.0)),
        }
    if joints.stiffness[place]:
        attributes["springref"] = repr(float(-joints.constant[place] / joints.stiffness[place]))
    return attributes


def _add_balancer(tendons: Element, bodies: list[Element], robot: Robot, spring: Spring, name: str) -> None:
    """Add a tendon between sites of two links, longest at angle zero of the effect.

    The force K_r l + K_0 of the effect pushes the ends apart; MuJoCo's force -k (l - l_0) does so for k =
    -K_r.
    """
    place = robot.index(spring.joint)
    joint = joints_of(robot.kinematics)[place]
    across = np.linalg.svd(joint.axis[None])[2][1]
    beside = np.cross(joint.axis, across)
    turned = np.pi - spring.phi
    fixed = spring.d21 * (np.cos(turned) * across + np.sin(turned) * beside)
    ends = (bodies[joint.parent + 1], joint.placement.act(fixed)), (bodies[place + 1], spring.d22 * across)
    stiffness = spring.stiffness or SMALLEST * abs(spring.preload)
    length = repr(-spring.preload / stiffness if stiffness else 0.0)
    tendon = SubElement(tendons, "spatial", name=name, stiffness=repr(-stiffness), springlength=length)
    for number, (body, position) in enumerate(ends):
        SubElement(body, "site", name=f"{name}_{number + 1}", pos=words(position))
        SubElement(tendon, "site", site=f"{name}_{number + 1}")


def _add_motor(actuators: Element, portable: Portable, place: int) -> None:
    """Add a motor; its bias is the constant torque, unless a spring of the joint includes it."""
    joints, name = portable.joints, portable.robot.joints[place]
    motor = SubElement(actuators, "general", name=name, joint=name, gainprm="1")
    if joints.constant[place] and not joints.stiffness[place]:
        motor.attrib |= {"biastype": "affine", "biasprm": words((-joints.constant[place], 0.0, 0.0))}
    limit = portable.robot.limits.torque[place]
    if np.isfinite(limit):
        motor.set("ctrlrange", words((-limit, limit)))


def _add_capsule(body: Element, end: np.ndarray, radius: float) -> None:
    if np.linalg.norm(end) > radius:
        SubElement(
            body, "geom", type="capsule", fromto=words((*np.zeros(3), *end)), size=words((radius,)),
            contype="0", conaffinity="0", mass="0",
        )  # fmt: skip


def _placement(placement: pin.SE3) -> dict[str, str]:
    x, y, z, w = pin.Quaternion(placement.rotation).coeffs()
    return {"pos": words(placement.translation), "quat": words((w, x, y, z))}
