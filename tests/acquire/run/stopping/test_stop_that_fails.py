"""A run whose stop does not work: what the driver is asked, what is recorded, what a person reads."""

import json
from functools import partial

import numpy as np
import pytest

from exidyn.acquire.run.arms import make_driver
from exidyn.acquire.run.loop import LISTEN_ON
from exidyn.acquire.run.perform import perform
from exidyn.acquire.run.stopping.stop import Stop
from exidyn.acquire.terminal import run_summary
from exidyn.drivers import StopLevel
from exidyn.drivers.errors import LinkLost
from exidyn.identification.simulation.plant import typical_plant

from ....parts.runs.run_parts import CYCLE, MODEL, ROBOT, START, Following, Listening, job

pytestmark = pytest.mark.clocked

BRAKE, QUICK, OFF = StopLevel


def on_the_mock(faults):
    """Outcome and sink of a run, and the levels that the driver was asked."""
    driver, sink, asked = (
        make_driver("mock", {"faults": faults}, ROBOT, partial(typical_plant, MODEL, START)), Listening(), []
    )  # fmt: skip
    stop = driver.stop
    driver.stop = lambda level: (asked.append(level), stop(level))
    return perform(driver, job(), [sink]), sink, asked


def stops_recorded(sink):
    events = (json.loads(event) for event in sink.events())
    return [event for event in events if event["kind"] == "stop"]


def positions(sink):
    return np.array([cycle.array("position") for cycle in sink.cycles()])


def test_a_joint_that_runs_away_is_stopped_by_its_controller():
    outcome, sink, asked = on_the_mock("runaway joint1 2 at 0.3")
    assert asked == [QUICK]
    assert outcome.stop.kind == "tracking error"
    assert [stop.level for stop in outcome.escalated] == [QUICK]
    after = positions(sink)[-100:, 0]
    assert np.ptp(after) < 1e-3
    assert np.abs(after[-1] - START[0]) < 1.0  # 2.1 rad where nothing asks


def test_one_that_ignores_that_loses_its_torque_and_is_recorded_on():
    outcome, sink, asked = on_the_mock("runaway joint1 2 at 0.3; deaf at 0")
    assert asked == [QUICK, OFF]
    recorded = stops_recorded(sink)
    assert [event["details"]["level"] for event in recorded] == ["BRAKE", "QUICK", "OFF"]
    for event in recorded:
        assert event["details"]["value"] > event["details"]["limit"] > 0.0
        assert event["details"]["joint"] == "joint1"
    times = np.array([cycle.controller_time for cycle in sink.cycles()])
    assert np.sum(times > recorded[-1]["controller_time"]) == round(LISTEN_ON / CYCLE)
    assert len(times) == outcome.counts.cycles


def test_commands_that_are_added_do_not_go_on():
    outcome, sink, asked = on_the_mock("additive at start")
    assert asked == [QUICK]
    assert np.ptp(positions(sink)[-100:], axis=0).max() < 1e-3


def test_a_driver_that_fails_at_a_stop_is_asked_for_the_next():
    outcome, sink, asked = on_the_mock("runaway joint1 2 at 0.3; stop fails at 0")
    assert asked == [QUICK, OFF]
    assert outcome.escalated[-1].kind == "stop failed"
    assert "QUICK was not sent" in outcome.escalated[-1].text
    assert stops_recorded(sink)[-1]["details"]["level"] == "OFF"


def test_one_that_fails_at_all_of_them_is_recorded_and_closed():
    driver, sink = (
        Following(change=lambda number, fields: fields.update(fault="x" * (number > 99))),
        Listening(),
    )

    def stop(level):
        driver.stops.append(level)
        raise OSError("unplugged")

    driver.stop = stop
    outcome = perform(driver, job(), [sink])
    assert driver.stops == [QUICK, OFF]
    assert driver.closed == 1
    assert outcome.stop.kind == "drive fault"
    assert any("the driver failed at OFF, the hardest stop: unplugged" in event for event in sink.events())


def test_a_link_that_is_lost_in_a_brake_is_a_quick_stop():
    driver = Following()

    def change(number, fields):
        if number > 160:
            raise LinkLost("nothing comes back")

    driver._change = change
    asked = Stop(BRAKE, "asked", "Ctrl-C")
    outcome = perform(driver, job(), stop_request=lambda: asked if len(driver.commands) > 150 else None)
    assert driver.stops == [QUICK]
    assert outcome.stop.kind == "link lost"


def test_a_link_that_is_lost_in_a_quick_stop_is_reported_and_no_reason_to_drop_the_arm():
    def change(number, fields):
        fields["fault"] = "tripped" * (number >= 150)
        if driver.stops and driver.number > 300:
            raise LinkLost("nothing comes back")

    driver, sink = Following(), Listening()
    driver._change = change
    perform(driver, job(), [sink])
    assert driver.stops == [QUICK]
    assert any("whether the stop works is no longer known" in event for event in sink.events())


@pytest.mark.parametrize("number", [150, 10_000])
def test_the_brake_of_a_person_and_the_end_of_a_run_are_watched_too(number):
    """A joint turns on at 1 rad/s from the brake or from the end of the motion on."""
    driver, sink, begun = Following(), Listening(), []
    last = round(job().motion.duration / CYCLE)

    def change(commands, fields):
        if commands > min(number, last):
            begun.append(driver.number)
            fields["position"][0] += CYCLE * (driver.number - begun[0])

    driver._change = change
    asked = Stop(BRAKE, "asked", "Ctrl-C")
    perform(driver, job(), [sink], stop_request=lambda: asked if len(driver.commands) > number else None)
    assert driver.stops == [QUICK, OFF]
    assert [event["details"]["level"] for event in stops_recorded(sink)] == ["BRAKE", "QUICK", "OFF"]


def test_an_arm_that_turns_away_before_anything_is_commanded_is_stopped():
    driver = Following()
    driver._change = lambda commands, fields: fields.update(
        position=fields["position"] + CYCLE * driver.number * np.eye(6)[0]
    )
    outcome = perform(driver, job())
    # Which comes first goes by how long the way is planned on this machine.
    assert outcome.stop.kind in ("start", "motion without command")
    assert driver.stops[0] == QUICK
    assert not driver.commands


def test_where_something_else_moves_the_arm_its_motion_is_none_of_ours():
    def moves(number, fields):
        if driver.number > 400:
            raise LinkLost("RSI has ended there")
        fields["position"][0] += 0.5 * np.sin(3.0 * CYCLE * driver.number)

    driver = Following(change=moves, listens=True)
    assert perform(driver, job()).stop is None
    assert QUICK not in driver.stops[:-1]


def test_a_joint_that_only_stays_behind_keeps_its_torque():
    driver = Following(change=lambda number, fields: number > 30 and fields.update(position=START))
    assert perform(driver, job()).stop.kind == "tracking error"
    assert driver.stops == [QUICK]


def test_a_person_reads_what_followed():
    outcome, _, _ = on_the_mock("runaway joint1 2 at 0.3; deaf at 0")
    ended, printed = run_summary.end(outcome), run_summary.after(outcome, False)
    assert (ended["stop"], ended["level"]) == ("tracking error", "OFF")
    assert "; then quick: joint1" in ended["text"]
    assert "; then off: joint1" in ended["text"]
    assert printed.startswith("STOPPED (off): joint1: tracking error")
