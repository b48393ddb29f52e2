import time
from functools import partial

import numpy as np
import pytest

from exidyn.acquire.run import perform as performing
from exidyn.acquire.run.arms import make_driver, noise_seed
from exidyn.acquire.run.before import StartRules
from exidyn.acquire.run.frames import HEAD, STAGES, text_frame
from exidyn.acquire.run.perform import perform
from exidyn.acquire.run.stopping.stop import Stop
from exidyn.acquire.run.stopping.watch import WatchLimits
from exidyn.drivers import StopLevel
from exidyn.drivers.errors import LinkLost
from exidyn.identification.simulation.plant import typical_plant

from ...parts.runs.run_parts import CYCLE, LIMITS, MODEL, ROBOT, START, Following, Listening, job

pytestmark = pytest.mark.clocked


def at(number, **values):
    """Spoils the sample after so many commands and all that follow."""

    def change(commands, fields):
        if commands >= number:
            fields.update(values)

    return change


def largest_acceleration(driver):
    return np.abs(np.diff(np.array(driver.commands), 2, axis=0)).max(axis=0) / CYCLE**2


def test_a_run_listens_approaches_plays_and_rests():
    driver, sink = Following(START - 0.2), Listening()
    outcome = perform(driver, job(start=StartRules(approach=True)), [sink])
    stages = [STAGES[cycle.stage] for cycle in sink.cycles()]
    assert outcome.stop is None
    assert list(dict.fromkeys(stages)) == ["listening", "approaching", "running", "holding"]
    assert np.allclose(driver.position, START + 0.5)
    assert driver.closed == 1
    assert not driver.stops


def test_every_cycle_is_handed_over_with_the_command_that_was_sent_in_it():
    driver, sink = Following(), Listening()
    outcome = perform(driver, job(), [sink])
    cycles = sink.cycles()
    sent = [c.array("command_position") for c in cycles if np.isfinite(c.array("command_position")).all()]
    assert len(cycles) == outcome.counts.cycles == driver.number
    assert np.array_equal(sent, driver.commands)


def test_the_head_comes_first_and_was_written_before_the_first_exchange():
    driver, sink, exchanged = Following(), Listening(), []

    def head(info):
        exchanged.append(driver.number)
        return lambda sample: text_frame(HEAD, {"time": sample.host_time})

    perform(driver, job(), [sink], head)
    assert sink.frames[0] == (HEAD, b'{"time": %d}' % sink.cycles()[0].host_time)
    assert [kind for kind, _ in sink.frames].count(HEAD) == 1
    assert exchanged == [0]


def test_consecutive_commands_keep_to_the_limits_from_the_first_on():
    driver = Following(START - 0.2)
    perform(driver, job(start=StartRules(approach=True)))
    assert np.abs(driver.commands[0] - (START - 0.2)).max() < 1e-4
    assert np.all(largest_acceleration(driver) < 1.001 * LIMITS.acceleration)


def test_late_cycles_delay_the_motion_and_do_not_make_it_jump():
    driver = Following(change=lambda number, fields: fields.update(skipped=3 * (number % 50 == 0)))
    outcome = perform(driver, job(watch=job().watch.__class__(missed=1.0)))
    assert outcome.stop is None
    assert outcome.counts.skipped > 10
    assert np.all(largest_acceleration(driver) < 1.001 * LIMITS.acceleration)


def test_asked_to_stop_it_brakes_within_the_limits_and_records_the_rest():
    driver, sink = Following(), Listening()
    asked = Stop(StopLevel.BRAKE, "asked", "Ctrl-C")
    outcome = perform(
        driver, job(), [sink], stop_request=lambda: asked if len(driver.commands) > 150 else None
    )
    stages = list(dict.fromkeys(STAGES[cycle.stage] for cycle in sink.cycles()))
    assert outcome.stop is asked
    assert stages == ["listening", "running", "braking", "holding"]
    assert not driver.stops
    assert np.all(largest_acceleration(driver) < 1.001 * LIMITS.acceleration)
    assert np.array_equal(driver.commands[-1], driver.commands[-2])


def test_a_second_request_is_left_to_the_controller():
    driver = Following()
    levels = {150: StopLevel.BRAKE, 160: StopLevel.QUICK}

    def asked():
        reached = [level for number, level in levels.items() if len(driver.commands) > number]
        return Stop(max(reached), "asked", "") if reached else None

    outcome = perform(driver, job(), stop_request=asked)
    assert outcome.stop.level == StopLevel.QUICK
    assert driver.stops == [StopLevel.QUICK]
    assert len(driver.commands) < 170


