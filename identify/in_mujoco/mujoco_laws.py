"""Laws of MuJoCo that a fit shares with the simulation: torque of servos, and reversal of dry friction.

Logs may hold only commands and positions; their torque is computed from the servos of the simulation's file.
A position servo of MuJoCo exerts kp (command - position) - kv velocity, within its force range. With an
implicit integrator the velocity is the one at the end of a step, with Euler the one at its beginning: half a
step after or before the velocity that positions show. So kv adds kv step / 2 to a joint's inertia in the
simulation, or subtracts it. In a UR10e file with kv 500 and steps of 2 ms that is 0.5 kg m^2, five times the
armature. The same shift is applied here, so the fitted inertia makes the simulation move like the arm.

Dry friction reverses as MuJoCo's solver does it, which light joints show in any simulation. `frictionloss` f
is a soft constraint on acceleration: with the reference b v and the regularization R of the joint, its force
is (b v + a) / R until it reaches f (MuJoCo's documentation, "Solver parameters"). So friction changes its
sign over the velocity f R / b, which grows with the inverse of the joint's inertia.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..diagnosis.runs.rows import REVERSALS
from ..effects import CoulombFriction, Effect
from ..errors import RecordingError
from ..model import Model
from ..recordings.recording import EFFORT, Recording, Signal, interpolated
from ..recordings.servo_error import FEW, SELDOM, is_servo_error
from ..robot_files.mjcf_drives import servos
from ..robot_files.mjcf_elements import enum_of


def with_servo_torque(
    model: Any,
    recording: Recording,
    joints: Sequence[str],
    ahead: float | None = None,
    delay: np.ndarray | None = None,
) -> Recording:
    """The recording, with servo errors replaced by the torque of the servos of a compiled MJCF.

    A recording with measured effort is returned unchanged. `ahead` is the lead of the velocity that the
    servos' damping uses over the velocity that positions show [s], by default that of the file's integrator.
    `delay` (n,) is the time from a command to its effect on each joint [s], zero by default.
    """
    if not is_servo_error(recording.settings):
        return recording
    delay = np.zeros(len(joints)) if delay is None else delay
    actuators = servos(model, joints)
    if not actuators:
        raise RecordingError(
            f"{recording.name} has servo errors but no measured effort, and the file has no position servo "
            "for every joint, so the torque is unknown. State the gains of the controller: --kp KP --kd KD"
        )
    others = {name: signal for name, signal in recording.signals.items() if name not in EFFORT}
    position, command = recording.signals["position"], recording.signals["command"]
    acting = interpolated(position.time[:, None] - delay, command.time, command.values)
    error = acting - position.values
    # Differences of encoder increments are noisy; the torque filter smooths them.
    velocity = np.gradient(position.values, position.time, axis=0)
    ahead = lead(model) if ahead is None else ahead
    velocity = velocity + ahead * np.gradient(velocity, position.time, axis=0)
    torque = servo_torque(model, actuators, error, velocity)
    with_torque = replace(recording, signals=others | {"torque": Signal(position.time, torque)})
    return with_torque.with_warnings(*_clipped(model, actuators, joints, torque))


def _clipped(
    model: Any, actuators: Sequence[int], joints: Sequence[str], torque: np.ndarray
) -> Iterator[str]:
    """Warnings about joints whose torque, shape (t, n), reaches the limit of the file's servo."""
    for joint, actuator, column in zip(joints, actuators, torque.T, strict=True):
        if not model.actuator_forcelimited[actuator]:
            continue
        gear, ends = model.actuator_gear[actuator, 0], model.actuator_forcerange[actuator]
        clipped = int(np.sum(np.isin(column, gear * ends)))
        if clipped > max(FEW, SELDOM * len(column)):
            kp, limit = -model.actuator_biasprm[actuator, 1], float(np.abs(ends).max())
            yield (
                f"torque: the servo of {joint} is at its limit (forcerange {limit:g}) in {clipped} of "
                f"{len(column)} samples: with kp = {kp:g} in the file, it is reached "
                f"{limit / kp / gear:.2g} rad from the command. If kp is wrong, exidyn init LOG --robot FILE "
                "estimates it"
            )


def lead(model: Any) -> float:
    """Lead of the velocity that a servo's damping uses over the velocity that positions show [s].

    RK4 uses the velocity of the same instant, but holds the command over a step, which adds the same inertia.
    """
    euler = model.opt.integrator == enum_of("mjtIntegrator", "mjINT_EULER")
    return (-0.5 if euler else 0.5) * float(model.opt.timestep)


def servo_torque(model: Any, actuators: Sequence[int], error: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Joint torque at servo errors (t, n) [rad] and velocities (t, n) [rad/s], shape (t, n) [N m]."""
    gear, bias = model.actuator_gear[actuators, 0], model.actuator_biasprm[actuators]
    force = gear * (bias[:, 2] * velocity - bias[:, 1] * error)
    limited, ranges = model.actuator_forcelimited[actuators] > 0, model.actuator_forcerange[actuators]
    ranges = np.where(limited[:, None], ranges, [-np.inf, np.inf])
    return np.asarray(gear * np.clip(force, ranges[:, 0], ranges[:, 1]))


TANH = 0.6
"""Velocity of a tanh over that of a ramp between -1 and 1 with the least mean squared difference [-]."""
IMPEDANCE = 1e-4
"""MuJoCo's smallest distance of an impedance from 0 and 1 [-]."""
LEAST = 2.0
"""Steps within which MuJoCo lets no constraint act faster."""


def reversal_velocities(compiled: Any, joints: Sequence[str]) -> np.ndarray:
    """Velocity over which the file's dry friction changes its sign in MuJoCo, shape (n,) [rad/s]."""
    dofs = [int(compiled.joint(name).dofadr[0]) for name in joints]
    impedance, most = np.clip(compiled.dof_solimp[dofs, :2].T, IMPEDANCE, 1.0 - IMPEDANCE)
    regularization = (1.0 - impedance) / impedance * compiled.dof_invweight0[dofs]
    times, damping = compiled.dof_solref[dofs].T
    slowest = np.maximum(times, LEAST * compiled.opt.timestep)
    damped = np.where(times > 0.0, 2.0 / slowest, -damping) / most
    return np.asarray(compiled.dof_frictionloss[dofs] * regularization / damped)


def with_solver_friction(model: Model, compiled: Any) -> Model:
    """The model with dry friction that reverses as in MuJoCo, on joints where this is slower than usual.

    It is no slower than the reversals that a diagnosis allows for, so that a real arm may have a faster one.
    """
    velocities = TANH * reversal_velocities(compiled, model.robot.joints)
    effects: list[Effect] = []
    for effect in model.effects:
        if isinstance(effect, CoulombFriction) and not effect.gradual:
            effects += _by_joint(effect, model, velocities)
        else:
            effects.append(effect)
    return replace(model, effects=tuple(effects))


def _by_joint(effect: CoulombFriction, model: Model, velocities: np.ndarray) -> list[Effect]:
    """The effect on all joints with its own reversal, and on each joint that turns more slowly."""
    names, places = model.robot.joints, effect.columns(model.robot)
    slow = [place for place in places if velocities[place] > effect.reversal]
    usual = tuple(names[place] for place in places if place not in slow)
    by_joint: list[Effect] = [replace(effect, joints=usual)] if usual else []
    for place in slow:
        reversal = float(min(velocities[place], REVERSALS[-1]))
        by_joint.append(replace(effect, joints=(names[place],), reversal=reversal))
    return by_joint
