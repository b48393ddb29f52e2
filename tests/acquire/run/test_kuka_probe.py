"""The KUKA driver before a motion: what a controller as a process, or one by hand, makes of its probe."""

import numpy as np
import pytest

from exidyn.acquire.run.perform import perform
from exidyn.drivers import StopLevel
from exidyn.drivers.kuka_rsi.probe import BOUND

from ...parts.controllers.rsi_controller import (
    START,
    by_hand,
    command,
    config_file,
    correction,
    counted,
    driver,
    running,
)
from ...parts.runs.run_parts import PATIENT, Listening, job
from ...parts.runs.run_parts import START as POSE

pytestmark = pytest.mark.clocked(patient=True)


@pytest.fixture
def path(tmp_path):
    return config_file(tmp_path)


def until_ready(one):
    """Samples of the exchanges before the driver takes commands."""
    samples = []
    while not one.ready:
        samples.append(one.exchange(None))
    return samples


@pytest.mark.parametrize(
    "more", [[], ["--lag", 10], ["--noise", 0.001], ["--movecorr", 0.4], ["--precision", 2]]
)
@pytest.mark.parametrize("mode", ["absolute", "relative"])
def test_what_corrections_do_is_seen_before_any_motion(tmp_path, mode, more):
    path = config_file(tmp_path)
    with running(path, "--mode", mode, "--timeout", 200, "--seconds", 30, *more) as peer:
        with driver(path, timeout=200, probe=True) as one:
            one.open()
            samples = until_ready(one)
            last = one.exchange(None)
        counts = counted(peer)
    events = " ".join(text for sample in samples for text in sample.events)
    assert "probing the effect of corrections" in events
    assert counts["furthest"] < BOUND
    if mode == "relative":
        assert "corrections add up" in last.fault
    else:
        assert last.fault == ""
        assert "corrections are distances from the start" in events
        assert counts["furthest"] > 0.005


@pytest.mark.parametrize(
    ("more", "why"),
    [
        (["--linked", "1,1,0,1,1,1"], "did not move the arm by this amount: A3 ("),
        (["--exchange", "2:3"], "A2 moved when A3 was corrected, A3 moved when A2 was corrected. Link"),
        (["--exchange", "1:4:6"], "A1 moved when A4 was corrected, A4 moved when A6 was"),
        (["--precision", 1], "positions come in steps of 0.1 degrees"),
        (["--noise", 0.02], "does not stand still"),
    ],
)
def test_a_run_ends_before_it_begins_where_nobody_sees_what_corrections_do(tmp_path, more, why):
    path = config_file(tmp_path)
    with running(path, "--timeout", 200, "--seconds", 60, *more) as peer:
        with driver(path, timeout=200, probe=True) as one:
            one.open()
            until_ready(one)
            assert why in one.exchange(None).fault
        assert counted(peer)["furthest"] < BOUND


def test_a_run_in_relative_mode_is_recorded_and_refused(tmp_path):
    path, sink = config_file(tmp_path), Listening()
    pose = ",".join(f"{angle:.9f}" for angle in np.degrees(POSE))
    window = {"window_lower": -90.0, "window_upper": 90.0, "overall": 90.0}
    options = [
        "--axiscorr",
        90,
        "--axiscorrmon",
        90,
        "--mode",
        "relative",
        "--timeout",
        200,
        f"--start={pose}",
    ]
    with running(path, *options) as peer:
        outcome = perform(driver(path, timeout=200, probe=True, **window), job(watch=PATIENT), [sink])
        counts = counted(peer)
    assert outcome.stop.kind == "drive fault"
    assert "Call RSI_ON(#ABSOLUTE) in the controller's program" in outcome.stop.text
    assert "\n" not in outcome.stop.text
    assert counts["furthest"] < BOUND
    assert len(sink.cycles()) == outcome.counts.cycles > 200
    assert not any(np.isfinite(cycle.array("command_position")).any() for cycle in sink.cycles())
    assert any("probing the effect of corrections" in event for event in sink.events())


def in_the_first_pattern(controller, one):
    """Go on until the driver corrects."""
    controller.begun(one)
    for _ in range(1000):
        controller.send()
        one.exchange(None)
        if correction(controller.answer()).any():
            return
    raise AssertionError("it never corrected")


@pytest.mark.parametrize("stop", [True, False])
def test_a_probe_that_is_not_finished_corrects_nothing_any_more(tmp_path, stop):
    path = config_file(tmp_path, stop=stop)
    with by_hand(path) as controller, driver(path, probe=True) as one:
        in_the_first_pattern(controller, one)
        controller.send()
        one.close()
        np.testing.assert_array_equal(correction(controller.answer()), 0.0)
    with by_hand(path) as controller, driver(path, probe=True) as one:
        in_the_first_pattern(controller, one)
        controller.send()
        one.stop(StopLevel.QUICK)
        if stop:  # without a Stop channel it falls silent, after one more answer
            one.exchange(None)
        np.testing.assert_array_equal(correction(controller.answer()), 0.0)


def test_a_correction_that_moves_the_arm_too_far_is_not_left_in_force(tmp_path):
    path = config_file(tmp_path, stop=False)
    with by_hand(path) as controller, driver(path, probe=True) as one:
        in_the_first_pattern(controller, one)
        controller.send(position=START + np.full(6, 0.06))
        assert "moved by 0.06 degrees, limit 0.05" in one.exchange(None).fault
        assert correction(controller.answer()).any()
        controller.send()
        one.stop(StopLevel.QUICK)
        np.testing.assert_array_equal(correction(controller.answer()), 0.0)


def test_no_command_is_sent_before_the_driver_is_ready(path):
    with by_hand(path) as controller, driver(path, probe=True) as one:
        controller.begun(one)
        assert not one.ready
        controller.send()
        sample = one.exchange(command(START + np.full(6, 1.0)))
        assert not sample.sent
        assert sample.fault == ""
        np.testing.assert_array_equal(correction(controller.answer()), 0.0)


def test_an_answer_of_the_probe_that_came_too_late_is_given_once_more(path):
    with by_hand(path) as controller, driver(path, probe=True) as one:
        in_the_first_pattern(controller, one)
        steps = 0
        for number in range(2000):
            controller.send(delay=1 + number // 10)  # the last answer was not taken in one cycle of ten
            one.exchange(None)
            if not correction(controller.answer()).any():
                break
            steps += 1
        assert 1 + steps == 125 + len(range(0, steps, 10))
