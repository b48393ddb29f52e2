import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import ruckig

from exidyn.identification.arm.robot import Limits
from exidyn.trajectories.errors import BadLimits, Infeasible
from exidyn.trajectories.limits.moves import brake, brake_reach, move
from exidyn.trajectories.trajectory import State

pytestmark = pytest.mark.slow

REPOSITORY = Path(__file__).parents[3]
PACKAGES = ("acquire", "drivers", "identify", "trajectories")
TICK = 0.004


def random_limits(random, joints):
    """Different forward and backward; the jerk from lazy to stiff."""
    forward, backward = random.uniform(0.5, 3, (2, joints)), random.uniform(0.5, 3, (2, joints))
    far = np.full(joints, np.inf)
    return Limits(
        -far,
        far,
        forward[0],
        8 * forward[1],
        random.uniform(5, 500, joints),
        far,
        -backward[0],
        -8 * backward[1],
    )


def random_problem(seed):
    """A start that may be beyond its limits, and a target that can be reached within them."""
    random = np.random.default_rng(seed)
    joints = int(random.integers(1, 7))
    limits = random_limits(random, joints)
    share = random.uniform(-1.3, 1.3, (2, joints))
    speeds = np.where(share[0] > 0, limits.velocity, -limits.velocity_lower)
    pushes = np.where(share[1] > 0, limits.acceleration, -limits.acceleration_lower)
    start = State(random.uniform(-3, 3, joints), share[0] * speeds, share[1] * pushes)
    velocity = random.uniform(0.6 * limits.velocity_lower, 0.6 * limits.velocity)
    room = np.where(
        random.integers(0, 2, joints) == 1, velocity - limits.velocity_lower, velocity - limits.velocity
    )
    acceleration = np.sign(room) * np.sqrt(2 * limits.jerk * np.abs(room))
    acceleration = random.uniform(0, 1) * np.clip(
        acceleration, limits.acceleration_lower, limits.acceleration
    )
    return start, State(random.uniform(-3, 3, joints), velocity, acceleration), limits


@pytest.mark.parametrize("seed", range(30))
def test_a_move_meets_both_ends_on_a_tick_within_the_limits(seed):
    start, target, limits = random_problem(seed)
    start = State(start.position, start.velocity / 1.3, start.acceleration / 1.3)
    way = move(start, target, limits, TICK)
    assert way.duration / TICK == pytest.approx(round(way.duration / TICK), abs=1e-9)
    np.testing.assert_array_equal(way.state_at(0.0), start)
    np.testing.assert_allclose(way.end_state, target, atol=1e-8)
    reached = way.extremes()
    assert np.all(reached.acceleration.upper <= limits.acceleration + 1e-9)
    assert np.all(reached.acceleration.lower >= limits.acceleration_lower - 1e-9)
    assert np.all(np.maximum(reached.jerk.upper, -reached.jerk.lower) <= limits.jerk + 1e-9)
    # A start whose acceleration carries the velocity beyond its limit cannot keep it; the end always can.
    gained = 0.5 * start.acceleration * np.abs(start.acceleration) / limits.jerk
    highest = np.maximum(limits.velocity, start.velocity + gained)
    lowest = np.minimum(limits.velocity_lower, start.velocity + gained)
    assert np.all(reached.velocity.upper <= highest + 1e-9)
    assert np.all(reached.velocity.lower >= lowest - 1e-9)


@pytest.mark.parametrize("seed", range(30))
def test_the_pieces_are_what_ruckig_states_at_any_time(seed):
    start, target, limits = random_problem(seed)
    n = len(limits.jerk)
    asked, message = ruckig.InputParameter(n), ruckig.Trajectory(n)
    asked.current_position, asked.current_velocity, asked.current_acceleration = map(list, start)
    asked.target_position, asked.target_velocity, asked.target_acceleration = map(list, target)
    asked.max_velocity, asked.min_velocity = list(limits.velocity), list(limits.velocity_lower)
    asked.max_acceleration, asked.min_acceleration = (
        list(limits.acceleration),
        list(limits.acceleration_lower),
    )
    asked.max_jerk = list(limits.jerk)
    asked.duration_discretization = ruckig.DurationDiscretization.Discrete
    ruckig.Ruckig(n, TICK).calculate(asked, message)
    way = move(start, target, limits, TICK)
    assert way.duration == pytest.approx(message.duration, abs=1e-12)
    time = np.linspace(0.0, min(way.duration, message.duration), 101)
    here = way.at(time)
    expected = np.array([message.at_time(instant) for instant in time])
    for order, found in enumerate(here[1:4]):
        np.testing.assert_allclose(found, expected[:, order], atol=1e-9)


def test_a_move_to_where_it_is_and_a_brake_from_rest_take_no_time():
    rest, limits = State.at_rest(np.array([0.2, 0.3])), random_limits(np.random.default_rng(0), 2)
    for way in (move(rest, rest, limits, TICK), brake(rest, limits, TICK)):
        assert way.duration == 0.0
        np.testing.assert_array_equal(way.end_state, rest)


