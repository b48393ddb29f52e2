"""A plant with drives and sensors that are typical of an arm of the model's size."""

import numpy as np

from ...model import Model
from .drives import DriveControl
from .forces import ArmForces, Joints
from .gears import AMBIENT, Thermal, Transmission, random_poses
from .plant import Plant
from .sensors import Sensors

BANDWIDTH = 25.0
"""Bandwidth of the velocity loop [Hz]. With the elastic gears of robots, drives reach 20 to 40."""
COUNTS = 2.0**16
"""Encoder counts per motor turn, including interpolation."""
CURRENT_BITS = 13
"""Resolution of the current sensor from zero to its maximum, without the sign [bit]."""
NOISE = 0.002
"""Standard deviation of each of the two current noises relative to the current limit [-]."""
HEAT = 20.0
"""Temperature rise in continuous work at a third of the maximum current and of the speed limit [K]."""
FREE_SPEED = 3.0
"""Speed limit that is assumed if the robot has none [rad/s]."""


def typical_plant(
    model: Model,
    start: np.ndarray,
    values: np.ndarray | None = None,
    gain: np.ndarray | None = None,
    seed: int = 0,
    payload: str = "",
) -> Plant:
    """An arm with control loops, encoders and current sensors typical of industrial arms.

    The velocity loops are tuned to the inertia of the model's nominal values. Parameters (p,) and drive gains
    (n,) [N m/A] are nominal by default, and gears are those of the model. The arm stands at `start` (n,)
    [rad] and carries the named payload, one of the model's effects. To replace some parts, combine `Plant`
    and `typical_parts`.
    """
    values = model.nominal_values if values is None else values
    gain = model.robot.drive_gain if gain is None else gain
    control, sensors, thermal = typical_parts(model)
    return Plant(model, values, gain, start, control, sensors, thermal=thermal, payload=payload, seed=seed)


def typical_parts(model: Model) -> tuple[DriveControl, Sensors, Thermal]:
    """Drives, sensors and thermal model of an arm of the nominal size of the model.

    Drives are position servos if the robot states a servo law, with current up to the servo's limit.
    """
    robot, n = model.robot, model.robot.dof
    inertia, torque = typical_size(model)
    limit = np.where(np.isfinite(robot.limits.torque), robot.limits.torque, 4.0 * torque)
    current_limit = limit / np.abs(robot.drive_gain)
    if robot.servo is not None:
        current_limit = np.where(np.isfinite(robot.servo.limit), robot.servo.limit, current_limit)
    noise = NOISE * current_limit
    sensors = Sensors(
        encoder_step=2 * np.pi / (COUNTS * np.abs(robot.gear_ratio)),
        encoder_noise=np.full(n, 1e-6),
        current_step=current_limit / 2.0**CURRENT_BITS,
        current_noise=noise,
        current_drift=noise,
    )
    thermal = typical_thermal(model, current_limit / 3)
    if robot.servo is None:
        control = DriveControl.tuned(inertia, BANDWIDTH, current_limit)
    else:
        control = DriveControl.position_servo(np.abs(robot.drive_gain) * robot.servo.gain, current_limit)
    return control, sensors, thermal


def typical_size(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Inertia [kg m^2] and torque [N m] of each motor, on the joint side, over random poses, each (n,).

    The inertia is the mean for a motor that turns alone. The torque is the maximum at rest, or the torque
    that accelerates this inertia by 5 rad/s^2 if that is more.
    """
    robot, forces = model.robot, _forces(model)
    still, warm = np.zeros(robot.dof), np.full(robot.dof, AMBIENT)
    inertias, torques = [], []
    for position in random_poses(model):
        local, inertia = forces.at(Joints(position, still, still), position, warm)
        inertias.append(np.diagonal(robot.to_motors @ inertia @ robot.to_motors.T))
        torques.append(np.abs(robot.to_motors @ local.force))
    mean = np.mean(inertias, axis=0)
    return mean, np.maximum(np.max(torques, axis=0), 5.0 * mean)


def typical_thermal(model: Model, current: np.ndarray) -> Thermal:
    """Thermal model: windings at a current (n,) [A] lose as much as gears at a third of the speed limit."""
    robot, forces = model.robot, _forces(model)
    limit = robot.limits.velocity
    speed = np.where(np.isfinite(limit), limit, FREE_SPEED) / 3
    still, ambient = np.zeros(robot.dof), np.full(robot.dof, AMBIENT)
    losses = []
    for position in random_poses(model):
        for velocity in (speed, -speed):  # both directions, so that a torque offset cancels
            forces.at(Joints(position, velocity, still), position, ambient)
            losses.append(forces.friction * velocity)
    gear_loss = np.mean(losses, axis=0)
    # A joint without friction is warmed only by its winding, assumed to have 1 ohm.
    resistance = np.where(gear_loss > 0, gear_loss / current**2, 1.0)
    return Thermal(AMBIENT, HEAT / (resistance * current**2 + np.maximum(gear_loss, 0.0)), resistance)


def _forces(model: Model) -> ArmForces:
    return ArmForces(model, model.nominal_values, "", Transmission.rigid(model.robot.dof))
