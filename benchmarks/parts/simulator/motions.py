"""What real arms are commanded, and the logs that they leave: behind an encoder, with noise of a sensor."""

from typing import TYPE_CHECKING

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.recordings.servo_error import LAW, servo_of, servo_words, with_servo_error
from exidyn.trajectories.random_motion import random_fourier

from .physics import temperature
from .real_arm import Motion

if TYPE_CHECKING:
    from .arms import Arm

FAST = 250.0
"""Sampling rate of industrial controllers [Hz]."""
TORQUE_NOISE = 0.01
"""Standard deviation of the logged torque over its rms [-]."""
SEEDS = {"identify": 0, HELD_OUT: 1, "third": 2}
"""Motion by its role: exidyn fits the first and decides by the second; the third judges."""
KELVIN = 0.1
"""Resolution of logged temperatures [K]."""


def commands(limits: Limits, seconds: float, period: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Times (t,) [s] and random commands (t, n) [rad] within limits."""
    time = np.arange(0.0, seconds, period)
    return time, random_fourier(limits, seconds, seed=seed).at(time).position


def moved(arm: "Arm", seconds: float, seed: int) -> Motion:
    """A random motion of a real arm."""
    return arm.real().follow(*commands(arm.nominal.robot.limits, seconds, 1.0 / arm.rate, seed))


def logged(arm: "Arm", motion: Motion, seed: int, name: str) -> Recording:
    """The log of a motion, as the arm's controller writes it."""
    random = np.random.default_rng(seed)
    torque = motion.torque + TORQUE_NOISE * np.sqrt(np.mean(motion.torque**2, axis=0)) * random.normal(
        size=motion.torque.shape
    )
    values = {
        "position": np.round(motion.position / arm.encoder) * arm.encoder,
        "command": motion.command,
        "torque": torque,
    }
    if arm.temperature:
        values["temperature"] = _temperatures(arm, motion.time)
    signals = {key: Signal(motion.time, value) for key, value in values.items()}
    run = Recording(name, arm.nominal, signals)
    return run if arm.log == "torque" else commands_alone(run)


def commands_alone(run: Recording) -> Recording:
    """The log without torque, as `exidyn import --effort command` reads it."""
    servo = servo_of(run.robot, None, None)
    signals = {name: signal for name, signal in run.signals.items() if name != "torque"}
    signals = with_servo_error(signals, servo, run.name)
    return Recording(run.name, run.model, signals, settings=dict(run.settings) | {LAW: servo_words(servo)})


def _temperatures(arm: "Arm", time: np.ndarray) -> np.ndarray:
    """Temperatures of all motors (t, n) [degC]; they warm alike."""
    [values] = [item.values for item in arm.items if item.kind == "thermal"]
    rounded = np.round(temperature(values, time) / KELVIN) * KELVIN
    return np.repeat(rounded[:, None], arm.nominal.robot.dof, axis=1)
