"""Friction of the recorded arm: bristles (LuGre) and slipping blocks; all parts of the arm."""

from typing import NamedTuple

import numpy as np

from .body import Body, njit


class Friction(NamedTuple):
    """Friction at each motor, referred to its joint."""

    coulomb: np.ndarray  # Shape (n,) [N m]
    viscous: np.ndarray  # What motors feel of their own and of each other's speed, (n, n) [N m s/rad]
    bristle: np.ndarray  # Presliding distance of the LuGre bristles, (n,) [rad]
    damping: np.ndarray  # Micro-damping of the bristles, (n,) [N m s/rad]
    creep: np.ndarray  # Velocity of sign reversal without bristles, (n,) [rad/s]; 0: bristles
    asymmetry: np.ndarray  # Share by which forward friction exceeds the mean, dry and viscous, (n, 2)
    rise: np.ndarray  # Friction at standstill above the sliding one, (n,) [N m]
    fade: np.ndarray  # Velocity at which it is gone to 1/e, (n,) [rad/s]
    load: np.ndarray  # Dry friction per torque carried, (n,) [-]
    bend: np.ndarray  # Friction with a power of the speed, (n,) [N m at 1 rad/s]
    power: np.ndarray  # That power, (n,) [-]
    thinning: np.ndarray  # Share of friction lost per kelvin, (n,) [1/K]
    spot: np.ndarray  # Rough spot: share more friction, its angle and width, (n, 3) [-, rad, rad]
    neighbour: np.ndarray  # Share more dry friction per sine of another joint's angle, (n, n) [-]
    block: np.ndarray  # Torque at which each sliding block gives way, (n, m) [N m]
    give: np.ndarray  # Deflection at which it does, (n, m) [rad]
    pair: np.ndarray  # Joints that turn a common gear, ratio of the second, (3,); first -1: none
    common: np.ndarray  # Dry friction and presliding distance of that gear, (2,) [N m, rad]


BLOCKS = 4
REFERENCE_TEMPERATURE = 35.0
"""At which friction has the values above [deg C]: half-way between a cold and a warm arm."""


def plain_friction(
    coulomb: np.ndarray, viscous: np.ndarray, bristle: np.ndarray, creep: np.ndarray, inertia: np.ndarray
) -> Friction:
    """Dry and viscous friction alone; bristles are damped to a fifth of critical against the inertia (n,)."""
    n = len(coulomb)
    damping = 0.4 * np.sqrt(coulomb / bristle * inertia)
    return Friction(
        coulomb, np.diag(viscous), bristle, damping, creep, np.zeros((n, 2)), np.zeros(n), np.ones(n),
        np.zeros(n), np.zeros(n), np.ones(n), np.zeros(n), np.tile([0.0, 0.0, 1.0], (n, 1)), np.zeros((n, n)),
        np.zeros((n, BLOCKS)), np.ones((n, BLOCKS)), np.array([-1.0, -1.0, 0.0]), np.array([0.0, 1e-5]),
    )  # fmt: skip


@njit(cache=True)
def bend_bristle(deflection, velocity, reach, step):
    """Deflection of a bristle a step later; implicit, so that fast sliding cannot overshoot."""
    return (deflection + velocity * step) / (1.0 + abs(velocity) * step / reach)


@njit(cache=True)
def dry(friction, j, position, velocity, load, warmth):
    """Level of dry friction of joint j [N m]."""
    level = friction.coulomb[j] * (1.0 + friction.asymmetry[j, 0] * np.sign(velocity[j]))
    level *= np.exp(-0.3 * friction.thinning[j] * warmth)
    away = (position[j] - friction.spot[j, 1]) / friction.spot[j, 2]
    level *= 1.0 + friction.spot[j, 0] * np.exp(-(away**2))
    for k in range(len(position)):
        if friction.neighbour[j, k] != 0.0:
            level *= 1.0 + friction.neighbour[j, k] * np.sin(position[k])
    level += friction.rise[j] * np.exp(-abs(velocity[j]) / friction.fade[j])
    # Teeth carry their preload too, so that friction sets in softly with the load.
    preload = 2.0 * friction.coulomb[j]
    return level + friction.load[j] * (np.sqrt(preload**2 + load[j] ** 2) - preload)


@njit(cache=True)
def wet(friction, j, velocity, warmth):
    """Friction of joint j that depends on speed [N m]."""
    drag = 0.0
    for k in range(len(velocity)):
        drag += friction.viscous[j, k] * velocity[k]
    drag *= 1.0 + friction.asymmetry[j, 1] * np.sign(velocity[j])
    drag *= np.exp(-friction.thinning[j] * warmth)
    return drag + friction.bend[j] * np.sign(velocity[j]) * abs(velocity[j]) ** friction.power[j]


