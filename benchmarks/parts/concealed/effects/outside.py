"""What can be wrong with a robot and has no name in the vocabulary."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..plant.body import weld
from ..recordings.motion import REST
from ..robots.robot import Robot
from .vocabulary import Conceal, Concealed, changed, floor


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
