"""Every fault in every stage of a run: which stop is asked of the driver, and when.

The arm follows its commands at once, on the mock with its stepped clock.
"""

from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np
import pytest

from exidyn.acquire.run.arms import make_driver
from exidyn.acquire.run.before import StartRules
from exidyn.acquire.run.frames import EVENT, SAMPLE, STAGES, Unframed, read_cycle, read_event
from exidyn.acquire.run.perform import Job, perform
from exidyn.acquire.run.stopping.escalation import (
    RULES,
    WATCHED,
    Sight,
    Sign,
    State,
    allowed_speed,
    escalate,
    overdue,
    state_of,
)
from exidyn.acquire.run.stopping.stop import Stop, Stops, after_failure
from exidyn.drivers import StopLevel
from exidyn.trajectories.limits.moves import move
from exidyn.trajectories.trajectory import State as MotionState

from ....parts.runs.run_parts import LIMITS, ROBOT, START

pytestmark = pytest.mark.clocked

NONE, BRAKE, QUICK, OFF = 0, *StopLevel
LEVEL = {State.QUICK: QUICK, State.OFF: OFF}
LETTERS = {BRAKE: "B", QUICK: "Q", OFF: "O"}
WITHIN = {BRAKE: 0.6, QUICK: 0.5, OFF: 1.6}
"""From a fault to the first level, and from each level to the next, at most [s].

BRAKE: 0.15 s of a tracking error, and what an arm that approaches slowly takes to have one.
QUICK: 0.1 s in which the delay of drives and the mean of a speed end, 0.1 s to be sure, or a brake of 0.25 s
and 0.2 s for the error behind it.
OFF: 1.15 s in which a quick stop from full speed ends, or less and the 0.67 s of 0.2 rad at 0.3 rad/s, and
0.1 s to be sure.
"""
RESTS = 0.1
"""Speed below which an arm rests at the end [rad/s]."""
CYCLE = 0.008
COARSE = 1.5e-3
"""Step of a serial servo's encoder, and standard deviation of its noise [rad]."""
BEFORE = 0.02
"""Time by which a person asks for a stop before the fault that spoils it [s]."""
BEGUN_IN = ("listening", "approaching", "running", "braking", "holding", "quick stop")
"""Where a fault begins; in the fourth a person has asked for a brake, in the last for a quick stop."""


class Fault(NamedTuple):
    """A fault as the mock gets it, with {at} for when, and the levels that must be asked in each stage.

    B is a brake, Q a quick stop, O off, "-" where the fault cannot be. Without `rests`, nothing helps, and
    the arm need not rest at the end. `late` is the time until a slow fault is a tracking error [s].
    """

    name: str
    faults: str
    levels: str
    coarse: bool = False
    rests: bool = True
    late: float = 0.0


AWAY = "BQO BQO BQO BQO BQO QO"
FAULTS = (
    # Sound arms are not escalated, whatever their encoders.
    Fault("none", "", ". . . B . Q"),
    Fault("none; coarse encoders", "", ". . . B . Q", coarse=True),
    # A drive that runs away, and what follows where it ignores the next level, or the driver fails at it.
    Fault("runaway", "runaway joint1 2 at {at}", "BQ BQ BQ BQ BQ Q"),
    Fault("runaway; deaf", "runaway joint1 2 at {at}; deaf at start", AWAY, rests=False),
    Fault("slow runaway; deaf", "runaway joint1 0.3 at {at}; deaf at start", AWAY, rests=False),
    Fault("creep; deaf", "runaway joint1 0.08 at {at}; deaf at start", AWAY, rests=False, late=0.035 / 0.08),
    Fault("runaway; QUICK fails", "runaway joint1 2 at {at}; stop fails at start", AWAY, rests=False),
    Fault("runaway; all fail", "runaway joint1 2 at {at}; stop fails 3 at start", AWAY, rests=False),
    # Commands are added; where they rest, or are a millimeter's, nothing runs.
    Fault("commands are added", "additive at {at}", "BQ BQ BQ BQ . Q"),
    # A joint that stays where it is must not lose its torque.
    Fault("joint stuck", "stuck joint1 at {at}", "BQ BQ BQ BQ . Q"),
    Fault("encoder slips by 0.3 rad", "jump joint1 0.3 at {at}", "BQ BQ BQ BQ BQ Q"),
    # These are quick stops at once, in every stage.
    Fault("drive fault", "fault joint1 at {at}", "Q Q Q BQ Q Q"),
    Fault("joint silent", "stale joint1 at {at}", "Q Q Q BQ Q Q"),
    Fault("not a number", "nan joint1 at {at} for 9", "Q Q Q BQ Q Q"),
    Fault("link lost", "silent at {at}", "- Q Q BQ Q Q", rests=False),
    # These are brakes, and no reason to stop harder.
    Fault("current too high", "current spike joint1 at {at} for 0.3", "B B B B B Q"),
    Fault("no cycle for 0.1 s", "stall 0.1 at {at}", ". B B B B Q"),
    Fault("two cycles without reply", "drop at {at} for 0.016", "- . . B . Q"),
)
CASES = [
    pytest.param(fault, stage, levels.strip("."), id=f"{fault.name}, {stage}")
    for fault in FAULTS
    for stage, levels in zip(BEGUN_IN, fault.levels.split(), strict=True)
    if levels != "-"
]


