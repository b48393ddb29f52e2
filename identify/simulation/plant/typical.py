"""A plant whose drives and sensors are typical of an arm of the model's size."""

import numpy as np

from ...arm.robot import Robot
from ...model import Model
from .drives import DriveControl
from .forces import ArmForces, Joints
from .gears import Thermal, Transmission
from .plant import Plant
from .sensors import Sensors

BANDWIDTH = 25.0
"""Of the velocity loop [Hz]. With gears as elastic as robots', drives reach 20 to 40."""

COUNTS = 2.0**16
"""Of the encoder in a turn of the motor; it interpolates what its disc has."""

CURRENT_BITS = 13
"""Of the current sensor, sign apart, from zero to its largest."""

NOISE = 0.002
"""Standard deviation of each of the two current noises over the current limit [-]."""

POSES = 64
"""Over which inertia and torque are averaged."""

AMBIENT = 25.0
"""Temperature around the arm [degC]."""

HEAT = 20.0
"""Rise above ambient in long work with a third of the largest current at a third of the speed limit [K]."""

FREE_SPEED = 3.0
"""Taken for a speed limit where there is none [rad/s]."""


def typical_plant(
    model: Model,
    start: np.ndarray,
    values: np.ndarray | None = None,
    gain: np.ndarray | None = None,
    seed: int = 0,
    payload: str = "",
    transmission: Transmission | None = None,
) -> Plant:
    """An arm with a cascade, encoders and current sensors as industrial arms have them.

    The velocity loops are tuned to the inertia by the model's nominal values. Parameters (p,) and drive gains
    (n,) [N m/A] are nominal by default, and gears those of the model; it stands at `start` (n,) [rad] and
    carries the named payload, one of the model's effects. For other parts, make a `Plant` with some of
    `typical_parts`.
    """
    values = model.nominal_values if values is None else values
    gain = model.robot.drive_gain if gain is None else gain
    control, sensors, thermal = typical_parts(model)
    return Plant(model, values, gain, start, control, sensors, transmission, thermal, payload, seed=seed)


def typical_parts(model: Model) -> tuple[DriveControl, Sensors, Thermal]:
    """Drives, sensors and warmth of an arm of the nominal size of the model.

    Drives are position servos where the robot states their law, with current up to the servo's limit.
    """
    robot, n = model.robot, model.robot.dof
    inertia, torque = typical_size(model)
    limit = np.where(np.isfinite(robot.limits.torque), robot.limits.torque, 4.0 * torque)
    most = limit / np.abs(robot.drive_gain)
    if robot.servo is not None:
        most = np.where(np.isfinite(robot.servo.limit), robot.servo.limit, most)
    noise = NOISE * most
    sensors = Sensors(
        encoder_step=2 * np.pi / (COUNTS * np.abs(robot.gear_ratio)),
        encoder_noise=np.full(n, 1e-6),
        current_step=most / 2.0**CURRENT_BITS,
        current_noise=noise,
        current_drift=noise,
    )
    thermal = typical_warmth(model, most / 3)
    return _control(robot, inertia, most), sensors, thermal


def _control(robot: Robot, inertia: np.ndarray, most: np.ndarray) -> DriveControl:
    """Drives that move an inertia (n,) [kg m^2] by at most some current (n,) [A]."""
    if robot.servo is None:
        return DriveControl.tuned(inertia, BANDWIDTH, most)
    return DriveControl.position_servo(np.abs(robot.drive_gain) * robot.servo.gain, most)


def typical_size(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Inertia [kg m^2] and torque [N m] of each motor, seen from its joint, in random poses, each (n,).

    The inertia is the mean of what the motor feels when it turns alone; the torque the largest at rest, or
    what speeds that inertia up by 5 rad/s^2 if that is more.
    """
    robot, forces = model.robot, _forces(model)
    still, warm = np.zeros(robot.dof), np.full(robot.dof, AMBIENT)
    inertias, torques = [], []
    for position in _poses(model):
        local, inertia = forces.at(Joints(position, still, still), position, warm)
        inertias.append(np.diagonal(robot.to_motors @ inertia @ robot.to_motors.T))
        torques.append(np.abs(robot.to_motors @ local.force))
    mean = np.mean(inertias, axis=0)
    return mean, np.maximum(np.max(torques, axis=0), 5.0 * mean)


def typical_warmth(model: Model, current: np.ndarray) -> Thermal:
    """Warmth where windings, by currents (n,) [A], lose as much as gears at a third of the speed limit."""
    robot, forces = model.robot, _forces(model)
    limit = robot.limits.velocity
    speed = np.where(np.isfinite(limit), limit, FREE_SPEED) / 3
    still, warm = np.zeros(robot.dof), np.full(robot.dof, AMBIENT)
    lost = []
    for position in _poses(model):
        for velocity in (speed, -speed):  # both ways: an offset of the torque is not lost
            forces.at(Joints(position, velocity, still), position, warm)
            lost.append(forces.friction * velocity)
    gear = np.mean(lost, axis=0)
    # A joint without friction warms up by its winding alone, taken as 1 ohm.
    resistance = np.where(gear > 0, gear / current**2, 1.0)
    return Thermal(AMBIENT, HEAT / (resistance * current**2 + np.maximum(gear, 0.0)), resistance)


def _forces(model: Model) -> ArmForces:
    return ArmForces(model, model.nominal_values, "", Transmission.rigid(model.robot.dof))


def _poses(model: Model) -> np.ndarray:
    """Anywhere in the range, shape (POSES, n) [rad]."""
    limits = model.robot.limits
    lower, upper = np.maximum(limits.position_lower, -np.pi), np.minimum(limits.position_upper, np.pi)
    return np.random.default_rng(0).uniform(lower, upper, (POSES, model.robot.dof))
