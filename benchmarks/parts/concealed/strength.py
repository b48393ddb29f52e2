"""How strong a concealed effect is: its torque over the noise floor, and the strength that makes it so."""

import pickle
from dataclasses import dataclass, replace

import numpy as np

from .effects.effect import Conceal, Concealed
from .oracle import Seen, beyond_prior
from .plant.closed_loop import RATE
from .recordings.motion import SECONDS
from .recordings.record import PLANS, logged_torque, low_pass, motion_of, rms
from .robots.robot import Robot

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

    Args:
        robot: To conceal it in.
        effect: What.
        joint: Where.
        wanted: Visibility.
        evident: Evidence that it should have at least; a payload within the prior of the last link has
            none, however many noise floors it weighs.
        bench: On which it is tried.
        tries: Simulations at most.
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
