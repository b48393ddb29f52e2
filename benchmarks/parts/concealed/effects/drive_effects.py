"""Effects of drives, sensors and their logs."""

import numpy as np

from ..robots.robot import Robot
from .effect import Concealed, changed, floor


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
