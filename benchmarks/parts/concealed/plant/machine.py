"""What a recorded arm is made of, and what of it moves."""

from typing import NamedTuple

import numpy as np

from .body import Body
from .friction import Friction


class Machine(NamedTuple):
    """An arm with its drives; all torques and angles at the joints.

    Attributes:
        body: Its links.
        friction: At the motors.
        rotor: Inertia of the motors; off the diagonal where they turn each other, (n, n) [kg m^2].
        offset: Constant torque beside the current's, (n,) [N m].
        knee: Torque at which the magnets saturate, (n,) [N m].
        stiffness: Of the transmission, (n,) [N m/rad]; zero is rigid.
        loss: Its damping, (n,) [N m s/rad].
        gap: Half the dead zone of the teeth, (n,) [rad].
        cable: Stiffness of a cable, how it stiffens, its rest, (n, 3) [N m/rad, N m/rad^3, rad].
        order: Waves of the ripple per joint turn, (n, h) [1].
        wave: Their amplitude, (n, h) [N m].
        phase: Their phase, (n, h) [rad].
        balancer: Joint, d21, d22, phi, Kr, K0, (6,) [-, m, m, rad, N/m, N]; joint -1 is none.
        touch: Start, duration, force on the flange in the base frame, (5,) [s, s, N].
        hose: Stiffness of a hose from the flange to an anchor, and where that is, (4,) [N/m, m].
        shake: Amplitude of the floor's acceleration, its frequency, (4,) [m/s^2, Hz].
        miscount: What the encoders read too little, (n,) [rad].
        ring: Amplitude, waves a turn and phase of what uneven encoder rings add to it, (n, 3) [rad, 1, rad].
        loose: Mass that swings on the flange, stiffness and damping of its mount, (3,) [kg, N/m, N s/m].
        spindle: Angular momentum of what spins on the flange, in its frame, (3,) [N m s].
        count: Step of the drive's encoder, (n,) [rad].
        heat: Warming by friction power, (n,) [K/J].
        cooling: Time constant of cooling down, (n,) [s].
        push: Gains of the drive: position, velocity, integral, feed-forward of acceleration, (n, 4).
    """

    body: Body
    friction: Friction
    rotor: np.ndarray
    offset: np.ndarray
    knee: np.ndarray
    stiffness: np.ndarray
    loss: np.ndarray
    gap: np.ndarray
    cable: np.ndarray
    order: np.ndarray
    wave: np.ndarray
    phase: np.ndarray
    balancer: np.ndarray
    touch: np.ndarray
    hose: np.ndarray
    shake: np.ndarray
    miscount: np.ndarray
    ring: np.ndarray
    loose: np.ndarray
    spindle: np.ndarray
    count: np.ndarray
    heat: np.ndarray
    cooling: np.ndarray
    push: np.ndarray


class State(NamedTuple):
    """What moves on from step to step; each (n,) but for friction's and the loose mass's.

    Attributes:
        link: Position behind the transmission [rad].
        motor: Position before it [rad].
        velocity: Of the link [rad/s].
        spin: Of the motor [rad/s].
        bristles: Deflections, (n + 1,) [rad].
        blocks: Deflections, (n, m) [rad].
        temperature: Of the grease [deg C].
        load: Torque through the teeth in the last step [N m].
        seen: Position that the drive read [rad].
        speed: Velocity that it makes of it [rad/s].
        summed: Its integral part [N m].
        sway: Of the loose mass, in the base frame: place, velocity, place of the flange a step ago, force on
            the flange, (4, 3) [m, m/s, m, N].
    """

    link: np.ndarray
    motor: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    bristles: np.ndarray
    blocks: np.ndarray
    temperature: np.ndarray
    load: np.ndarray
    seen: np.ndarray
    speed: np.ndarray
    summed: np.ndarray
    sway: np.ndarray
