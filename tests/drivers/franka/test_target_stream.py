"""What is given out each millisecond: every command once, within the limits, and to rest whatever happens."""

import numpy as np
import pytest

from exidyn.drivers.franka.target_stream import (
    ACCELERATION,
    CYCLE,
    JERK,
    JOINTS,
    LOWER,
    UPPER,
    VELOCITY,
    LimitCheck,
    TargetStream,
    fastest,
    stopping,
)

MIDDLE = 0.5 * (LOWER + UPPER)
HELD_BACK = 5


def motion(count=400, amplitude=0.05):
    phase = np.linspace(0.0, 2.0 * np.pi, count)
    return MIDDLE + 0.5 * amplitude * (1.0 - np.cos(phase))[:, None]


def largest(positions):
    """Acceleration and jerk of a stream that begins at rest."""
    rows = np.vstack([positions[0]] * 3 + [positions])
    return [np.abs(np.diff(rows, order, axis=0)).max() / CYCLE**order for order in (2, 3)]


def test_every_command_is_given_out_once_and_in_turn():
    stream, given = TargetStream(MIDDLE, HELD_BACK), []
    commands = motion()
    for command in commands:
        stream.add(command)
        given.append(stream.next(1).position)
    assert stream.reason == ""
    np.testing.assert_array_equal(given[HELD_BACK - 1 :], commands[: len(given) - HELD_BACK + 1])
    np.testing.assert_array_equal(given[: HELD_BACK - 1], [MIDDLE] * (HELD_BACK - 1))


def test_what_a_lost_state_would_have_had_is_left_out():
    stream, commands = TargetStream(MIDDLE, HELD_BACK), motion()
    for command in commands[:50]:
        stream.add(command)
    for _ in range(10):
        stream.next(1)
    np.testing.assert_array_equal(stream.next(3).position, commands[12])


def test_without_commands_it_comes_to_rest_within_the_limits():
    stream, given = TargetStream(MIDDLE, HELD_BACK), []
    for command in motion()[:150]:
        stream.add(command)
        given.append(stream.next(1).position)
    while not (step := stream.next(1)).finished:
        given.append(step.position)
    assert "no command for 5 ms" in stream.reason
    given.append(step.position)
    acceleration, jerk = largest(given)
    assert acceleration < ACCELERATION
    assert jerk < JERK
    np.testing.assert_array_equal(stream.next(1).position, step.position)


@pytest.mark.parametrize("seed", range(40))
def test_a_stop_ends_at_rest_within_the_limits_from_any_state(seed):
    random = np.random.default_rng(seed)
    velocity = random.uniform(-1.0, 1.0, JOINTS) * VELOCITY
    acceleration = random.uniform(-1.0, 1.0, JOINTS) * ACCELERATION
    way = stopping(np.zeros(JOINTS), velocity, acceleration)
    before = np.array([-velocity * CYCLE + 0.5 * acceleration * CYCLE**2, np.zeros(JOINTS)])
    rows = np.vstack([before, way, way[-1:], way[-1:]])
    found = np.diff(rows, 2, axis=0) / CYCLE**2
    assert np.abs(found).max() < ACCELERATION * 1.01
    jerk = np.diff(np.vstack([acceleration, found]), axis=0) / CYCLE
    assert np.abs(jerk).max() < JERK * 1.01
    assert np.abs(found[-1]).max() < 0.1
    assert len(way) * CYCLE < 2.2


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda q: q + np.eye(JOINTS)[2] * 1e-3, "joint 3: commanded acceleration is 1000 rad/s^2"),
        (lambda q: q + np.eye(JOINTS)[1] * 8e-6, "joint 2: commanded jerk is 8000 rad/s^3"),
        (lambda q: q + np.eye(JOINTS)[4] * 0.1, "joint 5: commanded velocity is 100 rad/s"),
        (lambda q: q * np.nan, "joint 1: commanded"),
        (lambda q: UPPER + 0.1, "joint 1: commanded position is 0.1 rad beyond"),
    ],
)
def test_what_is_beyond_a_limit_is_named_and_not_given_out(change, words):
    stream = TargetStream(MIDDLE, 1)
    stream.add(change(MIDDLE))
    step = stream.next(1)
    assert words in stream.reason
    np.testing.assert_array_equal(step.position, MIDDLE)


def test_near_an_end_a_joint_may_only_be_as_fast_as_it_can_be_stopped():
    np.testing.assert_array_equal(fastest(np.full(JOINTS, 3.0)), VELOCITY)
    np.testing.assert_array_equal(fastest(np.full(JOINTS, 1e-3)), np.zeros(JOINTS))
    towards, away = (LimitCheck(UPPER - 0.1) for _ in range(2))
    for number in range(1, 600):
        assert away.look(UPPER - 0.1 - 4e-6 * number**2 / 2) == "" or number > 250
        if words := towards.look(np.minimum(UPPER - 0.1 + 4e-6 * number**2 / 2, UPPER)):
            break
    assert "commanded velocity" in words
