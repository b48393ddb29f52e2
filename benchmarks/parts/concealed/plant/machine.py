"""What a recorded arm is made of, and what of it moves."""

from typing import NamedTuple

import numpy as np

from .body import Body
from .friction import Friction


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
    # Amplitude, waves a turn and phase of what uneven encoder rings add to it, (n, 3) [rad, 1, rad]
    ring: np.ndarray
    # Mass that swings on the flange, stiffness and damping of its mount, (3,) [kg, N/m, N s/m]
    loose: np.ndarray
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
