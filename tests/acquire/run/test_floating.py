"""Commands of an arm that floats: the torque fades in, follows the arm, and stays with it in a stop."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.run.floating import FADE_IN, FloatingCheck, FloatingPlayer, floating_motion
from exidyn.acquire.run.perform import perform
from exidyn.acquire.run.player import BRAKING, HOLDING
from exidyn.acquire.run.stopping.watch import WatchLimits
from exidyn.drivers import Command

from ...parts.runs.run_parts import CYCLE, LIMITS, PATIENT, ROBOT, START, Following, job

pytestmark = pytest.mark.clocked(patient=True)

SECONDS = 0.2
STILL = np.zeros(6)
TORQUE = np.arange(1.0, 7.0)


class Arm:
    """The last sample of an arm that moves at a velocity once it floats."""

    def __init__(self, velocity=0.0):
        self.position, self.velocity, self.floats = START.copy(), velocity, False

    def sample(self):
        return self

    def move(self, command):
        self.floats = self.floats or command.floats
        step = CYCLE * self.velocity if command.floats else 0.0
        self.position = (self.position if command.floats else command.position) + step


def played(arm, torque=lambda position, velocity: TORQUE):
    """Each command with the stage in which it was made."""
    motion = floating_motion(START, SECONDS, CYCLE)
    player = FloatingPlayer(motion, LIMITS, CYCLE, 0.1, torque, arm.sample)
    player.begin(player.approach(START))
    rows = []
    while not player.finished:
        rows.append((player.next(), player.stage))
        arm.move(rows[-1][0])
    return rows


def test_torque_fades_in_before_the_arm_floats_and_stays_in_the_rest():
    rows = played(Arm())
    shares = np.array([command.torque[0] for command, _ in rows])
    first = next(k for k, (command, _) in enumerate(rows) if command.floats)
    assert first == pytest.approx(FADE_IN / CYCLE, abs=3)
    assert np.all(np.diff(shares[:first]) >= 0.0)
    assert np.max(np.abs(np.diff(shares))) < 3.0 / first  # no jump: the steepest is 1.5 over the time
    assert np.all(shares[first:] == 1.0)
    assert sum(command.floats for command, _ in rows) == pytest.approx(SECONDS / CYCLE, abs=2)
    assert rows[-1][1] == HOLDING
    assert not rows[-1][0].floats


def test_each_command_says_where_the_arm_is_and_the_brake_begins_at_its_speed():
    rows = played(Arm(velocity=0.1))
    floating = [command for command, stage in rows if command.floats]
    moved = floating[-1].position - floating[0].position
    np.testing.assert_allclose(moved, 0.1 * CYCLE * (len(floating) - 1), rtol=1e-6)
    np.testing.assert_allclose(floating[-1].velocity, 0.1, rtol=1e-6)
    braking = [command for command, stage in rows if stage == BRAKING]
    positions = np.array([command.position for command in (*floating[-2:], *braking)])
    assert np.abs(np.diff(positions, 2, axis=0)).max() / CYCLE**2 < 1.001 * LIMITS.acceleration.max()


def test_velocity_and_position_reach_the_torque():
    seen = []
    played(Arm(velocity=0.1), lambda position, velocity: seen.append(velocity[0]) or TORQUE)
    assert seen[0] == 0.0
    assert max(seen) == pytest.approx(0.1, rel=1e-6)


def check():
    robot = replace(ROBOT, limits=replace(ROBOT.limits, torque=np.full(6, 10.0)))
    return FloatingCheck(robot, LIMITS, CYCLE, START)


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        ({"torque": None}, "command torque"),
        ({"torque": np.full(6, np.nan)}, "command torque"),
        ({"torque": np.full(6, 10.1)}, "command torque"),
        ({"torque": np.full(6, -10.1), "floats": False}, "command torque"),
        ({"position": LIMITS.position_upper + 0.01}, "command position"),
        ({"position": START + 0.5, "floats": False}, "command velocity"),
    ],
)
def test_a_command_that_may_not_be_is_not_sent(change, kind):
    looked = check()
    valid = Command(START, STILL, TORQUE, floats=True)
    assert looked.look(valid) is None
    stop = looked.look(replace(valid, **change))
    assert stop is not None
    assert stop.kind == kind


def test_the_loop_stops_an_arm_that_drifts_and_holds_it():
    """Its joints move on at 0.2 rad/s while they float."""

    class Drifting(Following):
        def exchange(self, command):
            if command is not None and command.floats:
                command = replace(command, position=command.position + 0.2 * CYCLE)
            return super().exchange(command)

    driver = Drifting(takes_torque=True)
    watch = WatchLimits(**{name: getattr(PATIENT, name) for name in ("missed", "stall", "silence", "stale")})
    work = replace(
        job(),
        motion=floating_motion(START, 2.0, CYCLE),
        watch=replace(watch, drift=0.05),
        torque=lambda position, velocity: TORQUE,
    )
    outcome = perform(driver, work)
    assert outcome.stop.kind == "drift"
    assert not outcome.escalated
    assert outcome.standstill.stands
    assert 0.05 < np.abs(driver.commands[-1] - START).max() < 0.1
