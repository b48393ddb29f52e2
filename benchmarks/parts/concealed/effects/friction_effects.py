"""Effects of friction: by other laws than those that are fitted."""

import numpy as np

from ..robots.robot import Robot
from .effect import Concealed, changed, floor


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