@pytest.mark.parametrize("seed", range(30))
def test_a_brake_ends_at_rest_and_stays(seed):
    start, _, limits = random_problem(seed)
    stop = brake(start, limits, TICK)
    np.testing.assert_array_equal(stop.state_at(0.0), start)
    assert stop.duration / TICK == pytest.approx(round(stop.duration / TICK), abs=1e-9)
    assert 0.0 <= stop.duration - brake(start, limits).duration < TICK + 1e-9
    end = stop.end_state
    np.testing.assert_allclose([end.velocity, end.acceleration], 0.0, atol=1e-9)
    assert np.all(np.maximum(stop.extremes().jerk.upper, -stop.extremes().jerk.lower) <= limits.jerk + 1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_the_reach_of_a_brake_is_that_of_its_motion(seed):
    start, _, limits = random_problem(seed)
    reach = brake_reach(start.velocity[None], start.acceleration[None], limits)
    reached = brake(start, limits).extremes().position
    np.testing.assert_allclose(start.position + reach.lower[0], reached.lower, atol=1e-9)
    np.testing.assert_allclose(start.position + reach.upper[0], reached.upper, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("velocity", 0.0),
        ("acceleration", np.nan),
        ("jerk", np.inf),
        ("velocity_lower", 0.0),
        ("acceleration_lower", 0.0),
    ],
)
def test_limits_that_nothing_moves_within_name_their_joint(name, value):
    start, target, limits = random_problem(3)
    wrong = getattr(limits, name).copy()
    wrong[1] = value
    for ask in (lambda bad: move(start, target, bad, TICK), lambda bad: brake(start, bad)):
        with pytest.raises(BadLimits, match=f"joint 2: .*{name.split('_')[0]} limit -?({value:g})"):
            ask(replace(limits, **{name: wrong}))


def test_a_sampling_period_or_states_of_another_arm_are_refused():
    start, target, limits = random_problem(3)
    for tick in (0.0, -0.002, np.nan, np.inf):
        with pytest.raises(BadLimits, match="sampling period is"):
            move(start, target, limits, tick)
    with pytest.raises(BadLimits, match="start: position of shape"):
        move(State.at_rest(np.zeros(9)), target, limits, TICK)


@pytest.mark.parametrize(("which", "order"), [("start", 0), ("target", 1), ("start", 2)])
def test_a_state_that_is_no_number_names_its_joint(which, order):
    states = {name: State(*np.zeros((3, 2))) for name in ("start", "target")}
    states[which][order][1] = np.nan
    with pytest.raises(Infeasible, match=f"joint 2: {which} has {State._fields[order]} nan"):
        move(*states.values(), random_limits(np.random.default_rng(0), 2), TICK)


def test_a_target_beyond_its_limits_names_joint_value_and_limit():
    limits = Limits(*np.outer([-9.0, 9.0, 1.0, 10.0, 100.0, 1.0], np.ones(2)))
    rest, still = State.at_rest(np.zeros(2)), np.zeros(2)
    with pytest.raises(Infeasible, match="joint 2: velocity of the target is 1.5 rad/s, allowed are -1 to 1"):
        move(rest, State(still, np.array([0.0, 1.5]), still), limits, TICK)
    with pytest.raises(Infeasible, match="joint 1: acceleration of the target is -11 rad/s"):
        move(rest, State(still, still, np.array([-11.0, 0.0])), limits, TICK)
    # To have 0.9 rad/s at -10 rad/s^2 it must have come from 0.9 + 10^2 / 200 rad/s.
    with pytest.raises(Infeasible, match="joint 1: velocity before its acceleration of the target is 1.4"):
        move(rest, State(still, np.array([0.9, 0.0]), np.array([-10.0, 0.0])), limits, TICK)


def test_an_error_of_ruckig_becomes_ours(monkeypatch):
    def refuses(*_):
        raise ruckig.RuckigError("\n[ruckig] error in step 1, dof: 1 input: \nmuch more")

    monkeypatch.setattr(
        "exidyn.trajectories.limits.moves.ruckig.Ruckig", lambda *_: type("", (), {"calculate": refuses})
    )
    start, target, limits = random_problem(3)
    with pytest.raises(Infeasible, match=r"^joint 2: no move was found: error in step 1.*Try") as caught:
        move(start, target, limits, TICK)
    assert isinstance(caught.value.__cause__, ruckig.RuckigError)


def test_one_module_knows_ruckig_and_sets_no_waypoints_which_ask_a_remote_server():
    assert "intermediate_positions" in dir(ruckig.InputParameter)  # else another name is to be looked for
    knows = set()
    for path in (path for package in PACKAGES for path in (REPOSITORY / package).rglob("*.py")):
        text = path.read_text()
        assert "intermediate_positions" not in text, path
        if re.search(r"^\s*(import|from) ruckig\b", text, re.M):
            knows.add(path.name)
    assert knows == {"moves.py"}
