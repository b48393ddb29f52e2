from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.acquire.run.before import StartRules, plan_start, scaled_limits
from exidyn.acquire.run.errors import CannotStart
from exidyn.acquire.run.player import Player
from exidyn.drivers import Info
from exidyn.identification.arm.robot import SLIDING
from exidyn.trajectories.clearances.clearance import Clearance

from ...parts.runs.run_parts import CYCLE, LIMITS, ROBOT, START, motion

pytestmark = pytest.mark.clocked

INFO = Info(CYCLE, "host", ("position",))


class Wall(Clearance):
    """Something that the first joint must stay below."""

    names = ("joint1 to the wall",)

    def margins(self, position):
        return 0.15 - position[:, :1]

    def gradient(self, position):
        raise NotImplementedError

    def reach(self, travel):
        return np.eye(6)[:1]


def way(measured, **rules):
    return plan_start(Player(motion(), LIMITS, CYCLE), measured, ROBOT, LIMITS, StartRules(**rules), INFO)


def test_within_the_tolerance_it_just_goes_there():
    found = way(START + 0.005)
    assert np.allclose(found.end_state.position, START)


def test_from_further_away_it_goes_slowly_if_it_may():
    found = way(START - 0.4, approach=True)
    speed = found.extremes().velocity.upper
    assert np.all(speed < 1.001 * scaled_limits(LIMITS, 0.2).velocity)
    with pytest.raises(CannotStart, match="--approach"):
        way(START - 0.4)


def test_a_sliding_joint_is_away_in_metres():
    player = Player(motion(), LIMITS, CYCLE)
    measured = START - 0.4 * np.eye(6)[0]
    sliding = SimpleNamespace(joints=ROBOT.joints, unit=lambda joint, unit: SLIDING[unit])
    with pytest.raises(CannotStart, match=r"begins at -?\d+\.\d+ m; limit 0\.0087 m\."):
        plan_start(player, measured, sliding, LIMITS, StartRules(), INFO)


def test_what_is_in_the_way_is_named():
    with pytest.raises(CannotStart, match="joint1 to the wall"):
        way(START + 0.4, approach=True, clearances=(Wall(),))
    assert way(START + 0.1, approach=True, clearances=(Wall(),)).duration > 0.0
