"""Effects of bodies, springs and transmissions: what is welded, tied or loose."""

from dataclasses import replace

import numpy as np

from ..plant.body import weld
from ..robots.arms import NO_BALANCER, Tool
from ..robots.robot import Robot, carried
from .effect import Concealed, changed, floor

GRAVITY = 9.81


def link_inertia(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    body = robot.machine.body
    side = rng.normal(size=3)
    reach = rng.uniform(0.1, 0.3) * side / np.linalg.norm(side)
    mass = strength * 0.03 * body.mass[joint]
    heavier = weld(body, joint, mass, body.com[joint] + reach, 1e-3 * mass * np.eye(3))
    parameters = {"mass": mass, "at": body.com[joint] + reach}
    return Concealed(robot.with_machine(body=heavier), robot, (joint,), parameters)


def payload(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    last = robot.arm.joints - 1
    tool = box(strength * 0.02 * robot.arm.tool.mass, rng, robot.arm.tool)
    loaded = weld(robot.machine.body, last, tool.mass, tool.com, tool.inertia)
    parameters = {"mass": tool.mass, "com": tool.com, "size": tool.edges}
    return Concealed(robot.with_machine(body=loaded), robot, (), parameters)


def box(mass: float, rng: np.random.Generator, tool: Tool) -> Tool:
    """A box like a tool of another mass, somewhere about its place."""
    return Tool(mass, tool.com * rng.uniform(-1.5, 1.5, 3), tool.edges * rng.uniform(0.5, 1.0))


def rotor_inertia(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    rotor = robot.machine.rotor
    if rng.random() < 0.6:  # the owner forgot it; it cannot be less than a motor has
        own = rotor[joint, joint] * np.clip(0.1 * strength, 0.5, 1.3)
        fitted = robot.with_machine(rotor=changed(rotor, (joint, joint), own)).without_term("rotor", joint)
        half = fitted.with_machine(rotor=changed(rotor, (joint, joint), 0.5 * own))
        return Concealed(fitted, half, (joint,), {"Ia": own, "missing": True}, part=0.5)
    own = rotor[joint, joint] * (1.0 + 0.05 * strength)
    other = robot.with_machine(rotor=changed(rotor, (joint, joint), own))
    return Concealed(other, robot, (joint,), {"Ia": own, "factor": 1.0 + 0.05 * strength, "missing": False})


def base_tilt(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    angle, heading = np.deg2rad(0.1 * strength), rng.uniform(0.0, 2.0 * np.pi)
    gravity = GRAVITY * np.array(
        [np.sin(angle) * np.cos(heading), np.sin(angle) * np.sin(heading), -np.cos(angle)]
    )
    tilted = robot.machine.body._replace(gravity=gravity)
    parameters = {"degrees": 0.1 * strength, "heading": heading}
    return Concealed(robot.with_machine(body=tilted), robot, (), parameters)


def spring_balancer(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    stated = replace(robot, prior=robot.prior._replace(balancer=NO_BALANCER))
    gone = stated.with_machine(balancer=NO_BALANCER)
    if robot.arm.balancer[0] >= 0:  # its owner does not know that the arm has one
        balancer = robot.arm.balancer * np.array([1, 1, 1, 1, *[np.clip(0.01 * strength, 0.1, 1.0)] * 2])
    else:
        pull = 3.0 * strength * floor(robot, 1)  # the lever times the force, about
        arms = rng.uniform(0.3, 0.4), rng.uniform(0.08, 0.12)
        balancer = np.array([1.0, *arms, -0.5 * np.pi - robot.arm.home[1] + rng.uniform(-0.5, 0.5), 0.0, 0.0])
        balancer[4], balancer[5] = 20.0 * pull, pull / arms[1] - 6.0 * pull
    values = dict(zip(("d21", "d22", "phi", "Kr", "K0"), balancer[1:], strict=True))
    return Concealed(stated.with_machine(balancer=balancer), gone, (1,), values)


def joint_spring(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    stiffness = 2.0 * strength * floor(robot, joint)
    cable = [stiffness, rng.uniform(0.2, 0.6) * stiffness, robot.arm.home[joint] + rng.uniform(-0.4, 0.4)]
    tied = robot.with_machine(cable=changed(robot.machine.cable, joint, cable))
    return Concealed(tied, robot, (joint,), dict(zip(("k", "k3", "rest"), cable, strict=True)))


def kinematic_coupling(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    machine, friction = robot.machine, robot.machine.friction
    turned, other = robot.arm.joints - 1, robot.arm.joints - 2
    ratio, share = rng.choice([-1.0, 0.5, 1.0]), min(0.05 * strength, 0.9)
    dry = share * friction.coulomb[turned]
    # What a joint feels when it moves alone stays as it was: only the product of the two speeds is new.
    rotor, viscous = machine.rotor.copy(), friction.viscous.copy()
    for matrix in (rotor, viscous):
        matrix[turned, other] = matrix[other, turned] = ratio * share * matrix[turned, turned]
    coulomb = changed(friction.coulomb, turned, friction.coulomb[turned] - dry)
    coulomb[other] = max(coulomb[other] - abs(ratio) * dry, 0.0)
    coupled = robot.with_friction(
        viscous=viscous,
        coulomb=coulomb,
        pair=np.array([turned, other, ratio]),
        common=np.array([dry, friction.bristle[turned]]),
    ).with_machine(rotor=rotor)
    return Concealed(coupled, robot, (other, turned), {"ratio": ratio, "share": share})


def joint_elasticity(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    twist = 2e-4 * strength
    stiffness = robot.peak[joint] / twist
    link = carried(robot.machine.body, robot.arm.home)[joint]
    elastic = _two_masses(robot, joint, stiffness, rng.uniform(0.02, 0.08), link)
    return Concealed(elastic, robot, (joint,), {"stiffness": elastic.machine.stiffness[joint]})


def backlash(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    link = carried(robot.machine.body, robot.arm.home)[joint]
    tight = _two_masses(robot, joint, 2.5e5 * link, 0.2, link)
    gap = 5e-4 * strength
    loose = tight.with_machine(gap=changed(robot.machine.gap, joint, 0.5 * gap))
    return Concealed(loose, robot, (joint,), {"gap": gap})


def _two_masses(robot: Robot, joint: int, stiffness: float, damping: float, link: float) -> Robot:
    """A joint whose motor turns its link through a spring, damping relative to critical."""
    machine = robot.machine
    reduced = 1.0 / (1.0 / link + 1.0 / machine.rotor[joint, joint])
    stiffness = min(stiffness, 2.5e5 * link)  # a natural frequency that 2 kHz can follow
    loss = 2.0 * damping * np.sqrt(stiffness * reduced)
    return robot.with_machine(
        stiffness=changed(machine.stiffness, joint, stiffness), loss=changed(machine.loss, joint, loss)
    )


def contact_event(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    start, length = rng.uniform(4.0, 18.0), rng.uniform(0.4, 1.0)
    side = rng.normal(size=3)
    # The middle joint's floor at a lever of half a metre.
    force = strength * floor(robot, 2) / 0.5 * side / np.linalg.norm(side)
    touched = replace(robot.with_machine(touch=np.array([start, length, *force])), touched="identify_b")
    parameters = {"run": "identify_b", "start": start, "seconds": length, "force": force}
    return Concealed(touched, robot, (), parameters, span=(start, start + length))
