"""A KUKA controller that adds corrections instead of taking them: the brake holds one, and the arm runs."""

import numpy as np
import pytest

from exidyn.acquire.run.arms import make_driver
from exidyn.acquire.run.perform import Job, perform
from exidyn.acquire.run.stopping.watch import WatchLimits
from exidyn.drivers import StopLevel
from exidyn.drivers.kuka_rsi.config import config_text, standard_config
from exidyn.trajectories.limits.moves import move
from exidyn.trajectories.trajectory import State

from ....parts.controllers.rsi_controller import counted, free_port, running
from ....parts.runs.run_parts import LIMITS, ROBOT, START, Listening

pytestmark = pytest.mark.clocked

WIDE = 360.0
SLOW = 4e-3
"""Of the limits: one correction a cycle then stays below the speed at which the controller itself stops."""
LASTING = 250
"""Cycles after which the controller adds."""


def slow_motion():
    """Half a degree in four seconds; the controller adds from its second second on."""
    slow = LIMITS.__class__(
        LIMITS.position_lower, LIMITS.position_upper, SLOW * LIMITS.velocity, SLOW * LIMITS.acceleration,
        LIMITS.jerk, LIMITS.torque,
    )  # fmt: skip
    return move(State.at_rest(START), State.at_rest(START + 0.008), slow, 0.004)


def test_a_controller_in_relative_mode_is_stopped_by_its_own_means(tmp_path):
    path = tmp_path / "RSI_EthernetConfig.xml"
    path.write_text(config_text(standard_config("127.0.0.1", free_port())))
    given = {"controller": "127.0.0.1", "config": str(path), "wait": 20.0, "timeout": 500}
    given |= {"window_lower": -WIDE, "window_upper": WIDE, "overall": WIDE, "probe": False}
    axes = ",".join(f"{angle:.6f}" for angle in np.degrees(START))
    options = ("--axiscorr", WIDE, "--axiscorrmon", WIDE, "--timeout", 500, "--seconds", 60)
    busy = WatchLimits(missed=1.0, stall=1.0, silence=1.0, stale=1.0)  # as this machine may be
    sink = Listening()
    job = Job(ROBOT, slow_motion(), LIMITS, watch=busy)
    with running(path, *options, f"--start={axes}", "--additive", LASTING) as peer:
        outcome = perform(make_driver("kuka_rsi", given, ROBOT), job, [sink])
        counts = counted(peer)
    assert (outcome.stop.kind, outcome.stop.level) == ("tracking error", StopLevel.BRAKE)
    assert [stop.level for stop in outcome.escalated] == [StopLevel.QUICK]
    assert counts["stopped"] == "stopped by the Stop channel"
