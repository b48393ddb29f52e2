"""Paths on which the concealed arms are recorded, given at every step of the plant."""

import numpy as np

from ..plant.closed_loop import STEP
from ..robots.arms import Arm

SECONDS = 24.0
REST = 0.65
"""At both ends of a run [s]."""
PERIOD = 12.0
"""Of the slowest harmonic [s]."""
HARMONICS = 5
SLOWNESS = (0.012, 0.03, 0.06, 0.12)
"""Speeds of the slow run, as shares of the limit."""


def clock(seconds: float = SECONDS) -> np.ndarray:
    """Times of the plant's steps, (s,) [s]."""
    return np.arange(round(seconds / STEP)) * STEP


def smooth(share: np.ndarray) -> np.ndarray:
    """From 0 to 1 while its argument does, with two continuous derivatives."""
    x = np.clip(share, 0.0, 1.0)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x**2)


def derivatives(position: np.ndarray) -> np.ndarray:
    """Position, velocity and acceleration of a path (s, n), (3, s, n)."""
    velocity = np.gradient(position, STEP, axis=0)
    return np.stack([position, velocity, np.gradient(velocity, STEP, axis=0)])


def rest(arm: Arm, pose: np.ndarray) -> np.ndarray:
    """A pose in whole encoder steps, so that drives at rest do not hunt for half of one."""
    return arm.encoder * np.round(pose / arm.encoder)


def fourier(arm: Arm, rng: np.random.Generator, seconds: float = SECONDS) -> np.ndarray:
    """Sum of five harmonics that starts and ends at home, (s, n) [rad]."""
    time = clock(seconds)
    window = smooth((time - REST) / 2.0) * smooth((seconds - REST - time) / 2.0)
    phases = 2.0 * np.pi * np.outer(time / PERIOD, np.arange(1, HARMONICS + 1))
    weights = rng.normal(size=(2, HARMONICS, arm.joints)) / np.arange(1, HARMONICS + 1)[:, None] ** 0.7
    wave = (np.sin(phases) @ weights[0] + np.cos(phases) @ weights[1]) * window[:, None]
    return rest(arm, arm.home) + wave * within(arm, wave, rng)


def within(arm: Arm, wave: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Largest factors (n,) that keep a wave about home inside the limits, or a little less."""
    _, velocity, acceleration = np.max(np.abs(derivatives(wave)), axis=1)
    up = 0.9 * (arm.limits.upper - arm.home) / np.maximum(np.max(wave, axis=0), 1e-9)
    down = 0.9 * (arm.home - arm.limits.lower) / np.maximum(-np.min(wave, axis=0), 1e-9)
    fast = rng.uniform(0.65, 0.85, arm.joints) * arm.limits.velocity / velocity
    hard = 0.75 * arm.limits.acceleration / acceleration
    # No arm is swung right round: two radians either way.
    far = 2.0 / np.max(np.abs(wave), axis=0)
    return np.min([up, down, fast, hard, far], axis=0)


def swept(
    arm: Arm, rng: np.random.Generator, start: float, end: float, seconds: float = SECONDS
) -> np.ndarray:
    """Sine from 2 to 14 Hz or back, of constant acceleration, (s, n) [rad]."""
    time = clock(seconds)
    share = np.clip((time - start) / (end - start), 0.0, 1.0)
    wave = np.zeros((len(time), arm.joints))
    for j in range(arm.joints):
        low, high = (2.0, 14.0) if rng.random() < 0.5 else (14.0, 2.0)
        frequency = low + (high - low) * share
        phase = 2.0 * np.pi * (end - start) * (low * share + 0.5 * (high - low) * share**2)
        reach = 0.08 * arm.limits.acceleration[j] / (2.0 * np.pi * frequency) ** 2
        wave[:, j] = reach * np.sin(phase + rng.uniform(0.0, 2.0 * np.pi))
    return wave * (smooth((time - start) / 0.4) * smooth((end - time) / 0.4))[:, None]


def slow(arm: Arm, rng: np.random.Generator, seconds: float = SECONDS) -> np.ndarray:
    """Constant low speeds, back and forth, every joint at its own beat, (s, n) [rad]."""
    time = clock(seconds)
    velocity = np.zeros((len(time), arm.joints))
    for j in range(arm.joints):
        sign, start, speed = rng.choice([-1.0, 1.0]), REST + 0.1, 0
        while start < seconds - REST - 3.0:
            share = SLOWNESS[speed % len(SLOWNESS)]
            pause = rng.uniform(2.4, 3.4) - 8.0 * share
            for way in (1.0, -1.0):
                ramp = smooth((time - start) / 0.3) * smooth((start + pause - time) / 0.3)
                velocity[:, j] += way * sign * share * arm.limits.velocity[j] * ramp
                start += pause
            speed += 1
    position = np.cumsum(velocity, axis=0) * STEP
    window = smooth((seconds - REST - time) / 1.0)[:, None]
    towards = np.sign(0.5 * (arm.limits.upper + arm.limits.lower) - arm.home)
    return rest(arm, arm.home + 0.06 * towards) + position * window