def test_a_stop_is_not_taken_back():
    driver = Following(change=lambda number, fields: fields.update(fault="tripped" if number == 150 else ""))
    outcome = perform(driver, job())
    assert outcome.stop.kind == "drive fault"
    assert driver.stops == [StopLevel.QUICK]
    assert len(driver.commands) < 155


@pytest.mark.parametrize(
    ("spoilt", "kind", "level"),
    [
        ({"fault": "overcurrent"}, "drive fault", StopLevel.QUICK),
        ({"stale": np.array([0, 0, 1, 0, 0, 0], bool)}, "silence", StopLevel.QUICK),
        ({"position": START + 1.0}, "speed", StopLevel.BRAKE),
        ({"position": START}, "tracking error", StopLevel.BRAKE),
        ({"current": np.array([0, 0, 80.0, 0, 0, 0])}, "current", StopLevel.BRAKE),
        ({"torque": np.full(6, 1e3)}, "torque", StopLevel.BRAKE),
        ({"temperature": np.full(6, 120.0)}, "temperature", StopLevel.BRAKE),
        ({"skipped": 30}, "stall", StopLevel.BRAKE),
        ({"skipped": 1}, "lateness", StopLevel.BRAKE),
    ],
)
def test_what_is_watched_stops_the_run(spoilt, kind, level):
    driver, sink = Following(change=at(30, **spoilt)), Listening()
    outcome = perform(driver, job(), [sink])
    assert (outcome.stop.kind, outcome.stop.level) == (kind, level)
    assert any(outcome.stop.text in event for event in sink.events())


def test_a_recorder_that_cannot_go_on_stops_the_run():
    driver, sink = Following(), Listening()
    sink.put = lambda frame: setattr(sink, "failure", "disk full" if len(driver.commands) > 150 else "")
    outcome = perform(driver, job(), [sink])
    assert outcome.stop.kind == "recorder"
    assert "disk full" in outcome.stop.text
    assert outcome.stop.level == StopLevel.BRAKE


def test_a_view_that_cannot_go_on_does_not():
    view = Listening()
    view.failure = "killed"
    assert perform(Following(), job(), [Listening(), view]).stop is None


def test_a_link_that_is_lost_ends_the_run_by_the_controllers_own_means():
    driver = Following()

    def change(number, fields):
        if number == 150:
            raise LinkLost("nothing comes back")

    driver._change = change
    outcome = perform(driver, job())
    assert outcome.stop.kind == "link lost"
    assert driver.stops == [StopLevel.QUICK]
    assert driver.closed == 1


def test_an_arm_that_stands_elsewhere_is_not_moved():
    driver = Following(START + np.array([0, 0, 0.1, 0, 0, 0]))
    outcome = perform(driver, job())
    assert outcome.stop.kind == "start"
    assert "joint3 is at 0.1000" in outcome.stop.text
    assert "--approach" in outcome.stop.text
    assert not driver.commands


def test_an_unknown_joint_is_not_moved():
    nowhere = START.copy()
    nowhere[1] = np.nan
    driver = Following(nowhere, change=lambda number, fields: fields.update(stale=np.zeros(6, bool)))
    outcome = perform(driver, job())
    assert outcome.stop.joint == "joint2"
    assert not driver.commands


def test_a_motion_wider_than_the_controllers_window_is_not_begun():
    window = np.full(6, np.radians(5.0))
    driver = Following(window_lower=-window, window_upper=window)
    outcome = perform(driver, job())
    assert "the controller accepts -5.00 to 5.00" in outcome.stop.text
    assert not driver.commands


def test_a_driver_that_fails_is_a_quick_stop_and_nobody_knows_whether_the_arm_stands():
    driver = Following()

    def break_down(number, fields):
        raise ZeroDivisionError("a fault in the program")

    driver._change = break_down
    outcome = perform(driver, job())
    assert (outcome.stop.kind, outcome.stop.level) == ("driver failed", StopLevel.QUICK)
    assert "ZeroDivisionError: a fault in the program (test_loop.py:" in outcome.stop.text
    assert outcome.standstill.moving is None
    assert driver.stops == [StopLevel.QUICK]
    assert driver.closed == 1


