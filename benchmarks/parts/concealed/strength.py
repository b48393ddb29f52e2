"""How strong a concealed effect is: its torque over the noise floor, beyond what priors can take up.

What an oracle that knows the effect could find: deviations of all nominal parameters, each within its
tolerance, are fitted to the effect's torque. What is left over is what shows the effect; half its squared
length over the noise is the log-likelihood it gains.
"""

import pickle
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from .effects import Conceal, Concealed
from .plant.body import inverse_dynamics, njit, turn
from .plant.closed_loop import RATE, Log
from .record import PLANS, SECONDS, logged_torque, low_pass, motion_of, rms
from .robot import Robot

EVERY = 10
"""Samples of the log to one of the comparison: 50 Hz carries what is below 25 Hz."""
DENSER = 3.0
"""Density of the noise below 2 Hz, where most effects are, over its mean below 25 Hz."""
FREE = 1e3
"""Noise floors by which an offset of which nothing is known may be off."""


class Seen(NamedTuple):
    """A run without the effect, and the torque (t, n) [N m] that the effect adds to it."""

    log: Log
    torque: np.ndarray


@njit(cache=True)
def torques(body, position, velocity, acceleration):
    """Inverse dynamics of a motion, (t, n) [N m]."""
    torque, pull = np.empty_like(position), np.zeros(3)
    turned = np.empty((position.shape[1], 3, 3))
    for k in range(len(position)):
        turn(body.rotation, position[k], turned)
        inverse_dynamics(body, turned, velocity[k], acceleration[k], -body.gravity, pull, torque[k])
    return torque


def leeway(robot: Robot, log: Log) -> list[np.ndarray]:
    """Torques (t, n) by which nominal parameters may be off, each at its tolerance [N m]."""
    prior, n = robot.prior, robot.arm.joints
    position = low_pass(log.position)
    velocity = np.gradient(position, 1.0 / RATE, axis=0)
    acceleration = np.gradient(velocity, 1.0 / RATE, axis=0)
    columns = _inertial(robot, position, velocity, acceleration)
    tolerance = prior.inertial_tolerance
    for joint in range(n):
        sign = np.tanh(velocity[:, joint] / 0.003)
        own = [
            tolerance * prior.rotor[joint] * acceleration[:, joint],
            0.2 * prior.viscous[joint] * velocity[:, joint],
            0.2 * prior.coulomb[joint] * sign,
            prior.gain_tolerance * log.command[:, joint],
            FREE * robot.recorder.floor[joint] * prior.terms["offset"][joint] * np.ones(len(sign)),
        ]
        for column in own:
            columns.append(np.zeros_like(velocity))
            columns[-1][:, joint] = column
    return columns


def _inertial(
    robot: Robot, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
) -> list[np.ndarray]:
    """Torques of the ten parameters of every link, each off by its tolerance, (t, n) [N m]."""
    body, tolerance, columns = robot.prior.body, robot.prior.inertial_tolerance, []
    nothing = body._replace(mass=0.0 * body.mass, inertia=0.0 * body.inertia)
    size = np.sqrt(np.trace(body.inertia, axis1=1, axis2=2) / body.mass)
    for link in range(robot.arm.joints):
        # A pair of opposite masses is a first moment; a cross of inertia is itself.
        for k in range(3):
            moved = body.com.copy()
            moved[link, k] += 0.5 * tolerance * size[link]
            columns.append(_difference(body, body._replace(com=moved), position, velocity, acceleration))
        mass, inertia = nothing.mass.copy(), nothing.inertia.copy()
        mass[link] = tolerance * body.mass[link]
        columns.append(torques(nothing._replace(mass=mass), position, velocity, acceleration))
        for a in range(3):
            for b in range(a, 3):
                cross = inertia.copy()
                cross[link, a, b] = cross[link, b, a] = tolerance * np.trace(body.inertia[link]) / 3.0
                columns.append(torques(nothing._replace(inertia=cross), position, velocity, acceleration))
    return columns


def _difference(one, other, position, velocity, acceleration):  # type: ignore[no-untyped-def]
    return torques(other, position, velocity, acceleration) - torques(one, position, velocity, acceleration)


def beyond_prior(robot: Robot, seen: list[Seen], noise: np.ndarray) -> tuple[np.ndarray, float]:
    """Rms of what the priors cannot take up over the noise (n,), and the gain in chi-squared by knowing it.

    `seen` are runs without the effect, and its torque in them; `noise` is the filtered floor, (n,) [N m].
    """
    # Runs of one length are stacked; every joint is weighted by its noise.
    torque = np.concatenate([low_pass(run.torque)[::EVERY] for run in seen]) / noise
    columns = [leeway(robot, run.log) for run in seen]
    joined = [
        np.concatenate([low_pass(part)[::EVERY] for part in parts]) for parts in zip(*columns, strict=True)
    ]
    stacked = np.stack([column / noise for column in joined], axis=-1)
    matrix, target = stacked.reshape(-1, stacked.shape[-1]), torque.ravel()
    normal = matrix.T @ matrix + DENSER * np.eye(matrix.shape[1])  # warnings have unit variance
    values = np.linalg.solve(normal, matrix.T @ target)
    left = target - matrix @ values
    return rms(left.reshape(torque.shape)), float(left @ left / DENSER + values @ values)


