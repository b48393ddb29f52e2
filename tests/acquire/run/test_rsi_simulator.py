"""Simulators that wait for answers and count them, and what must not be taken for one."""

import numpy as np
import pytest

from exidyn.acquire.run.perform import perform
from exidyn.drivers.errors import NotReady

from ...parts.controllers.rsi_controller import by_hand, config_file, counted, driver
from ...parts.runs.run_parts import PATIENT, Listening, job
from ...parts.runs.run_parts import START as POSE
from ...peers.peer_process import Peer

pytestmark = pytest.mark.clocked


@pytest.fixture
def path(tmp_path):
    return config_file(tmp_path)


def counter_config(folder, **changes):
    """A configuration of what such simulators send."""
    path = config_file(folder, **changes)
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(line for line in lines if "MACur" not in line and "ASPos" not in line))
    return path


def test_a_simulator_that_counts_answers_is_recognised_and_runs(tmp_path):
    path, sink = counter_config(tmp_path), Listening()
    pose = ",".join(f"{angle:.9f}" for angle in np.degrees(POSE))
    wide = {"window_lower": -90.0, "window_upper": 90.0, "overall": 90.0, "timeout": 100, "probe": True}
    options = "--config", path, f"--start={pose}", "--pause", 0.01, "--patience", 0.1
    with Peer("rsi_counter.py", *options, shared=False) as peer:
        outcome = perform(driver(path, **wide), job(watch=PATIENT), [sink])
        counts = counted(peer)
    info, cycles = outcome.info, sink.cycles()
    assert outcome.stop is None
    assert info.cycle != 0.004
    assert info.clock == "host"
    assert f"the cycle of {1e3 * info.cycle:g} ms is measured" in info.warnings[0]
    assert "this is a simulator that waits for each answer" in info.warnings[0]
    assert not any("positions come in steps" in text for text in info.warnings)
    assert "count of answers" in info.settings["stamps"]
    # each telegram was answered, and only once
    assert counts["answered"] > outcome.counts.cycles
    # times are this computer's, and not a count in milliseconds
    received = [cycle for cycle in cycles if not np.isnan(cycle.arrays[0]).any()]
    since = np.diff([(cycle.controller_time, cycle.host_time) for cycle in received], axis=0)
    # [ns]; behind a silent cycle the host time is that of the sample after it, by microseconds
    np.testing.assert_allclose(since[:, 0], since[:, 1], atol=1e5)
    moved = cycles[-1].array("position") - POSE
    np.testing.assert_allclose(moved, 0.5, atol=1e-6)


def test_a_simulator_that_waits_is_not_answered_where_the_driver_only_listens(tmp_path):
    path = counter_config(tmp_path, only_send=True)
    with Peer("rsi_counter.py", "--config", path, "--patience", 0.02, shared=False) as peer:
        with (
            driver(path, wait=0.5) as one,
            pytest.raises(NotReady, match="repeats one telegram, as simulators do"),
        ):
            one.open()
        peer.close()
    assert '"answered": 0' in peer.lines[-1]


def test_a_controller_whose_telegrams_come_twice_is_no_simulator(path):
    with by_hand(path, cycle=12) as controller, driver(path) as one:
        once = controller.raw
        controller.raw = lambda data: [once(data) for _ in range(5)]
        with pytest.raises(NotReady, match=r"sends every 12 ms, not every 4 ms. Set cycle to 0.012"):
            controller.opened(one)
        assert controller.nothing()


def test_a_sender_that_counts_by_one_and_does_not_wait_is_refused(path):
    with by_hand(path, cycle=1) as controller, driver(path) as one:
        with pytest.raises(NotReady, match=r"sends every 1 ms, not every 4 ms"):
            controller.opened(one)
        assert controller.nothing()