def test_a_driver_that_fails_once_is_listened_to_until_the_arm_stands():
    driver, sink, failed = Following(), Listening(), []

    def break_down(number, fields):
        if number == 150 and not failed:
            failed.append(driver.number)
            raise ZeroDivisionError

    driver._change = break_down
    outcome = perform(driver, job(), [sink])
    assert driver.stops == [StopLevel.QUICK]
    assert outcome.standstill.stands
    assert driver.number - failed[0] > 100


@pytest.mark.parametrize("where", ["asked", "watch"])
def test_whatever_else_fails_in_the_loop_stops_the_arm_and_is_recorded(where, monkeypatch):
    driver, sink = Following(), Listening()

    def fail_late(*_):
        if len(driver.commands) > 150:
            raise KeyError("a fault in the program")

    if where == "watch":
        monkeypatch.setattr(performing.Watch, "look", fail_late)
    outcome = perform(driver, job(), [sink], stop_request=fail_late if where == "asked" else lambda: None)
    assert outcome.stop.kind == "program failed"
    assert driver.stops == [StopLevel.QUICK]
    assert driver.closed == 1
    assert len(driver.commands) < 160
    assert outcome.standstill.moving is None  # what watches has failed, so nobody knows
    events = "".join(sink.events())
    assert "KeyError: 'a fault in the program'" in events
    assert "Traceback" in events


def test_a_recorder_that_fails_is_a_brake_and_a_view_that_fails_is_not():
    def fail(frame):
        raise OSError("a fault in the program")

    broken = Listening()
    broken.put = fail
    driver = Following()
    outcome = perform(driver, job(), [broken, Listening()])
    assert (outcome.stop.kind, outcome.stop.level) == ("recorder", StopLevel.BRAKE)
    assert outcome.standstill.stands
    assert perform(Following(), job(), [Listening(), broken]).stop is None


@pytest.mark.parametrize(
    "spoilt", [{"controller_time": 1 << 70}, {"host_time": -5}, {"position": np.zeros(3)}]
)
def test_a_sample_that_cannot_be_is_not_computed_with(spoilt):
    outcome = perform(Following(change=at(150, **spoilt)), job())
    assert (outcome.stop.kind, outcome.stop.level) == ("link lost", StopLevel.QUICK)


def test_a_value_that_cannot_be_is_a_silent_joint_and_said():
    far = START.copy()
    far[2] = 1e300
    driver, sink = Following(change=at(150, position=far)), Listening()
    assert perform(driver, job(), [sink]).stop.kind == "silence"
    assert any("position of joint 3 is 1e+300 rad; expected" in event for event in sink.events())
    known = np.array([cycle.array("position") for cycle in sink.cycles()])
    assert np.nanmax(np.abs(known)) < 10.0


def test_a_command_that_was_not_sent_is_the_next_one():
    unsent = []

    def change(number, fields):
        fields["sent"] = number % 7 != 3 or unsent[-1:] == [number]
        if not fields["sent"]:
            unsent.append(number)

    driver, sink = Following(change=change), Listening()
    following = driver.exchange

    def exchange(command):
        before = driver.position
        sample = following(command)
        if not sample.sent and command is not None:
            driver.commands.pop()
            driver.position = before
        return sample

    driver.exchange = exchange
    outcome = perform(driver, job(watch=WatchLimits(missed=1.0)), [sink])
    states = job().motion.every(CYCLE).position
    assert outcome.stop is None
    assert len(unsent) > 50
    assert np.allclose(driver.commands[: len(states)], states, atol=1e-12)


def planned_slowly(monkeypatch):
    """Make it take a while to find the way to where the motion begins."""
    planned = performing.plan_start

    def slowly(*arguments):
        time.sleep(0.05)
        return planned(*arguments)

    monkeypatch.setattr(performing, "plan_start", slowly)


def test_asked_to_stop_while_the_way_is_planned_nothing_is_commanded(monkeypatch):
    planned_slowly(monkeypatch)
    driver = Following()
    asked = Stop(StopLevel.BRAKE, "asked", "Ctrl-C")
    outcome = perform(driver, job(), stop_request=lambda: asked if driver.number > 60 else None)
    assert outcome.stop is asked
    assert not driver.commands
    assert driver.closed == 1


