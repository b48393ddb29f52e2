"""The arm that is recorded: bodies, friction, transmissions and drives in closed loop at 2 kHz.

Positions and velocities leap over each other by half a step, so that position and torque of a sample belong
to the same instant to second order.
"""

from typing import NamedTuple

import numpy as np

from .body import mass_matrix, njit, solve, turn
from .forces import hang, misread, resistance, ripple, saturate, swing, windup
from .friction import Machine, State, add_friction

STEP = 0.0005
"""Time step of physics and drives [s]."""
RATE = 500.0
"""Samples a second that are recorded [Hz]."""
EVERY = 4
"""Steps a sample."""
SETTLE = 0.5
"""What the drives hold still before a recording begins [s]."""
AMBIENT = 24.0
"""Around the arm [deg C]."""


class Log(NamedTuple):
    """What happened, at the recording's rate."""

    position: np.ndarray  # At the motors, as their encoders would read without steps, (t, n) [rad]
    link: np.ndarray  # Behind the transmissions, (t, n) [rad]
    command: np.ndarray  # Torque that the drives asked for, which is the current times the gain, (t, n) [N m]
    temperature: np.ndarray  # Of the grease, (t, n) [deg C]


@njit(cache=True)
def at_rest(machine, wanted, warm):
    """Standing at a position (n,) as the drives count it, held by them."""
    n = len(wanted)
    motor = wanted.copy()
    for _ in range(12):  # rings err by a quarter of what is turned at most: 1e-7 of it is left
        for j in range(n):
            motor[j] = wanted[j] + misread(machine, j, motor[j])
    link, still, turned = motor.copy(), np.zeros(n), np.empty((n, 3, 3))
    turn(machine.body.rotation, link, turned)
    sway = hang(machine, turned)
    held = resistance(machine, turned, link, still, sway, 0.0)
    for j in range(n):
        if machine.stiffness[j] > 0.0:
            link[j] -= held[j] / machine.stiffness[j] + np.sign(held[j]) * machine.gap[j]
    bristles, blocks = np.zeros(n + 1), np.zeros(machine.friction.block.shape)
    summed = held - machine.offset
    return State(
        link, motor, still, still.copy(), bristles, blocks, warm.copy(), held, wanted.copy(), still.copy(),
        summed, sway,
    )  # fmt: skip


@njit(cache=True)
def drive(machine, state, wanted, wanted_velocity, wanted_acceleration, command):
    """What the cascade of every drive asks for, into `command` (n,) [N m]."""
    for j in range(len(wanted)):
        gain = machine.push[j]
        shown = state.motor[j] - misread(machine, j, state.motor[j])
        read = machine.count[j] * np.round(shown / machine.count[j])
        state.speed[j] += 0.38 * ((read - state.seen[j]) / STEP - state.speed[j])  # a low-pass of 150 Hz
        state.seen[j] = read
        error = wanted_velocity[j] + gain[0] * (wanted[j] - read) - state.speed[j]
        state.summed[j] += gain[2] * error * STEP
        command[j] = gain[1] * error + state.summed[j] + gain[3] * wanted_acceleration[j]


@njit(cache=True)
def motor_torques(machine, state, command, disturbance, net):
    """Torque of the motors that their friction leaves, into `net` (n,); friction warms the grease."""
    friction, temperature = machine.friction, state.temperature
    add_friction(
        friction, state.motor, state.spin, state.load, temperature, state.bristles, state.blocks, STEP, net
    )
    for j in range(len(command)):
        cooling = (temperature[j] - AMBIENT) / machine.cooling[j]
        temperature[j] += STEP * (machine.heat[j] * net[j] * state.spin[j] - cooling)
        turning = saturate(command[j], machine.knee[j]) + machine.offset[j] + disturbance[j]
        net[j] = turning + ripple(machine, j, state.motor[j]) - net[j]


@njit(cache=True)
def advance(machine, state, net, time):
    """Move motors and links on by a step under the motors' torques (n,)."""
    n = len(net)
    turned, matrix, gained = np.empty((n, 3, 3)), np.empty((n, n)), np.empty(n)
    turn(machine.body.rotation, state.link, turned)
    swing(machine, turned, state.sway, STEP)
    held = resistance(machine, turned, state.link, state.velocity, state.sway, time)
    mass_matrix(machine.body, turned, matrix)
    for j in range(n):
        if machine.stiffness[j] > 0.0:
            through = windup(machine, j, state.motor[j] - state.link[j], state.spin[j] - state.velocity[j])
            state.spin[j] += STEP * (net[j] - through) / machine.rotor[j, j]
            net[j] = through
        else:
            for k in range(n):
                matrix[j, k] += machine.rotor[j, k]
    solve(matrix, net - held, gained)
    for j in range(n):
        rigid = machine.stiffness[j] == 0.0
        state.load[j] = net[j] - rigid * machine.rotor[j, j] * gained[j]
        state.velocity[j] += STEP * gained[j]
        state.link[j] += STEP * state.velocity[j]
        if rigid:
            state.spin[j], state.motor[j] = state.velocity[j], state.link[j]
        else:
            state.motor[j] += STEP * state.spin[j]


@njit(cache=True)
def simulate(machine, wanted, wanted_velocity, wanted_acceleration, disturbance, warm):
    """Follow a path (s, n) as the drives count it, given every STEP, under a disturbance (s, n) [N m].

    Returns:
        Position at the motors as encoders read it, position of the links, torque asked for, temperature, each
        (s / EVERY, n).
    """
    steps, n = wanted.shape
    log = np.empty((4, (steps + EVERY - 1) // EVERY, n))
    command, net = np.empty(n), np.empty(n)
    state = at_rest(machine, wanted[0], warm)
    for s in range(steps):
        drive(machine, state, wanted[s], wanted_velocity[s], wanted_acceleration[s], command)
        if s % EVERY == 0:
            k = s // EVERY
            log[1, k] = state.link
            for j in range(n):
                log[0, k, j] = state.motor[j] - misread(machine, j, state.motor[j])
            log[2, k], log[3, k] = command, state.temperature
        motor_torques(machine, state, command, disturbance[s], net)
        advance(machine, state, net, s * STEP - SETTLE)
    return log


def run(machine: Machine, path: np.ndarray, disturbance: np.ndarray, warm: np.ndarray) -> Log:
    """Follow a path of positions, velocities, accelerations (3, s, n) after settling; see `simulate`."""
    rest = int(SETTLE / STEP)
    hold = np.repeat(path[:, :1], rest, axis=1)
    hold[1:] = 0.0
    wanted = np.ascontiguousarray(np.concatenate([hold, path], axis=1))
    log = simulate(machine, wanted[0], wanted[1], wanted[2], disturbance, warm)
    return Log(*log[:, rest // EVERY :])
