"""The vocabulary of effects, how each is put into a robot, and the joints at which each makes sense.

An effect takes a robot, a joint, a strength and random numbers, and gives the robot with the effect. Strength
1 is about one noise floor; what it really is, is measured. Torques are scaled by the joint's noise floor.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .plant.body import weld
from .record import REST
from .robot import NO_BALANCER, Robot, Tool, carried


@dataclass(frozen=True)
class Concealed:
    """A robot with something concealed in it."""

    robot: Robot  # With the effect
    # Without it; what is recorded of both differs by the effect's torque, `part` of it if the effect cannot
    # be taken away altogether
    sound: Robot
    joints: tuple[int, ...]  # Where it is, counted from 0; empty where it belongs to the whole arm
    parameters: dict[str, Any]  # Its entry in a truth file
    part: float = 1.0  # Share of the effect by which the two robots differ [-]
    span: tuple[float, float] = (0.0, np.inf)  # Times of the run between which it is there [s]


Conceal = Callable[[Robot, int, float, np.random.Generator], Concealed]


def changed(values: np.ndarray, place: Any, value: Any) -> np.ndarray:
    """A copy with one entry, or row, replaced."""
    copy = np.array(values, float)
    copy[place] = value
    return copy


def floor(robot: Robot, joint: int) -> float:
    """Noise floor of a joint [N m]."""
    return float(robot.recorder.floor[joint])


def viscous_friction(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    viscous, drag = robot.machine.friction.viscous, strength * floor(robot, joint)
    drag /= 0.35 * robot.arm.limits.velocity[joint]
    fitted = robot.without_term("viscous", joint)
    there = fitted.with_friction(viscous=changed(viscous, (joint, joint), drag))
    gone = fitted.with_friction(viscous=changed(viscous, (joint, joint), 0.0))
    return Concealed(there, gone, (joint,), {"Fv": drag})


def coulomb_friction(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    coulomb, level = robot.machine.friction.coulomb, strength * floor(robot, joint)
    fitted = robot.without_term("coulomb", joint)
    there = fitted.with_friction(coulomb=changed(coulomb, joint, level))
    gone = fitted.with_friction(coulomb=changed(coulomb, joint, 0.0))
    return Concealed(there, gone, (joint,), {"Fc": level})


def friction_asymmetry(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    # In dry friction alone it would be a constant, which is a current offset by another name.
    friction = robot.machine.friction
    drag = friction.viscous[joint, joint] * 0.35 * robot.arm.limits.velocity[joint]
    share = min(strength * floor(robot, joint) / drag, 0.8) * rng.choice([-1.0, 1.0])
    dry = share * rng.uniform(0.0, 1.0)
    changed_arm = robot.with_friction(asymmetry=changed(friction.asymmetry, joint, [dry, share]))
    return Concealed(changed_arm, robot, (joint,), {"dry": dry, "viscous": share})


def stribeck_friction(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    friction, rise = robot.machine.friction, 2.5 * strength * floor(robot, joint)
    speed = rng.uniform(0.03, 0.12) * robot.arm.limits.velocity[joint]
    changed_arm = robot.with_friction(
        rise=changed(friction.rise, joint, rise), fade=changed(friction.fade, joint, speed)
    )
    return Concealed(changed_arm, robot, (joint,), {"rise": rise, "speed": speed})


def load_dependent_friction(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    share = strength * floor(robot, joint) / (0.3 * robot.peak[joint])
    changed_arm = robot.with_friction(load=changed(robot.machine.friction.load, joint, share))
    return Concealed(changed_arm, robot, (joint,), {"mu": share})


def nonlinear_viscous_friction(
    robot: Robot, joint: int, strength: float, rng: np.random.Generator
) -> Concealed:
    friction, power = robot.machine.friction, rng.choice([1.7, 2.2, 3.0])
    bend = 1.5 * strength * floor(robot, joint) / (0.5 * robot.arm.limits.velocity[joint]) ** power
    changed_arm = robot.with_friction(
        bend=changed(friction.bend, joint, bend), power=changed(friction.power, joint, power)
    )
    return Concealed(changed_arm, robot, (joint,), {"coefficient": bend, "power": power})


def temperature_dependent_friction(
    robot: Robot, joint: int, strength: float, rng: np.random.Generator
) -> Concealed:
    share = min(0.003 * strength, 0.06)  # faster than halving every 12 K no grease thins
    changed_arm = robot.with_friction(thinning=changed(robot.machine.friction.thinning, joint, share))
    return Concealed(changed_arm, robot, (joint,), {"per_kelvin": share})


def position_dependent_friction(
    robot: Robot, joint: int, strength: float, rng: np.random.Generator
) -> Concealed:
    friction = robot.machine.friction
    depth = 2.0 * strength * floor(robot, joint) / max(friction.coulomb[joint], 1e-9)
    spot = [depth, robot.arm.home[joint] + rng.uniform(-0.4, 0.4), rng.uniform(0.2, 0.5)]
    changed_arm = robot.with_friction(spot=changed(friction.spot, joint, spot))
    return Concealed(changed_arm, robot, (joint,), dict(zip(("depth", "angle", "width"), spot, strict=True)))


def hysteresis(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    friction = robot.machine.friction
    level, wide = 2.0 * strength * floor(robot, joint), 1.0
    if level > 0.9 * friction.coulomb[joint]:  # all dry friction is by blocks then: stronger is wider
        wide, level = level / (0.9 * friction.coulomb[joint]), 0.9 * friction.coulomb[joint]
    reach = wide * rng.uniform(0.003, 0.01) * np.array([0.3, 0.7, 1.2, 2.0])
    sliding = robot.with_friction(
        coulomb=changed(friction.coulomb, joint, friction.coulomb[joint] - level),
        block=changed(friction.block, joint, level / 4.0),
        give=changed(friction.give, joint, reach),
    )
    return Concealed(sliding, robot, (joint,), {"torque": level, "presliding": reach})


def drive_gain(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    error = rng.choice([-1.0, 1.0]) * min(strength * 0.02, 0.4)
    scaled = robot.with_recorder(
        gain=changed(robot.recorder.gain, joint, robot.arm.gain[joint] * (1.0 + error))
    )
    return Concealed(scaled, robot, (joint,), {"error": error})


def drive_gain_saturation(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    peak = robot.peak[joint]
    knee = np.sqrt(peak**3 / (6.0 * strength * floor(robot, joint)))
    knee = max(knee, 1.1 * peak)  # less would not carry the arm
    droop = robot.with_machine(knee=changed(robot.machine.knee, joint, knee))
    return Concealed(droop, robot, (joint,), {"knee": knee})


def current_offset(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    offset = rng.choice([-1.0, 1.0]) * strength * floor(robot, joint)
    fitted = robot.without_term("offset", joint)
    there = fitted.with_machine(offset=changed(robot.machine.offset, joint, offset))
    gone = fitted.with_machine(offset=changed(robot.machine.offset, joint, 0.0))
    return Concealed(there, gone, (joint,), {"offset": offset})


def torque_ripple(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    machine, shares = robot.machine, rng.dirichlet([2.0, 2.0, 1.0, 1.0])
    wave = strength * floor(robot, joint) * 2.0 * shares
    rippled = robot.with_machine(wave=changed(machine.wave, joint, wave))
    return Concealed(rippled, robot, (joint,), {"amplitude": wave, "order": machine.order[joint]})


def current_clipping(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    level = robot.peak[joint] / (1.0 + 0.1 * strength)
    level = max(level, 0.35 * robot.peak[joint])
    clipped = robot.with_recorder(clip=changed(robot.recorder.clip, joint, level))
    return Concealed(clipped, robot, (joint,), {"torque": level})


def encoder_offset(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    # Who sets a joint by eye is wrong by some degrees; more, and the arm does not go where it is sent.
    angle = rng.choice([-1.0, 1.0]) * min(np.deg2rad(0.3 * strength), 0.15)
    shifted = robot.with_machine(miscount=changed(robot.machine.miscount, joint, angle))
    return Concealed(shifted, robot, (joint,), {"radians": angle})


def time_delay(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    delay = rng.choice([-1.0, 1.0]) * min(0.001 * strength, 0.03)
    return Concealed(robot.with_recorder(delay=delay), robot, (), {"seconds": delay})


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
    # What a joint feels when it moves alone stays as it was: only the product of the two speeds is new.
    dry = min(share * friction.coulomb[turned], friction.coulomb[other] / abs(ratio))
    rotor, viscous = machine.rotor.copy(), friction.viscous.copy()
    for matrix in (rotor, viscous):
        matrix[turned, other] = matrix[other, turned] = ratio * share * matrix[turned, turned]
    coulomb = changed(friction.coulomb, turned, friction.coulomb[turned] - dry)
    coulomb[other] -= abs(ratio) * dry
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


VOCABULARY: dict[str, Conceal] = {
    effect.__name__: effect
    for effect in (
        link_inertia, payload, rotor_inertia, base_tilt, viscous_friction, coulomb_friction,
        friction_asymmetry, stribeck_friction, load_dependent_friction, nonlinear_viscous_friction,
        temperature_dependent_friction, position_dependent_friction, hysteresis, spring_balancer,
        joint_spring, drive_gain, drive_gain_saturation, current_offset, torque_ripple, current_clipping,
        kinematic_coupling, joint_elasticity, backlash, encoder_offset, time_delay, contact_event,
    )
}  # fmt: skip


def places(effect: str, robot: Robot) -> list[int]:
    """Joints, counted from 0, at which an effect makes sense."""
    n = robot.arm.joints
    if effect == "rotor_inertia":  # that of the first two is one with their links' inertia
        return list(range(2, n))
    if effect in ("link_inertia", "load_dependent_friction", "drive_gain_saturation"):
        return list(range(1, n - 1))
    if effect == "encoder_offset":
        return list(range(1, n - 1))
    if effect in ("joint_elasticity", "backlash"):
        # Behind a motor heavier than five times its link, nothing of the link's swinging is felt.
        ratio = carried(robot.machine.body, robot.arm.home) / np.diag(robot.machine.rotor)
        return [j for j in range(n) if ratio[j] > 0.2]
    if effect in ("position_dependent_friction", "hysteresis"):
        return [j for j in range(n) if robot.machine.friction.coulomb[j] > 0.0]
    return list(range(n))


def floor_vibration(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    """The floor shakes at 7.3 Hz: a press next door."""
    side = rng.normal(size=3)
    shake = np.array([*(0.02 * strength * side / np.linalg.norm(side)), 7.3])
    return Concealed(robot.with_machine(shake=shake), robot, (), {"acceleration": shake[:3], "hertz": 7.3})


def current_crosstalk(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    """A current sensor also feels its neighbour's current, which has nothing to do with its own joint."""
    other = int(rng.choice([k for k in range(min(robot.arm.joints, 4)) if k != joint]))
    per_current = robot.recorder.gain / robot.recorder.gain[joint]
    leak = strength * floor(robot, joint) / (0.4 * robot.peak[other]) * per_current[other]
    mix = robot.recorder.mix.copy()
    mix[joint, other] = leak
    return Concealed(robot.with_recorder(mix=mix), robot, (joint,), {"from": other + 1, "share": leak})


