"""Torques on the links and through the transmissions of a recorded arm."""

import numpy as np

from .body import cross, flange, inverse_dynamics, njit


@njit(cache=True)
def springs(machine, position):
    """Torque that cables and the balancer put on the links, (n,)."""
    torque = np.empty(len(position))
    for j in range(len(position)):
        stretch = position[j] - machine.cable[j, 2]
        torque[j] = -machine.cable[j, 0] * stretch - machine.cable[j, 1] * stretch**3
    j = int(machine.balancer[0])
    if j >= 0:
        d21, d22, angle = machine.balancer[1], machine.balancer[2], machine.balancer[3] + position[j]
        length = np.sqrt(d21**2 + d22**2 + 2.0 * d21 * d22 * np.cos(angle))
        force = machine.balancer[4] * length + machine.balancer[5]
        torque[j] -= force * d21 * d22 * np.sin(angle) / length
    return torque


@njit(cache=True)
def ripple(machine, j, position):
    """Cogging of motor j [N m]."""
    torque = 0.0
    for k in range(machine.order.shape[1]):
        if machine.wave[j, k] != 0.0:
            torque += machine.wave[j, k] * np.cos(machine.order[j, k] * position + machine.phase[j, k])
    return torque


@njit(cache=True)
def misread(machine, j, motor):
    """What encoder j reads too little at a motor's position [rad]."""
    amplitude, waves, phase = machine.ring[j]
    return machine.miscount[j] + amplitude * np.sin(waves * motor + phase)


@njit(cache=True)
def swing(machine, turned, sway, step):
    """Move the loose mass (4, 3) on by a step, and put down its force on the flange."""
    mass, stiffness, damping = machine.loose
    if mass == 0.0:
        return
    place, frame = np.zeros(3), np.eye(3)
    flange(machine.body.translation, turned, place, frame)
    sway[3] = stiffness * (sway[0] - place) + damping * (sway[1] - (place - sway[2]) / step)
    sway[1] += step * (machine.body.gravity - sway[3] / mass)
    sway[0] += step * sway[1]
    sway[2] = place


@njit(cache=True)
def hang(machine, turned):
    """The loose mass at rest, (4, 3)."""
    sway, frame = np.zeros((4, 3)), np.eye(3)
    if machine.loose[0] > 0.0:
        flange(machine.body.translation, turned, sway[2], frame)
        sway[3] = machine.loose[0] * machine.body.gravity
        sway[0] = sway[2] + sway[3] / machine.loose[1]
    return sway


@njit(cache=True)
def gyration(spindle, turned, velocity):
    """Torque that it takes to turn a spinning spindle about, (n,)."""
    axes, frame, spin, moment = np.empty(turned.shape[:2]), np.eye(3), np.zeros(3), np.empty(3)
    for j in range(len(turned)):
        frame = frame @ turned[j]
        axes[j] = frame[:, 2]
        spin += velocity[j] * axes[j]
    cross(spin, frame @ spindle, moment)
    return axes @ moment


@njit(cache=True)
def pulls(machine, turned, sway, time, pull):
    """Force on the flange from contact, hose and loose mass, in its own frame, into `pull` (3,)."""
    pull[:] = 0.0
    since = (time - machine.touch[0]) / machine.touch[1]
    touched = 0.0 < since < 1.0
    if not touched and machine.hose[0] == 0.0 and machine.loose[0] == 0.0:
        return
    place, frame = np.zeros(3), np.eye(3)
    flange(machine.body.translation, turned, place, frame)
    force = -machine.hose[0] * (place - machine.hose[1:4])
    if touched:
        force += machine.touch[2:5] * min(1.0, 8.0 * since, 8.0 * (1.0 - since))
    pull[:] = frame.T @ (force + sway[3])


@njit(cache=True)
def resistance(machine, turned, position, velocity, sway, time):
    """Torque that a steady motion of the links takes, springs taken off, (n,)."""
    pull, torque, steady = np.zeros(3), np.empty(len(position)), np.zeros(len(position))
    pulls(machine, turned, sway, time, pull)
    base = machine.shake[:3] * np.sin(2.0 * np.pi * machine.shake[3] * time) - machine.body.gravity
    inverse_dynamics(machine.body, turned, velocity, steady, base, pull, torque)
    if np.any(machine.spindle != 0.0):
        torque += gyration(machine.spindle, turned, velocity)
    return torque - springs(machine, position)


@njit(cache=True)
def windup(machine, j, twist, rate):
    """Torque through the transmission of joint j, from the motor to the link."""
    if abs(twist) <= machine.gap[j]:
        return 0.0
    return machine.stiffness[j] * (twist - np.sign(twist) * machine.gap[j]) + machine.loss[j] * rate


@njit(cache=True)
def saturate(command, knee):
    """Torque of a motor whose magnets saturate softly."""
    return knee * np.tanh(command / knee)
