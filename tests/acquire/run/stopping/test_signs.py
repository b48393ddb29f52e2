"""Signs, with samples made by hand: what counts, and what noise, weight and steady errors must not."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.acquire.run.stopping.escalation import Sign, State, escalate
from exidyn.acquire.run.stopping.history import History
from exidyn.acquire.run.stopping.signs import Signs
from exidyn.acquire.run.stopping.watch import WatchLimits
from exidyn.drivers import Command, Sample
from exidyn.identification.arm.robot import Limits

pytestmark = pytest.mark.clocked(patient=True)

JOINTS = ("one", "two")
TWO = np.ones(2)
LIMITS = Limits(*(n * TWO for n in (-3.0, 3.0, 2.0, 5.0, 100.0, 50.0)))
CYCLE = 0.01
COARSE = 1.5e-3


ROBOT = SimpleNamespace(joints=JOINTS, dof=2, unit=lambda joint, unit: unit)


def signs(current=10.0, cycle=CYCLE, flange=None):
    history = History(2, cycle, round(WatchLimits().delay / cycle))
    return Signs(ROBOT, LIMITS, current * TWO, WatchLimits(), cycle, history, flange)


def reach(position):
    """The flange of an arm of one metre, turned by joint one."""
    return np.array([np.cos(position[0]), np.sin(position[0]), 0.0])


def sample(number, position, fault="", current=np.nan, cycle=CYCLE):
    time, nothing = round(1e9 * number * cycle), np.full(2, np.nan)
    return Sample(
        time, time, np.array(position, float), nothing, current * TWO, nothing, nothing, fault=fault
    )


def first(looking, state, rows, sent=None, begin=0, velocity=0 * TWO, **drives):
    """Time after which a row of positions (t, 2) escalates [s], and to what; None for never."""
    for number, row in enumerate(rows):
        command = None if sent is None else Command(np.array(sent[number], float), velocity)
        seen = looking.look(sample(begin + number, row, **drives), command, state)
        found = escalate(state, seen)
        if found is not None:
            return (number + 1) * CYCLE, found
    return None


def ramp(speed, count=400, start=0.0):
    """Joint one goes on, joint two stands, shape (t, 2)."""
    return np.outer(start + speed * CYCLE * np.arange(1, count + 1), [1.0, 0.0])


def noisy(count, seed=0):
    random = np.random.default_rng(seed)
    return COARSE * np.round((COARSE * random.normal(size=(count, 2))) / COARSE)


@pytest.mark.parametrize("state", [State.LISTENING, State.BRAKING, State.HOLDING, State.QUICK])
@pytest.mark.parametrize("seed", range(5))
def test_noise_of_a_coarse_encoder_is_no_motion_in_a_minute(state, seed):
    still = np.zeros((6000, 2))
    assert first(signs(), state, noisy(6000, seed), None if state is State.LISTENING else still) is None


@pytest.mark.parametrize("cycle", [0.001, 0.002, 0.004, 0.012])
def test_so_it_is_at_every_rate(cycle):
    looking = signs(cycle=cycle)
    for number, row in enumerate(noisy(5000)):
        seen = looking.look(
            sample(number, row, cycle=cycle), Command(np.zeros(2), np.zeros(2)), State.HOLDING
        )
        assert escalate(State.HOLDING, seen) is None


def test_an_arm_that_brakes_as_commanded_and_late_is_sound():
    """From 2 rad/s with 5 rad/s^2, 50 ms behind, in steps of an encoder."""
    speed = np.maximum(2.0 - 5.0 * CYCLE * np.arange(100), 0.0)
    way = np.cumsum(speed) * CYCLE
    looking = signs()
    for number in range(100):
        measured = COARSE * round(way[max(number - 5, 0)] / COARSE)
        command = Command(np.array([way[number], 0.0]), np.array([speed[number], 0.0]))
        state = State.BRAKING if speed[number] else State.HOLDING
        seen = looking.look(sample(number, [measured, 0.0]), command, state)
        assert escalate(state, seen) is None


def test_one_that_does_not_is_seen_in_a_fifth_of_a_second():
    time, found = first(signs(), State.HOLDING, ramp(0.5), np.zeros((400, 2)))
    assert found.kind == Sign.FASTER.value
    assert found.joint == "one"
    assert time <= 0.2


def test_a_soft_arm_that_swings_where_it_is_held_is_sound():
    swing = np.outer(0.03 * np.cos(10.0 * CYCLE * np.arange(300)), [1.0, 0.0])
    for state in (State.BRAKING, State.HOLDING):
        assert first(signs(), state, swing, np.zeros((300, 2))) is None


def test_an_encoder_that_jumps_is_no_motion():
    rows = np.zeros((100, 2))
    rows[30:, 0] = 0.03
    assert first(signs(), State.HOLDING, rows, np.zeros((100, 2))) is None


def test_a_steady_error_at_rest_is_a_quick_stop_and_never_takes_the_torque():
    rows, still = np.full((400, 2), 0.2), np.zeros((400, 2))
    looking = signs()
    time, found = first(looking, State.HOLDING, rows, still)
    assert (found.kind, found.level.name) == (Sign.AWAY.value, "QUICK")
    assert time == pytest.approx(0.2, abs=2.1 * CYCLE)
    assert first(looking, State.QUICK, rows, begin=400) is None


def test_beyond_a_limit_counts_outwards_only():
    out, back = ramp(1.0, 100, 2.9), ramp(-1.0, 50, 3.6)
    found = first(signs(), State.BRAKING, out, out, velocity=3 * TWO)
    assert found[1].kind == Sign.OUTWARD.value
    assert first(signs(), State.BRAKING, back, back, velocity=3 * TWO) is None


def test_a_joint_may_have_begun_beyond_a_limit():
    looking = signs()
    looking.look(sample(0, [3.5, 0.0]), None, State.LISTENING)
    rows = np.tile([3.5, 0.0], (50, 1))
    assert first(looking, State.BRAKING, rows, rows, begin=1) is None


def test_an_arm_that_sags_until_its_springs_hold_it_is_not_adrift():
    rows = np.outer(0.08 * (1 - np.exp(-np.arange(200) * CYCLE / 0.1)), [1.0, 0.0])
    assert first(signs(), State.LISTENING, rows) is None
    assert first(signs(), State.LISTENING, ramp(1.0))[1].kind == Sign.ADRIFT.value


def moved(looking, state, rows):
    for number, row in enumerate(rows):
        looking.look(sample(number, row), Command(row, np.array([2.0, 0.0])), state)


def braked(deceleration):
    """At 2 rad/s for half a second, and then braked, shape (t, 2)."""
    speed = np.concatenate([np.full(50, 2.0), np.maximum(2.0 - deceleration * CYCLE * np.arange(400), 0.0)])
    return np.outer(np.cumsum(speed) * CYCLE, [1.0, 0.0])


@pytest.mark.parametrize(("deceleration", "works"), [(5.0, True), (3.0, True), (0.5, False), (0.0, False)])
def test_the_torque_is_taken_where_a_quick_stop_evidently_fails(deceleration, works):
    rows, looking = braked(deceleration), signs()
    moved(looking, State.MOVING, rows[:50])
    found = first(looking, State.QUICK, rows[50:], begin=50)
    assert (found is None) == works
    if found is not None:
        time, stop = found
        assert stop.level.name == "OFF"
        assert 0.15 + 2.0 / 2.5 < time < 0.15 + 2.0 / 2.5 + 0.4  # when it should have ended, and a while


def test_an_arm_that_swings_to_rest_is_not_dropped():
    looking, time = signs(), CYCLE * np.arange(400)
    moved(looking, State.MOVING, braked(5.0)[:50])
    swing = 1.0 + 0.15 * np.exp(-time) * np.cos(9.0 * time)
    assert first(looking, State.QUICK, np.outer(swing, [1.0, 0.0]), begin=50) is None


@pytest.mark.parametrize(
    ("fault", "current", "dropped"),
    [("two: switched off", 0.1, False), ("two: switched off", 5.0, True), ("two: switched off", np.nan, True),
     ("", 0.1, True)],
)  # fmt: skip
def test_a_joint_that_falls_without_torque_does_not_take_that_of_the_others(fault, current, dropped):
    looking, rows = signs(), ramp(2.0)
    moved(looking, State.MOVING, rows[:50])
    found = first(looking, State.QUICK, rows[50:], begin=50, fault=fault, current=current)
    assert (found is not None) == dropped


def test_a_joint_that_nobody_hears_moves_for_nobody():
    looking, rows = signs(), ramp(2.0)
    moved(looking, State.MOVING, rows[:50])
    rows[50:, 0] = np.nan
    assert first(looking, State.QUICK, rows[50:], begin=50) is None


def test_cycles_that_show_nothing_are_no_break():
    rows = ramp(2.0, 100)
    rows[::7] = np.nan
    assert first(signs(), State.HOLDING, rows, np.zeros((100, 2)))[1].kind == Sign.FASTER.value


def test_it_is_calm_where_nothing_moves_and_nothing_is_suspected():
    looking = signs()
    assert not looking.calm  # nobody knows yet
    for number in range(60):
        looking.look(sample(number, [0.0, 0.0]), Command(0 * TWO, 0 * TWO), State.HOLDING)
    assert looking.calm
    looking.look(replace(sample(60, [0.05, 0.0])), Command(0 * TWO, 0 * TWO), State.HOLDING)
    assert not looking.calm


@pytest.mark.parametrize(("state", "level"), [(State.HOLDING, "QUICK"), (State.QUICK, "OFF")])
@pytest.mark.parametrize("speed", [0.087, 0.02, -0.087])
def test_a_joint_that_creeps_on_after_a_stop_is_stopped_harder_however_slow(state, level, speed):
    rows = ramp(speed, 200) + noisy(200)
    time, stop = first(signs(flange=reach), state, rows, np.zeros((200, 2)) if level == "QUICK" else None)
    assert stop.level.name == level
    if abs(speed) < 0.05 or level == "OFF":  # faster ones are seen by their tracking error first
        assert (stop.kind, stop.unit) == (Sign.FLANGE_CREEPS.value, "m")
    assert time < 2.0  # as long as is listened after a stop


def test_a_wrist_that_turns_on_in_its_place_is_seen_by_its_angle():
    rows = ramp(0.087)[:, ::-1]  # joint two, which moves no flange
    _, stop = first(signs(flange=reach), State.QUICK, rows)
    assert (stop.kind, stop.joint) == (Sign.CREEPS.value, "two")


@pytest.mark.parametrize("state", [State.HOLDING, State.QUICK])
def test_what_swings_or_sags_to_rest_after_a_stop_does_not_creep(state):
    time = CYCLE * np.arange(400)
    swing = 0.15 * np.exp(-0.3 * time) * np.cos(2.0 * np.pi * 1.2 * time)
    sag = 0.09 * (1.0 - np.exp(-time / 0.1))
    for way in (swing, sag):
        rows = np.outer(way, [1.0, 0.0])
        moved_signs = signs(flange=reach)
        assert first(moved_signs, state, rows, rows if state is State.HOLDING else None) is None


def end_of(rows):
    looking = signs()
    for number, row in enumerate(rows):
        looking.look(sample(number, row), None, State.QUICK)
    return looking.at_end()


@pytest.mark.parametrize("seed", range(20))
def test_at_the_end_noise_is_rest_and_half_a_degree_a_second_is_motion(seed):
    assert end_of(noisy(200, seed)).stands
    standstill = end_of(noisy(200, seed) + ramp(0.02, 200))
    assert standstill.moving
    assert standstill.joint == "one"
    assert standstill.speed == pytest.approx(0.02, abs=0.01)
    assert "one STILL MOVES at 0.0" in standstill.text


def test_of_a_joint_that_is_silent_at_the_end_nobody_knows():
    rows = np.zeros((200, 2))
    rows[-10:, 1] = np.nan
    standstill = end_of(rows)
    assert standstill.moving is None
    assert "nothing is received from two" in standstill.text
    assert end_of(np.zeros((10, 2))).moving is None  # too short to say


def at_rest(position, commanded, state=State.HOLDING, velocity=0.0):
    """What is said of an arm that stands there, by the command that was sent last."""
    looking = signs()
    command = Command(np.array(commanded, float), velocity * TWO)
    for number in range(120):
        looking.look(
            sample(number, position), command if number == 0 or state is State.HOLDING else None, state
        )
    return looking.at_end()


def test_an_arm_that_stands_where_it_was_commanded_is_all_right():
    standstill = at_rest((0.0, 0.01), (0.0, 0.0))
    assert standstill.expected
    assert standstill.details() == {"moving": False, "standstill": "the arm stands"}


def test_an_arm_that_stands_elsewhere_is_told_with_joint_and_distance():
    standstill = at_rest((0.0, 0.98), (0.0, 0.0))
    assert standstill.stands
    assert not standstill.expected
    assert "two is 0.98 rad from its last command, limit 0.035" in standstill.text
    assert standstill.details()["away"] == pytest.approx(0.98)


@pytest.mark.parametrize(("away", "expected"), [(0.5, True), (1.2, False)])
def test_after_a_quick_stop_the_arm_may_stand_its_stopping_distance_further_on(away, expected):
    # 1 rad/s takes 0.15 rad until drives react and 0.2 rad at half of 5 rad/s^2.
    standstill = at_rest((away - 0.2, 0.0), (0.0, 0.0), State.QUICK, velocity=1.0)
    assert standstill.expected is expected


def test_an_arm_that_was_never_commanded_stands_anywhere():
    looking = signs()
    for number in range(120):
        looking.look(sample(number, (1.0, 2.0)), None, State.LISTENING)
    assert looking.at_end().expected
