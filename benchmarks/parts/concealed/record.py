"""Runs of a concealed robot: paths, noise, warm-up, and what the recorder makes of it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import signal

from .plant.body import weld
from .plant.closed_loop import EVERY, RATE, SETTLE, STEP, Log, run
from .robot import NEVER, Arm, Robot, Tool

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


WHITE, COLOURED, DISTURBING = 0.66, 0.66, 0.36
"""Shares of the noise floor: white and coloured noise of currents, torques on the arm; squares sum to 1."""
DISTURBANCE_TIME = 0.06
"""Time constant of the torques that move the arm [s]."""
LUMP_TIME = 1.5
"""Time within which a lump of grease passes [s]."""
FILTER_HZ = 25.0
"""Low-pass behind which noise and residuals are compared [Hz]."""
WARM_STEP = 0.1
"""Step of a recorded temperature [deg C]."""


class Plan(NamedTuple):
    """A run: its name, role, motion in words, bandwidth [Hz], sweep [s], kelvins above the first run."""

    name: str
    role: str
    motion: str
    bandwidth: float
    sweep: tuple[float, float] | None
    warmer: float


FOURIER = "Fourier, 5 harmonics"
BOTH = "Fourier, 5 harmonics, swept sine 2-14 Hz on top"
PLANS = {
    plan.name: plan
    for plan in (
        Plan("identify_a", "identify", FOURIER, 0.6, None, 0.0),
        Plan("identify_b", "identify", BOTH, 14.0, (0.45, 0.88), 18.0),
        Plan("validate", "validate", BOTH, 14.0, (0.3, 0.68), 11.0),
        Plan("payload", "payload", FOURIER, 0.6, None, 14.0),
        Plan("slow", "slow", "constant low speed sweeps of every joint", 1.0, None, 7.0),
    )
}


@dataclass(frozen=True)
class Run:
    """A run as recorded; time (t,) [s], position [rad], current [current unit], temperature [deg C], (t, n).

    `noise` is what no model explains, as a torque (t, n) [N m]; the code under test does not see it.
    """

    plan: Plan
    time: np.ndarray
    position: np.ndarray
    current: np.ndarray
    temperature: np.ndarray
    noise: np.ndarray
    tool: Tool | None


def path_of(robot: Robot, plan: Plan, seed: int, seconds: float = SECONDS) -> np.ndarray:
    """Positions, velocities and accelerations of a run at every step, (3, s, n)."""
    rng = np.random.default_rng([seed, *plan.name.encode()])
    if plan.role == "slow":
        return derivatives(slow(robot.arm, rng, seconds))
    path = fourier(robot.arm, rng, seconds)
    if plan.sweep is not None:
        path = path + swept(robot.arm, rng, plan.sweep[0] * seconds, plan.sweep[1] * seconds, seconds)
    return derivatives(path)


def motion_of(
    robot: Robot, plan: Plan, seed: int, seconds: float = SECONDS
) -> tuple[Log, np.ndarray, Tool | None]:
    """What the arm does in a run, the torque (t, n) that disturbs it by chance, the tool on its flange."""
    rng = np.random.default_rng([seed, 1, *plan.name.encode()])
    path = path_of(robot, plan, seed, seconds)
    steps, n = path.shape[1] + round(SETTLE / STEP), robot.arm.joints
    chance = coloured(np.exp(-STEP / DISTURBANCE_TIME), steps, n, rng) * DISTURBING * robot.recorder.floor
    push = chance + surges(robot, steps) - lumps(robot, path[1], steps, rng) - drags(robot, path[1], steps)
    machine, tool = robot.machine, None
    if plan.role == "payload":
        tool = robot.arm.tool
        machine = machine._replace(body=weld(machine.body, n - 1, tool.mass, tool.com, tool.inertia))
    if plan.name != robot.touched:
        machine = machine._replace(touch=np.array([NEVER, 1.0, 0.0, 0.0, 0.0]))
    warm = 24.0 + rng.uniform(0.0, 2.5, n) + plan.warmer
    log = run(machine, path, push, warm)
    return log, chance[round(SETTLE / STEP) :: EVERY], tool


def surges(robot: Robot, steps: int) -> np.ndarray:
    """Torque that pulses with the supply, (s, n) [N m]."""
    *amplitude, frequency = robot.recorder.surge
    return np.outer(np.sin(2.0 * np.pi * frequency * STEP * np.arange(steps)), amplitude)


def lumps(robot: Robot, velocity: np.ndarray, steps: int, rng: np.random.Generator) -> np.ndarray:
    """Friction that comes and depends onin LUMP_TIME, (s, n) [N m]; velocity (s', n) is that of the path."""
    level = coloured(np.exp(-STEP / LUMP_TIME), steps, robot.arm.joints, rng) * robot.recorder.lump
    level[: steps - len(velocity)] = 0.0
    level[steps - len(velocity) :] *= np.tanh(velocity / 0.01)
    return level


def drags(robot: Robot, velocity: np.ndarray, steps: int) -> np.ndarray:
    """Friction of brakes that open slowly, (s, n) [N m]; velocity (s', n) is that of the path."""
    level, opening = robot.recorder.drag.T
    since = STEP * np.arange(len(velocity)) - REST
    closed = np.clip(1.0 - since[:, None] / opening, 0.0, 1.0)
    torque = np.zeros((steps, robot.arm.joints))
    torque[steps - len(velocity) :] = level * closed * np.tanh(velocity / 0.01)
    return torque


def coloured(pole: float, count: int, n: int, rng: np.random.Generator) -> np.ndarray:
    """First-order noise of unit variance, (count, n)."""
    white = rng.normal(size=(count, n)) * np.sqrt(1.0 - pole**2)
    white[0] /= np.sqrt(1.0 - pole**2)
    return signal.lfilter([1.0], [1.0, -pole], white, axis=0)


def logged_torque(robot: Robot, log: Log) -> np.ndarray:
    """Torque that the logged currents stand for, without noise, (t, n) [N m]."""
    recorder, time = robot.recorder, np.arange(len(log.command)) / RATE
    speed = np.gradient(log.position, 1.0 / RATE, axis=0)
    power = np.sum(np.abs(log.command * speed), axis=1, keepdims=True)
    full = 0.25 * np.sum(robot.peak * robot.arm.limits.velocity) if robot.peak.size else 1.0
    torque = log.command / (1.0 - recorder.sag * np.minimum(power / full, 1.0))
    torque = np.stack([np.interp(time - recorder.delay, time, column) for column in torque.T], axis=1)
    torque = torque + (torque / recorder.gain) @ recorder.mix.T * recorder.gain
    return torque


def record(robot: Robot, plan: Plan, seed: int, seconds: float = SECONDS) -> Run:
    """A run as its file will have it."""
    rng = np.random.default_rng([seed, 2, *plan.name.encode()])
    log, chance, tool = motion_of(robot, plan, seed, seconds)
    recorder, count = robot.recorder, len(log.command)
    noise = WHITE * rng.normal(size=(count, robot.arm.joints))
    noise += COLOURED * coloured(recorder.colour, count, robot.arm.joints, rng)
    noise *= recorder.floor
    torque = logged_torque(robot, log) + noise
    # The log's range ends here for noise too.
    current = np.clip(torque, -recorder.clip, recorder.clip) / recorder.gain
    step = robot.arm.current
    warmth = log.temperature + 0.06 * rng.normal(size=log.temperature.shape)
    return Run(
        plan,
        np.arange(count) / RATE,
        robot.arm.encoder * np.round(log.position / robot.arm.encoder),
        step * np.round(current / step),
        WARM_STEP * np.round(warmth / WARM_STEP),
        noise - chance,
        tool,
    )


def low_pass(values: np.ndarray) -> np.ndarray:
    """Without what is faster than FILTER_HZ, nor late; (t, n)."""
    return signal.sosfiltfilt(signal.butter(4, FILTER_HZ, fs=RATE, output="sos"), values, axis=0)


def rms(values: np.ndarray) -> np.ndarray:
    """Of every column, (n,)."""
    return np.sqrt(np.mean(values**2, axis=0))