def hose_spring(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    """A hose pulls the flange towards a bracket at the ceiling."""
    anchor = np.array([rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5), rng.uniform(1.5, 2.5)])
    hose = np.array([strength * floor(robot, 2), *anchor])
    parameters = {"stiffness": hose[0], "anchor": anchor}
    return Concealed(robot.with_machine(hose=hose), robot, (), parameters)


def neighbour_friction(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    """A bearing is bent, and has more friction, by the position of another joint."""
    other = int(rng.choice([k for k in range(robot.arm.joints) if k != joint]))
    level = max(robot.machine.friction.coulomb[joint], 1e-9)
    share = rng.choice([-1.0, 1.0]) * min(3.0 * strength * floor(robot, joint) / level, 0.95)
    neighbour = robot.machine.friction.neighbour.copy()
    neighbour[joint, other] = share
    changed_arm = robot.with_friction(neighbour=neighbour)
    return Concealed(changed_arm, robot, (joint,), {"neighbour": other + 1, "share": share})


def supply_sag(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    """All drives need more current while the arm as a whole draws power."""
    sag = min(0.02 * strength, 0.5)
    return Concealed(robot.with_recorder(sag=sag), robot, (), {"share": sag})


def supply_pulse(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    """One drive's torque pulses with a beat in its supply."""
    surge, hertz = np.zeros(robot.arm.joints + 1), rng.uniform(2.0, 9.0)
    surge[joint], surge[-1] = strength * floor(robot, joint), hertz
    return Concealed(
        robot.with_recorder(surge=surge), robot, (joint,), {"torque": surge[joint], "hertz": hertz}
    )


def wandering_friction(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    """Dry friction comes and goes at random as grease lumps pass."""
    lump = changed(robot.recorder.lump, joint, 2.0 * strength * floor(robot, joint))
    return Concealed(robot.with_recorder(lump=lump), robot, (joint,), {"torque": lump[joint]})


def uneven_encoder(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    """An encoder's ring is uneven: what it reads errs by some waves a turn."""
    waves, phase = float(rng.integers(4, 13)), rng.uniform(0.0, 2.0 * np.pi)
    # Whoever sees the speed wrong by more than a quarter sends the encoder back.
    amplitude = min(0.02 * strength, 0.25) / waves
    ring = changed(robot.machine.ring, joint, [amplitude, waves, phase])
    parameters = {"radians": amplitude, "waves": waves, "phase": phase}
    return Concealed(robot.with_machine(ring=ring), robot, (joint,), parameters)


def swinging_tool(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    """A tool of known mass hangs on rubber and swings; its owner takes it to be part of the last link."""
    last, mass = robot.arm.joints - 1, min(0.1 * strength, 1.0) * robot.arm.tool.mass
    hertz, damping = rng.uniform(1.5, 4.0), rng.uniform(0.03, 0.15)
    fast = 2.0 * np.pi * hertz
    loose = np.array([mass, mass * fast**2, 2.0 * damping * mass * fast])
    firm, nominal = (
        weld(body, last, mass, np.zeros(3), np.zeros((3, 3)))
        for body in (robot.machine.body, robot.prior.body)
    )
    stated = replace(robot, prior=robot.prior._replace(body=nominal))
    parameters = {"mass": mass, "hertz": hertz, "damping": damping}
    return Concealed(stated.with_machine(loose=loose), stated.with_machine(body=firm), (), parameters)


def spinning_tool(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    """A spindle runs on the flange: a gyroscope, which resists being turned about."""
    side = rng.normal(size=3)
    # Felt at the wrist first, where links turn at about a third of the joints' limit.
    wrist = robot.arm.joints - 2
    momentum = 4.0 * strength * floor(robot, wrist) / robot.arm.limits.velocity[wrist]
    spindle = momentum * side / np.linalg.norm(side)
    return Concealed(robot.with_machine(spindle=spindle), robot, (), {"momentum": spindle})


def dragging_brake(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    """A brake opens slowly, and drags for some seconds after every start."""
    drag = np.array([2.0 * strength * floor(robot, joint), rng.uniform(4.0, 9.0)])
    slow = robot.with_recorder(drag=changed(robot.recorder.drag, joint, drag))
    parameters = {"torque": drag[0], "seconds": drag[1]}
    return Concealed(slow, robot, (joint,), parameters, span=(0.0, REST + drag[1]))


def axis_misalignment(robot: Robot, joint: int, strength: float, rng: np.random.Generator) -> Concealed:
    """A joint's axis is tenths of a degree from where its drawing has it."""
    joint, body = max(joint, 1), robot.machine.body
    angle, heading = min(0.001 * strength, 0.01), rng.uniform(0.0, 2.0 * np.pi)
    lean = Rotation.from_rotvec([angle * np.cos(heading), angle * np.sin(heading), 0.0]).as_matrix()
    rotation = changed(body.rotation, joint, body.rotation[joint] @ lean)
    leaning = robot.with_machine(body=body._replace(rotation=rotation))
    return Concealed(leaning, robot, (joint,), {"radians": angle, "heading": heading})


OUTSIDE: dict[str, Conceal] = {
    effect.__name__: effect
    for effect in (
        floor_vibration, current_crosstalk, hose_spring, neighbour_friction, supply_sag, supply_pulse,
        wandering_friction, uneven_encoder, swinging_tool, spinning_tool, dragging_brake,
        axis_misalignment,
    )
}  # fmt: skip