class Measured(NamedTuple):
    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    temperature: np.ndarray


class Light:
    """An arm that follows its commands at once."""

    def __init__(self, coarse):
        self._position, self._coarse, self._random = START, coarse, np.random.default_rng(0)

    def step(self, position, velocity, seconds):
        self._position = np.array(position)

    def measure(self):
        position, nothing = self._position, np.zeros(ROBOT.dof)
        if self._coarse:
            position = COARSE * np.round(position / COARSE + self._random.normal(size=ROBOT.dof))
        return Measured(position, nothing, nothing, nothing + 25.0)


class Kept:
    """A sink that keeps cycles and events, and when the first command was sent [s]."""

    failure, first_command = "", float("inf")

    def __init__(self):
        self._unframed, self.times, self.positions, self.events = Unframed(), [], [], []

    def put(self, frame):
        for kind, body in self._unframed.add(frame):
            if kind == SAMPLE:
                cycle = read_cycle(body)
                self.times.append(1e-9 * cycle.controller_time)
                self.positions.append(cycle.array("position"))
            elif kind == EVENT:
                self.events.append(read_event(body))
                if self.events[-1].text == "approaching":
                    self.first_command = 1e-9 * self.events[-1].controller_time

    def close(self):
        pass


@cache
def moving():
    """A rest-to-rest move of all joints."""
    first = START + 0.05
    return move(MotionState.at_rest(first), MotionState.at_rest(first + 0.6), LIMITS, CYCLE)


def played(kept, faults="", coarse=False, **other):
    """The outcome of a run, and the levels that the driver was asked for."""
    driver = make_driver("mock", {"cycle": CYCLE, "faults": faults}, ROBOT, lambda: Light(coarse))
    asked, stop = [], driver.stop
    driver.stop = lambda level: (asked.append(level), stop(level))
    return perform(driver, Job(ROBOT, moving(), LIMITS, StartRules(approach=True)), [kept], **other), asked


@cache
def moments():
    """When the fault begins in each stage, from the first command on [s], and what a person asks for then."""
    kept = Kept()
    played(kept)
    begins = {event.text: 1e-9 * event.controller_time for event in kept.events if event.kind == "stage"}
    middle = begins["running"] - begins["approaching"] + 0.5 * moving().duration
    return dict(zip(BEGUN_IN, (
        (-1.0, None), (0.1, None), (middle, None), (middle + BEFORE, BRAKE),
        (begins["holding"] - begins["approaching"] + 0.1, None), (middle + BEFORE, QUICK),
    ), strict=True))  # fmt: skip


@pytest.mark.parametrize(("fault", "stage", "levels"), CASES)
def test_what_is_asked_of_the_driver(fault, stage, levels):
    begins, level = moments()[stage]
    kept = Kept()

    def person():
        since = kept.times[-1] - kept.first_command if kept.times else -np.inf
        due = level is not None and since >= begins - BEFORE
        return Stop(level, "asked", "asked to stop") if due else None

    at = "start" if begins < 0.0 else f"{begins:.4f}"
    outcome, asked = played(kept, fault.faults.format(at=at), fault.coarse, stop_request=person)
    before = began = kept.times[0] if begins < 0.0 else kept.first_command + begins
    seen = []
    for event in kept.events:
        if event.kind == "stop":
            stop, time = StopLevel[str(event.details["level"])], 1e-9 * event.controller_time
            assert time - before <= WITHIN[stop] + fault.late
            seen.append(stop)
            before = max(time, began)
    assert "".join(LETTERS[stop] for stop in seen) == levels
    assert asked == [stop for stop in seen if stop > BRAKE] == sorted(set(asked))
    assert outcome.counts.cycles == len(kept.times)
    if fault.rests:
        window = round(0.4 / CYCLE)
        last, earlier = kept.positions[-1], kept.positions[max(len(kept.positions) - 1 - window, 0)]
        assert np.nanmax(np.abs(last - earlier), initial=0.0) / 0.4 <= RESTS