SHOWN_IN = ("identify_b", "slow")
"""Runs in which the strength is measured; the larger one counts."""


@dataclass(frozen=True)
class Strength:
    """What a strength is worth."""

    value: float  # That of the effect's own scale
    # Rms of the effect's torque over the noise floor, both below 25 Hz, on the joint and in the run where it
    # is largest [-]
    visibility: float
    by_joint: np.ndarray  # The same for every joint, (n,)
    beyond_prior: np.ndarray  # Of that, what the owner's priors cannot take up, (n,)
    evidence: float  # Gain in chi-squared by knowing the effect [-]


class Bench:
    """Simulates robots on the same paths under the same disturbances, each once."""

    def __init__(self, seed: int, loaded: bool = False, seconds: float = SECONDS) -> None:
        self.seed, self.seconds = seed, seconds
        # Runs that are most informative about an effect; the others repeat the same.
        self.informative = (*SHOWN_IN, "payload") if loaded else SHOWN_IN
        self._known: dict[bytes, Seen] = {}

    def seen(self, robot: Robot, run: str) -> Seen:
        """What a run does, and its logged torque without noise, read with the nominal gains."""
        key = pickle.dumps((robot.machine, robot.recorder, robot.touched, run))
        if key not in self._known:
            log, _, _ = motion_of(robot, PLANS[run], self.seed, self.seconds)
            torque = np.clip(logged_torque(robot, log), -robot.recorder.clip, robot.recorder.clip)
            self._known[key] = Seen(log, torque / robot.recorder.gain * robot.arm.gain)
        return self._known[key]

    def effect(self, concealed: Concealed, run: str) -> Seen:
        """A run without the effect, and the torque that the effect adds to it."""
        gone = self.seen(concealed.sound, run)
        there = self.seen(concealed.robot, run)
        return Seen(gone.log, (there.torque - gone.torque) / concealed.part)


def visibility(bench: Bench, concealed: Concealed) -> np.ndarray:
    """Rms of the effect's torque over the noise floor while it is there, in its best run, (n,)."""
    first, last = concealed.span
    span = slice(int(first * RATE), int(min(last, bench.seconds) * RATE))
    worth = [rms(low_pass(bench.effect(concealed, run).torque)[span]) for run in SHOWN_IN]
    return np.max(worth, axis=0) / low_floor(concealed.sound)


def beyond(bench: Bench, concealed: Concealed) -> tuple[np.ndarray, float]:
    """What the owner's priors cannot take up of it; see `beyond_prior`."""
    seen = [bench.effect(concealed, run) for run in bench.informative]
    return beyond_prior(concealed.robot, seen, low_floor(concealed.sound))


def low_floor(robot: Robot) -> np.ndarray:
    """Noise floor below 25 Hz, (n,) [N m]: about 0.67 of the whole, whatever the colour."""
    return 0.67 * robot.recorder.floor


def with_peak(robot: Robot, bench: Bench) -> Robot:
    """The robot with the torques of its ordinary motion measured."""
    return replace(robot, peak=np.max(np.abs(bench.seen(robot, "identify_b").log.command), axis=0))


def conceal(
    robot: Robot, effect: Conceal, joint: int, wanted: float, evident: float, bench: Bench, tries: int
) -> tuple[Concealed, Strength]:
    """An effect at the strength that is visible as wanted, or as near as the effect's bounds allow.

    It should have `evident` evidence at least; a payload within the prior of the last link has none, however
    many noise floors it weighs. At most `tries` simulations.
    """
    value, power, before = max(wanted, 1e-3), 1.0, None
    for attempt in range(tries):
        concealed = _concealed(robot, effect, joint, value, bench)
        seen = max(float(np.max(visibility(bench, concealed))), 1e-9)
        if attempt == tries - 1 or abs(np.log(seen / wanted)) < 0.2:
            break
        if before is not None:
            if abs(np.log(seen / before[1])) < 0.02:  # it is at its bound
                break
            # Visibility grows as a power of strength near enough.
            power = np.clip(np.log(seen / before[1]) / np.log(value / before[0]), 0.4, 2.5)
        before = (value, seen)
        value *= np.clip((wanted / seen) ** (1.0 / power), 0.05, 20.0)
    strength = _strength(bench, concealed, value)
    if strength.evidence >= evident:
        return concealed, strength
    # Evidence is a square; no more than five times, or it is another arm.
    value *= min(np.sqrt(evident / max(strength.evidence, 1e-9)), 5.0)
    concealed = _concealed(robot, effect, joint, value, bench)
    return concealed, _strength(bench, concealed, value)


def _concealed(robot: Robot, effect: Conceal, joint: int, value: float, bench: Bench) -> Concealed:
    return effect(robot, joint, value, np.random.default_rng([bench.seed, 3]))


def _strength(bench: Bench, concealed: Concealed, value: float) -> Strength:
    by_joint = visibility(bench, concealed)
    left, evidence = beyond(bench, concealed)
    return Strength(value, float(np.max(by_joint)), by_joint, left, evidence)
