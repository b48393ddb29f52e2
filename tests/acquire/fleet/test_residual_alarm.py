"""`exidyn watch --arm`: the residual of a moving mock, held against its arm's check runs."""

import json
from concurrent.futures import ThreadPoolExecutor
from itertools import count

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.fleet.analysis import ResidualAlarm, expected_of
from exidyn.acquire.fleet.source import Source
from exidyn.acquire.fleet.store import Store
from exidyn.acquire.fleet.work import identify_new
from exidyn.acquire.run.arms import make_driver
from exidyn.acquire.run.listener import Listener
from exidyn.drivers import Command
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.simulation.plant import typical_plant

from ...parts.small import two_joints

pytestmark = pytest.mark.slow
ARM, RUNS, CYCLE, SECONDS = "welding-07", 8, 0.008, 10.0


def moved(friction, seed):
    """A mock that something else moves, again and again; friction of the first joint over the usual one."""
    model = two_joints.model()
    motion = two_joints.trajectory(SECONDS).at(np.arange(0.0, SECONDS, CYCLE))
    values = dict(zip(model.names, two_joints.true_values(model), strict=True))
    values |= {name: values[name] * friction for name in ("Fv1", "Fc1")}
    true = np.array([values[name] for name in model.names])
    driver = make_driver(
        "mock",
        {"cycle": CYCLE},
        model.robot,
        lambda: typical_plant(model, motion.position[0], true, seed=seed),
    )
    exchange, rows = driver.exchange, count()

    def exchanged(command):
        row = next(rows) % len(motion.time)
        return exchange(Command(motion.position[row], motion.velocity[row]))

    driver.exchange = exchanged
    return driver


def samples(friction, seed, seconds=SECONDS + 2 * CYCLE):
    driver = moved(friction, seed)
    driver.open()
    return [driver.exchange(None) for _ in range(round(seconds / CYCLE))]


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """Check runs of an arm, and another's, by the same mock."""
    folder = tmp_path_factory.mktemp("check runs")
    for run in range(RUNS):
        rows = samples(1.0 + 0.005 * np.random.default_rng(run).normal(), run)
        time = 1e-9 * np.array([one.controller_time for one in rows], float)
        signals = {
            name: Signal(time - time[0], np.array([getattr(one, name) for one in rows]))
            for name in ("position", "current", "temperature")
        }
        path = folder / ARM / f"2026-01-{run + 1:02}.mcap"
        path.parent.mkdir(exist_ok=True)
        write_recording(Recording(path.stem, two_joints.model(), signals), path)
    found = Store(tmp_path_factory.mktemp("kept"))
    with ThreadPoolExecutor(1) as executor:
        identify_new(Source(str(folder)), found, executor)
    return found


def residual_of(store, friction):
    with ThreadPoolExecutor(1) as executor:
        alarm = ResidualAlarm(store, ARM, 1.0, executor)
        first = alarm.add(samples(friction, 99))
        executor.shutdown(wait=True)
        return first, alarm.add([])


def test_a_sound_arm_raises_none_and_friction_of_a_joint_its_own(store):
    first, sound = residual_of(store, 1.0)
    assert first.why == "not known yet"
    assert sound.why == ""
    joints = two_joints.model().robot.joints
    assert sound.table(joints)["residual_alarms"] == []
    assert residual_of(store, 1.5)[1].table(joints)["residual_alarms"] == [joints[0]]


def test_limits_are_farther_off_when_alarms_are_to_be_seldom(store):
    expected = expected_of(store, ARM)[1]
    limits = [np.exp(expected.mean), *(expected.limit(rate) for rate in (1e4, 1.0, 0.01))]
    assert np.all(np.diff(limits, axis=0) > 0.0)


def test_an_arm_that_stands_has_no_residual_and_it_is_said_why(store):
    rows = samples(1.0, 1)
    with ThreadPoolExecutor(1) as executor:
        alarm = ResidualAlarm(store, ARM, 1.0, executor)
        alarm.add([rows[0]] * 2000 + rows[-1:])
        executor.shutdown(wait=True)
        found = alarm.add([])
    assert np.all(np.isnan(found.value))
    assert found.why


def test_a_listener_hands_on_every_sample():
    driver = moved(1.0, 0)
    driver.open()
    with Listener(driver) as listener:
        while (reading := listener.look()) is None:
            pass
    assert len(reading.samples) == reading.cycles


def test_watch_shows_the_residual_of_an_arm_by_name(store, capsys):
    arguments = ["watch", "--arm", ARM, "--fleet", str(store.folder), "--seconds", "0.3"]
    assert main([*arguments, "--json", "-"]) == 0
    text = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert text["joints"] == ["shoulder", "elbow"]
    assert np.all(np.array(text["residual_alarm_from"]) > 0.0)
    assert text["residual_alarms"] == []
    assert main(arguments) == 0
    assert "residual: not known yet" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("more", "words"),
    [(["--arm", "welding-08"], f"Arms: {ARM}"), (["--arm", ARM, "--robot", "cobot"], "shoulder, elbow")],
)
def test_an_arm_that_is_not_in_the_fleet_is_refused(more, words, store, capsys):
    assert main(["watch", *more, "--fleet", str(store.folder)]) == REFUSED
    assert words in capsys.readouterr().err
