"""The vocabulary of effects, and the joints at which each makes sense."""

import numpy as np

from ..robots.robot import Robot, carried
from .arm_effects import (
    backlash,
    base_tilt,
    contact_event,
    joint_elasticity,
    joint_spring,
    kinematic_coupling,
    link_inertia,
    payload,
    rotor_inertia,
    spring_balancer,
)
from .drive_effects import (
    current_clipping,
    current_offset,
    drive_gain,
    drive_gain_saturation,
    encoder_offset,
    time_delay,
    torque_ripple,
)
from .effect import Conceal
from .friction_effects import (
    coulomb_friction,
    friction_asymmetry,
    hysteresis,
    load_dependent_friction,
    nonlinear_viscous_friction,
    position_dependent_friction,
    stribeck_friction,
    temperature_dependent_friction,
    viscous_friction,
)

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
