import numpy as np
import pytest

from exidyn.acquire.run.player import BRAKING, HOLDING, Player
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.trajectory import State

from ...parts.runs.run_parts import CYCLE, LIMITS, START, motion

pytestmark = pytest.mark.clocked(patient=True)


def played(player, count=10_000):
    commands = []
    while not player.finished and len(commands) < count:
        commands.append(player.next().position)
    return np.array(commands)


def begun(way=None, what=None):
    player = Player(what or motion(), LIMITS, CYCLE, settle=0.1)
    player.begin(way or player.approach(START))
    return player


def test_commands_are_the_motion_at_every_cycle_and_then_rest():
    commands, states = played(begun()), motion().every(CYCLE)
    assert np.array_equal(commands[: len(states.time)], states.position)
    assert len(commands) == len(states.time) + 50
    assert np.all(commands[len(states.time) :] == states.position[-1])


def test_nothing_is_commanded_before_it_has_begun():
    assert Player(motion(), LIMITS, CYCLE).next() is None


def test_a_motion_that_ends_moving_is_braked():
    moving = Phases.of_jerks(State.at_rest(START), np.array([0.05]), np.full((1, 6), 20.0))
    player = begun(what=moving)
    commands = played(player)
    acceleration = np.abs(np.diff(commands, 2, axis=0)) / CYCLE**2
    assert player.finished
    assert np.all(acceleration < 1.001 * LIMITS.acceleration)
    assert np.abs(commands[-1] - moving.end_state.position).max() > 1e-4


def test_a_brake_continues_the_last_command_without_a_step_in_velocity():
    player = begun()
    commands = list(played(player, 200))
    player.brake()
    commands = np.concatenate([commands, played(player)])
    assert player.stage == HOLDING
    assert np.all(np.abs(np.diff(commands, 2, axis=0)) / CYCLE**2 < 1.001 * LIMITS.acceleration)


def test_a_brake_from_a_command_that_was_not_sent_begins_at_the_one_before():
    player = begun()
    before = played(player, 200)[-1]
    player.next()
    player.take_back()
    player.brake()
    after = player.next()
    assert player.stage == BRAKING
    assert np.allclose(after.position - before, CYCLE * after.velocity, atol=1e-4)


def test_a_brake_before_the_first_command_ends_it():
    player = begun()
    player.brake()
    assert player.finished
