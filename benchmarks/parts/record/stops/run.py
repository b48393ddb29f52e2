"""One run that is stopped right after a position is read wrongly; the peer reports where the arm went."""

import time
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from exidyn.acquire.run.frames import SAMPLE, STAGES, Cycle, Unframed, read_cycle
from exidyn.acquire.run.pipe import PipeSink, Sink
from exidyn.acquire.run.stopping.escalation import stopping_distance
from exidyn.acquire.run.stopping.stop import Stop
from exidyn.acquire.run.stopping.watch import WatchLimits
from exidyn.drivers import Driver, StopLevel
from exidyn.drivers.driver import Measured, Plant

from ..controllers import ARMS, controller
from ..motion import COBOT, BenchArm, job
from ..run import run

SECONDS = 4.0
"""Duration of the motion [s]."""
ALONG = 0.4
"""Share of the motion after which the sensor fails [-]: the arm moves then."""
LATER = 10
"""Cycles from the failure to the stop: the wrong position has been received by then."""
JOINT = 1
MOCK_FAULTS = {
    "saturated": "jump joint2 1000",
    "exchanged": "exchange joint2",
    "turned": "jump joint2 {turn}",
    "stale": "stale joint2",
    "nan": "nan joint2",
}
"""The mock has no peer: what its own faults are called."""
TURNS = {"canopen_402": 2.0 * np.pi / 101.0}
"""Turn of an encoder [rad at the joint], where it sits before the gear."""


class Disturbed(Exception):
    """A busy machine has stopped the run for another reason than the case's."""


class Seen(NamedTuple):
    """What a run has shown.

    Attributes:
        beyond: Motion since the sensor failed, beyond commands and stopping distance [rad].
        block: By how much longer than a cycle the loop took to come round, at most [s].
        stop: Text of the reason.
        told: What a person is told of the arm at the end; empty for nothing.
    """

    beyond: float
    block: float
    stop: str
    told: str


class Failure:
    """Lets a sensor fail in the middle of the motion, and asks for a quick stop right after."""

    failure = ""

    def __init__(self, kind: str, turn: float, peer: Any, motion: float) -> None:
        self.kind, self.turn, self._peer, self._motion = kind, turn, peer, motion
        self._unframed = Unframed()
        self._running, self.failed = 0.0, 0
        self.commands: list[np.ndarray] = []
        self.velocity = np.zeros(0)

    def put(self, frame: bytes) -> None:
        for kind, body in self._unframed.add(frame):
            if kind == SAMPLE:
                self._see(read_cycle(body))

    def _see(self, cycle: Cycle) -> None:
        command, velocity = cycle.array("command_position"), cycle.array("command_velocity")
        if STAGES[cycle.stage] == "running" and not self._running:
            self._running = time.monotonic()
        if np.isfinite(command).all():
            self.commands = [*self.commands, command] if self.failed else [command]
            self.velocity = (
                np.abs(velocity) if not self.failed else np.maximum(self.velocity, np.abs(velocity))
            )

    def asked(self) -> Stop | None:
        """Called in every cycle."""
        if self._running and not self.failed and time.monotonic() > self._running + ALONG * self._motion:
            self.failed = 1
            if self._peer is not None:
                self._peer.tell(f"sensor {self.kind} {JOINT} {self.turn}")
        self.failed += bool(self.failed)
        return Stop(StopLevel.QUICK, "asked", "asked to stop") if self.failed > LATER else None

    def close(self) -> None:
        """Nothing waits here."""


def seen(name: str, kind: str, folder: Path) -> Seen:
    """Let it happen on a driver. Raises NoBus without a bus on this machine, Disturbed on a busy one."""
    arm = ARMS.get(name, COBOT)
    work, turn = job(SECONDS, arm), TURNS.get(name, 2.0 * np.pi)
    begins = ALONG * work.motion.duration
    settings = {"faults": f"{MOCK_FAULTS[kind].format(turn=turn)} at {begins:.3f}"} if name == "mock" else {}
    with controller(name, folder, **settings) as (driver, peer):
        failure = Failure(kind, turn, peer, work.motion.duration)
        watched = _watched(driver, failure) if peer is None else None

        def sinks(recorder: PipeSink) -> list[Sink]:
            return [failure]

        ran = run(driver, work, folder / f"{name}-{kind}.mcap", failure.asked, sinks)
        if not failure.failed:
            raise Disturbed(f"the run ended before the failure: {ran.outcome.stop}")
        beyond = _beyond(watched.extent() if watched else _extent(peer), failure, arm)
    outcome = ran.outcome
    return Seen(beyond, outcome.counts.block, outcome.stop.text if outcome.stop else "", outcome.notice)


class Watched:
    """A simulated arm that remembers where it was since a failure; the mock has it, and no peer."""

    def __init__(self, plant: Plant, failure: Failure) -> None:
        self._plant, self._failure = plant, failure
        self.positions: list[np.ndarray] = []

    def measure(self) -> Measured:
        return self._plant.measure()

    def step(self, position: np.ndarray, velocity: np.ndarray, seconds: float) -> None:
        self._plant.step(position, velocity, seconds)
        if self._failure.failed:
            self.positions.append(np.array(self._plant.measure().position))

    def extent(self) -> tuple[np.ndarray, np.ndarray]:
        """As `_extent`."""
        return np.min(self.positions, axis=0), np.max(self.positions, axis=0)


def _watched(driver: Driver, failure: Failure) -> Watched:
    assert driver.arm.plant is not None
    watched = Watched(driver.arm.plant(), failure)
    driver.arm = replace(driver.arm, plant=lambda: watched)
    return watched


def _extent(peer: Any) -> tuple[np.ndarray, np.ndarray]:
    """How far each joint has gone since the failure, by the peer's own account, two of shape (n,) [rad]."""
    peer.tell("truth")
    numbers = np.array(peer.wait_for("truth ").split()[1:], float)
    return numbers[: len(numbers) // 2], numbers[len(numbers) // 2 :]


def _beyond(extent: tuple[np.ndarray, np.ndarray], failure: Failure, arm: BenchArm) -> float:
    commands = np.array(failure.commands)
    deceleration = np.minimum(arm.limits.acceleration, -arm.limits.acceleration_lower)
    way = WatchLimits().tracking + stopping_distance(failure.velocity, deceleration)
    low, high = extent
    beyond = np.maximum(commands.min(axis=0) - way - low, high - commands.max(axis=0) - way)
    return float(max(beyond.max(), 0.0))