@njit(cache=True)
def slide(friction, j, blocks, velocity, step):
    """Torque of the sliding blocks of joint j, whose deflections (m,) move on."""
    torque = 0.0
    for k in range(len(blocks)):
        reach = friction.give[j, k]
        blocks[k] = min(max(blocks[k] + velocity * step, -reach), reach)
        torque += friction.block[j, k] * blocks[k] / reach
    return torque


@njit(cache=True)
def add_friction(friction, position, velocity, load, temperature, bristles, blocks, step, torque):
    """Friction torque of all joints, into `torque` (n,); moves the bristles (n + 1,) and blocks (n, m) on."""
    n = len(velocity)
    for j in range(n):
        warmth = temperature[j] - REFERENCE_TEMPERATURE
        before, reach = bristles[j], friction.bristle[j]
        bristles[j] = bend_bristle(before, velocity[j], reach, step)
        level = dry(friction, j, position, velocity, load, warmth)
        if friction.creep[j] > 0.0:
            torque[j] = level * velocity[j] / np.sqrt(velocity[j] ** 2 + friction.creep[j] ** 2)
        else:
            torque[j] = level * bristles[j] / reach + friction.damping[j] * (bristles[j] - before) / step
        torque[j] += wet(friction, j, velocity, warmth) + slide(friction, j, blocks[j], velocity[j], step)
    a, b = int(friction.pair[0]), int(friction.pair[1])
    if a >= 0:
        ratio, reach = friction.pair[2], friction.common[1]
        bristles[n] = bend_bristle(bristles[n], velocity[a] + ratio * velocity[b], reach, step)
        torque[a] += friction.common[0] * bristles[n] / reach
        torque[b] += ratio * friction.common[0] * bristles[n] / reach


class Machine(NamedTuple):
    """An arm with its drives; all torques and angles at the joints."""

    body: Body  # Its links
    friction: Friction  # At the motors
    rotor: np.ndarray  # Inertia of the motors; off the diagonal where they turn each other, (n, n) [kg m^2]
    offset: np.ndarray  # Constant torque beside the current's, (n,) [N m]
    knee: np.ndarray  # Torque at which the magnets saturate, (n,) [N m]
    stiffness: np.ndarray  # Of the transmission, (n,) [N m/rad]; zero is rigid
    loss: np.ndarray  # Its damping, (n,) [N m s/rad]
    gap: np.ndarray  # Half the dead zone of the teeth, (n,) [rad]
    cable: np.ndarray  # Stiffness of a cable, how it stiffens, its rest, (n, 3) [N m/rad, N m/rad^3, rad]
    order: np.ndarray  # Waves of the ripple per joint turn, (n, h) [1]
    wave: np.ndarray  # Their amplitude, (n, h) [N m]
    phase: np.ndarray  # Their phase, (n, h) [rad]
    balancer: np.ndarray  # Joint, d21, d22, phi, Kr, K0, (6,) [-, m, m, rad, N/m, N]; joint -1 is none
    touch: np.ndarray  # Start, duration, force on the flange in the base frame, (5,) [s, s, N]
    hose: np.ndarray  # Stiffness of a hose from the flange to an anchor, and where that is, (4,) [N/m, m]
    shake: np.ndarray  # Amplitude of the floor's acceleration, its frequency, (4,) [m/s^2, Hz]
    miscount: np.ndarray  # What the encoders read too little, (n,) [rad]
    ring: np.ndarray  # Amplitude, waves a turn, phase of uneven encoder rings, (n, 3) [rad, 1, rad]
    loose: np.ndarray  # Mass swinging on the flange, stiffness, damping, (3,) [kg, N/m, N s/m]
    spindle: np.ndarray  # Angular momentum of what spins on the flange, in its frame, (3,) [N m s]
    count: np.ndarray  # Step of the drive's encoder, (n,) [rad]
    heat: np.ndarray  # Warming by friction power, (n,) [K/J]
    cooling: np.ndarray  # Time constant of cooling down, (n,) [s]
    push: np.ndarray  # Gains of the drive: position, velocity, integral, feed-forward of acceleration, (n, 4)


class State(NamedTuple):
    """What moves on from step to step; each (n,) but for friction's and the loose mass's."""

    link: np.ndarray  # Position behind the transmission [rad]
    motor: np.ndarray  # Position before it [rad]
    velocity: np.ndarray  # Of the link [rad/s]
    spin: np.ndarray  # Of the motor [rad/s]
    bristles: np.ndarray  # Deflections, (n + 1,) [rad]
    blocks: np.ndarray  # Deflections, (n, m) [rad]
    temperature: np.ndarray  # Of the grease [deg C]
    load: np.ndarray  # Torque through the teeth in the last step [N m]
    seen: np.ndarray  # Position that the drive read [rad]
    speed: np.ndarray  # Velocity that it makes of it [rad/s]
    summed: np.ndarray  # Its integral part [N m]
    # Of the loose mass, in the base frame: place, velocity, place of the flange a step ago, force on the
    # flange, (4, 3) [m, m/s, m, N]
    sway: np.ndarray
