"""One run with a fault that spoils a stop, through `perform` on the mock with its stepped clock."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from exidyn.acquire.run.arms import make_driver
from exidyn.acquire.run.before import StartRules
from exidyn.acquire.run.frames import EVENT, SAMPLE, Event, Unframed, read_cycle, read_event
from exidyn.acquire.run.perform import Job, perform
from exidyn.acquire.run.stopping.stop import Stop
from exidyn.drivers import Driver, StopLevel
from exidyn.drivers.driver import Plant
from exidyn.trajectories.limits.moves import move
from exidyn.trajectories.trajectory import State, Trajectory

from ..motion import LIMITS, MODEL, START
from .arm import heavy, light
from .cases import Case

CYCLE = 0.008
"""Between those of CAN and of servos [s]."""
AWAY = np.full(MODEL.robot.dof, 0.05)
"""From where the arm stands to where the motion begins [rad]."""

BEFORE = 0.02
"""By which a person asks for a stop before the fault that spoils it [s]."""
ENDING = 0.4
"""Over which the speed in the end is a mean [s]."""


class Asked(NamedTuple):
    """A stop as the recording has it.

    Attributes:
        level: How hard.
        waited: Time since the fault, or since the level before if that was asked later [s].
    """

    level: StopLevel
    waited: float


class Ran(NamedTuple):
    """What a run has left.

    Attributes:
        stops: In order.
        asked: Levels with which the driver was called.
        cycles: That were made.
        recorded: That were handed over.
        way: Of joint1 from the fault until the end [rad].
        speed: Of the fastest joint in the end [rad/s].
    """

    stops: tuple[Asked, ...]
    asked: list[StopLevel]
    cycles: int
    recorded: int
    way: float
    speed: float


class Kept:
    """A sink that keeps cycles and events, and when the first command was sent [s]."""

    failure = ""
    first_command = float("inf")

    def __init__(self) -> None:
        self._unframed = Unframed()
        self.times: list[float] = []
        self.positions: list[np.ndarray] = []
        self.events: list[Event] = []

    def put(self, frame: bytes) -> None:
        for kind, body in self._unframed.add(frame):
            if kind == SAMPLE:
                cycle = read_cycle(body)
                self.times.append(1e-9 * cycle.controller_time)
                self.positions.append(cycle.array("position"))
            elif kind == EVENT:
                self.events.append(read_event(body))
                if self.events[-1].text == "approaching":
                    self.first_command = 1e-9 * self.events[-1].controller_time

    def since_first_command(self) -> float:
        """Time that has gone by [s]."""
        return self.times[-1] - self.first_command if self.times else -float("inf")

    def close(self) -> None:
        """Nothing waits here."""


@cache
def motion() -> Trajectory:
    """A rest-to-rest move of all joints."""
    first = START + AWAY
    return move(State.at_rest(first), State.at_rest(first + 0.6), LIMITS, CYCLE)


@cache
def _undisturbed() -> dict[str, float]:
    """When each stage begins, from the first command on [s]."""
    kept = Kept()
    perform(_driver("", lambda: light(False)), _job(), [kept])
    begins = {event.text: 1e-9 * event.controller_time for event in kept.events if event.kind == "stage"}
    return {stage: time - begins["approaching"] for stage, time in begins.items()}


def _job() -> Job:
    return Job(MODEL.robot, motion(), LIMITS, StartRules(approach=True))


def _driver(faults: str, plant: Callable[[], Plant]) -> Driver:
    return make_driver("mock", {"cycle": CYCLE, "faults": faults}, MODEL.robot, plant)


def moments() -> dict[str, tuple[float, StopLevel | None]]:
    """When the fault begins in each stage, from the first command on [s], and what a person asks then."""
    begins = _undisturbed()
    middle = begins["running"] + 0.5 * motion().duration
    return {
        "listening": (-1.0, None),
        "approaching": (0.1, None),
        "running": (middle, None),
        "braking": (middle + BEFORE, StopLevel.BRAKE),
        "holding": (begins["holding"] + 0.1, None),
        "quick stop": (middle + BEFORE, StopLevel.QUICK),
    }


def ran(case: Case, arm: Callable[[bool], Plant] = heavy) -> Ran:
    """Let it happen, on an arm that is made by whether its encoders are coarse."""
    begins, level = moments()[case.stage]
    at = "start" if begins < 0.0 else f"{begins:.4f}"
    driver = _driver(case.fault.faults.format(at=at), lambda: arm(case.fault.coarse))
    kept, asked = Kept(), list[StopLevel]()
    stop = driver.stop

    def noted(level: StopLevel) -> None:
        asked.append(level)
        stop(level)

    def person() -> Stop | None:
        due = level is not None and kept.since_first_command() >= begins - BEFORE
        return Stop(level, "asked", "asked to stop") if level is not None and due else None

    driver.stop = noted  # type: ignore[method-assign]
    outcome = perform(driver, _job(), [kept], stop_request=person)
    fault = kept.times[0] if begins < 0.0 else kept.first_command + begins
    return Ran(
        _waited(kept.events, fault),
        asked,
        outcome.counts.cycles,
        len(kept.times),
        *_motion(np.array(kept.times), np.array(kept.positions), fault),
    )


def _waited(events: Sequence[Event], fault: float) -> tuple[Asked, ...]:
    stops, before = list[Asked](), fault
    for event in (event for event in events if event.kind == "stop"):
        time = 1e-9 * event.controller_time
        stops.append(Asked(StopLevel[str(event.details["level"])], max(time - before, 0.0)))
        before = max(time, fault)
    return tuple(stops)


def _motion(time: np.ndarray, position: np.ndarray, fault: float) -> tuple[float, float]:
    """Way of joint1 from the fault to the end [rad], and speed of the fastest joint in the end [rad/s]."""
    since = position[np.minimum(np.searchsorted(time, fault), len(time) - 1) :, 0]
    window = round(ENDING / CYCLE)
    speed = np.abs(position[-1] - position[max(len(position) - 1 - window, 0)]) / ENDING
    way = np.abs(since - since[0])
    return float(np.nanmax(way, initial=0.0)), float(np.nanmax(speed, initial=0.0))