def sight(seconds):
    return Sight("joint1", 2.0, 1.0, seconds)


@pytest.mark.parametrize(("state", "sign"), list(product(State, Sign)))
def test_a_sign_does_what_the_table_states_after_its_time_and_nothing_before(state, sign):
    rule = RULES.get((state, sign))
    for seconds in (0.0, 0.099, 0.101, 0.199, 0.201, 10.0):
        found = escalate(state, {sign: sight(seconds)})
        if rule is None or seconds < rule.seconds:
            assert found is None
        else:
            assert (found.level, found.kind, found.value, found.limit) == (rule.level, sign.value, 2.0, 1.0)
    assert (rule is not None) == (sign in WATCHED[state])


def test_the_table_goes_up_one_level_at_a_time_and_takes_the_torque_only_after_a_quick_stop():
    for (state, _), rule in RULES.items():
        assert rule.level > LEVEL.get(state, NONE)
        assert (rule.level == OFF) == (state is State.QUICK)
    assert not WATCHED[State.OFF]
    assert not WATCHED[State.MOVING]


@pytest.mark.parametrize("stage", range(len(STAGES)))
def test_a_state_is_that_of_the_commands_until_the_controller_stops(stage):
    expected = {"approaching": State.MOVING, "running": State.MOVING}
    expected |= {name: State[name.upper()] for name in ("listening", "braking", "holding")}
    for level in (NONE, BRAKE):
        assert state_of(level, stage) is expected[STAGES[stage]]
    assert state_of(QUICK, stage) is State.QUICK
    assert state_of(OFF, stage) is State.OFF


class Refusing:
    """A driver that fails at some levels."""

    def __init__(self, *levels):
        self.levels, self.asked = levels, []

    def stop(self, level):
        self.asked.append(level)
        if level in self.levels:
            raise OSError("no such device")


@pytest.mark.parametrize("begin", list(StopLevel))
@pytest.mark.parametrize("then", list(StopLevel))
@pytest.mark.parametrize("fails", [(), (QUICK,), (OFF,), (QUICK, OFF)])
def test_no_level_goes_down_or_is_asked_twice_and_a_failure_asks_for_the_next(begin, then, fails):
    driver, events = Refusing(*fails), []
    stops = Stops(driver, lambda *event: events.append(event))
    first = Stop(begin, "first", "")
    stops.begin(first)
    stops.begin(Stop(then, "then", ""))
    stops.escalate(Stop(then, "then", ""))
    assert driver.asked == sorted(set(driver.asked))
    highest = max(begin, then)
    expected = OFF if QUICK in fails and highest == QUICK else highest
    assert stops.level == expected
    levels = [details["level"] for kind, _, details in events if kind == "stop"]
    assert levels == sorted(set(levels), key=lambda name: StopLevel[name])
    assert any("no such device" in text for _, text, _ in events) == any(f in driver.asked for f in fails)


def test_behind_off_nothing_is_left():
    assert after_failure(OFF, OSError()) is None
    assert after_failure(QUICK, OSError("why")).level == OFF
    assert "why" in after_failure(QUICK, OSError("why")).text


def test_a_quick_stop_worked_out_by_hand():
    """2 rad/s with half of 4 rad/s^2, from 0.15 s on: 1 rad/s at 0.65 s, rest at 1.15 s."""
    speed, limit = np.array([2.0, 0.0]), np.array([4.0, 4.0])
    np.testing.assert_allclose(allowed_speed(speed, limit, 0.1), speed)
    np.testing.assert_allclose(allowed_speed(speed, limit, 0.65), [1.0, 0.0])
    np.testing.assert_allclose(allowed_speed(speed, limit, 3.0), 0.0)
    assert overdue(speed, limit, 0.14).tolist() == [False, False]
    assert overdue(speed, limit, 1.14).tolist() == [False, True]
    assert overdue(speed, limit, 1.16).tolist() == [True, True]
    assert overdue(10 * speed, limit, 1.16).tolist() == [True, True]  # but it may still be that fast