def test_an_arm_that_moves_while_the_way_is_planned_is_not_commanded(monkeypatch):
    planned_slowly(monkeypatch)
    driver = Following()

    def sag(number, fields):
        fields["position"][1] -= 0.02 * (driver.number > 60)

    driver._change = sag
    outcome = perform(driver, job())
    assert outcome.stop.kind == "start"
    assert "joint2 moved by 0.0200 rad while the approach was planned" in outcome.stop.text
    assert not driver.commands


def test_how_the_controller_stops_the_arm_is_not_called_running():
    driver, sink = Following(change=at(150, fault="tripped")), Listening()
    perform(driver, job(), [sink])
    assert [STAGES[cycle.stage] for cycle in sink.cycles()][-100:] == ["braking"] * 100


def test_the_drives_are_powered_after_the_driver_reports():
    driver, calls = Following(), []
    driver.arm_drives = lambda: calls.append("powered")
    perform(driver, job(), opened=lambda info: calls.append(info.cycle))
    assert calls == [CYCLE, "powered"]


def test_a_limit_of_zero_is_recorded():
    details = Stop(StopLevel.BRAKE, "stall", "", value=0.1, limit=0.0, unit="s").details()
    assert details == {"stop": "stall", "level": "BRAKE", "value": 0.1, "limit": 0.0, "unit": "s"}


def test_commands_begin_where_the_drives_hold_and_not_where_a_loaded_joint_stands():
    driver = Following()
    driver.holds = START + 0.004
    assert perform(driver, job()).stop is None
    np.testing.assert_allclose(driver.commands[0], driver.holds, atol=1e-6)
    assert np.all(largest_acceleration(driver) <= 1.001 * np.maximum(LIMITS.acceleration, 0))


def test_an_arm_that_its_drives_do_not_hold_is_not_commanded():
    driver = Following()
    driver.holds = START + np.eye(len(START))[2] * 0.05
    outcome = perform(driver, job())
    assert outcome.stop.kind == "start"
    assert "stands 0.0500 rad from where its drive was commanded" in outcome.stop.text
    assert not driver.commands


def test_where_the_controller_takes_no_commands_it_is_listened_to_until_it_ends():
    def ends(number, fields):
        if driver.number > 300:
            raise LinkLost("RSI has ended there")

    driver, sink = Following(change=ends, listens=True), Listening()
    outcome = perform(driver, job(), [sink])
    assert outcome.stop is None
    assert not driver.commands
    assert len(sink.cycles()) == 300


def test_a_simulation_off_the_wall_clock_is_the_same_every_time():
    def played():
        sink = Listening()
        plant = partial(typical_plant, MODEL, START)
        perform(make_driver("mock", {}, ROBOT, plant), job(), [sink])
        return sink.frames

    assert played() == played()


class Preparing(Following):
    """Takes no commands for a while, and as long moves by itself."""

    @property
    def ready(self):
        return self.number >= 50

    def exchange(self, command):
        assert self.ready or command is None
        if not self.ready:
            self.position = START + 1e-3 * max(20 - abs(20 - self.number), 0)
        return super().exchange(command)


def test_a_driver_that_is_not_ready_is_listened_to_and_where_the_arm_stands_is_judged_then():
    driver, sink = Preparing(), Listening()
    outcome = perform(driver, job(), [sink])
    assert outcome.stop is None
    assert len(sink.cycles()) == driver.number
    assert np.isnan([cycle.array("command_position") for cycle in sink.cycles()[:50]]).all()


def test_a_driver_that_is_not_ready_can_be_stopped():
    driver, asked = Preparing(), Stop(StopLevel.BRAKE, "asked", "Ctrl-C")
    outcome = perform(driver, job(), stop_request=lambda: asked if driver.number > 20 else None)
    assert outcome.stop is asked
    assert driver.number < 20 + 0.7 / CYCLE  # watched for half a second, in which it rests, and never moved
    assert not driver.commands
    assert driver.closed == 1


def test_in_long_cycles_a_command_is_no_tracking_error_before_a_sample_can_show_it():
    outcome = perform(Following(cycle=0.04), job())
    assert outcome.stop is None


def test_two_runs_of_one_seed_are_two_draws():
    assert noise_seed(0, "run") != noise_seed(0, "loaded")
    assert noise_seed(0, "run") != noise_seed(1, "run")
    assert noise_seed(3, "run") == noise_seed(3, "run")
