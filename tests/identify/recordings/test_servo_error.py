"""Logs of position servos without current: their error takes its place, unless the commands are none."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.robot import PositionServo
from exidyn.identification.errors import RecordingError, RobotError, WrongShape
from exidyn.identification.in_mujoco.replay import Run
from exidyn.identification.measurements import TimeDelay
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.recordings.servo_error import (
    LAW,
    delayed_command,
    no_commands,
    servo_words,
    with_servo_error,
)
from exidyn.identification.recordings.tables.written import columns_of
from exidyn.identification.robot_files.robot_file import model_text, parse_model

from ...parts.runs.runs import require
from ...parts.small.two_joint_files import NOMINAL


def test_what_is_left_to_the_command_stands_for_the_current(tmp_path):
    rows = [f"{0.01 * k},{0.1 * k},{-0.1 * k},{0.1 * k + 0.02},{-0.1 * k - 0.5}" for k in range(100)]
    log = tmp_path / "log.csv"
    log.write_text("t,q1,q2,q_ref1,q_ref2\n" + "\n".join(rows) + "\n")
    with pytest.raises(
        WrongShape, match=r"needs position and one of .*\. Of position servos, --effort command"
    ):
        import_source(log, NOMINAL)
    [run] = import_source(log, NOMINAL, effort="command", servo_gain=10.0, servo_limit=3.0)
    require(run, current=np.tile([0.2, -3.0], (100, 1)), atol=1e-12)
    assert "command" in run.signals
    assert run.settings["effort"] == "servo error [rad] x 10, at most 3"


def test_commands_come_at_their_own_times_and_are_needed():
    position = Signal(np.arange(4.0), np.zeros((4, 1)))
    command = Signal(np.array([0.0, 2.0]), np.array([[0.0], [1.0]]))
    servo = PositionServo(np.ones(1), np.full(1, np.inf))
    found = with_servo_error({"position": position, "command": command}, servo, "log")
    assert found["current"].values[:, 0].tolist() == [0.0, 0.5, 1.0, 1.0]
    with pytest.raises(RecordingError, match="log has no commanded position, which --effort command needs"):
        with_servo_error({"position": position}, servo, "log")
    with pytest.raises(RecordingError, match="log: commands are the positions"):
        with_servo_error({"position": position, "command": position}, servo, "log")


def servo_arm():
    """The two-joint arm, its drives position servos as a file has them."""
    text = model_text(NOMINAL).replace("[drive]\n", "[drive]\nservo_gain = 2.0\nservo_limit = [0.3, inf]\n")
    model = parse_model(text)
    assert "servo_limit = [0.3, inf]" in model_text(model)
    assert model_text(parse_model(model_text(model))) == model_text(model)
    return model


def follower(seconds=4.0):
    """A log of an arm that stays behind its commands by 0.1 and 0.2 rad."""
    time = np.arange(0.0, seconds, 0.01)
    position = np.stack([np.sin(2.0 * time), np.cos(3.0 * time)], axis=1)
    return Signal(time, position), Signal(time, position + [0.1, 0.2])


def test_the_robots_file_says_that_drives_are_servos(tmp_path):
    position, command = follower()
    rows = np.column_stack([position.time, position.values, command.values])
    log = tmp_path / "log.csv"
    np.savetxt(log, rows, delimiter=",", header="t,q1,q2,q_ref1,q_ref2", comments="")
    [run] = import_source(log, servo_arm())
    require(run, current=np.tile([0.2, 0.4], (400, 1)), atol=1e-12)
    assert run.settings["effort"] == "servo error [rad] x 2, at most 0.3, inf"
    [stiff] = import_source(log, servo_arm(), servo_gain=8.0)
    require(stiff, current=np.tile([0.3, 1.6], (400, 1)), atol=1e-12)


def test_a_recorded_run_without_current_is_read_by_them_and_exported_as_it_was(tmp_path):
    position, command = follower()
    unmeasured = Signal(position.time, np.full((400, 2), np.nan))
    signals = {"position": position, "command": command, "current": unmeasured}
    path = tmp_path / "run.mcap"
    write_recording(Recording("run", servo_arm(), signals), path)
    run = read_recording(path)
    require(run, current=np.tile([0.2, 0.4], (400, 1)), atol=1e-9)
    assert "i1" not in columns_of(run)
    # A real current is left alone.
    write_recording(Recording("run", servo_arm(), signals | {"current": command}), path)
    assert read_recording(path).signals["current"].values.tolist() == command.values.tolist()


def test_commands_that_come_earlier_change_the_error(tmp_path):
    position, _ = follower()
    later = Signal(position.time + 0.02, position.values)  # each command acts two samples later
    sent = [np.interp(position.time, later.time, one) for one in later.values.T]
    command = Signal(position.time, np.stack(sent, axis=1))
    signals = with_servo_error({"position": position, "command": command}, servo_arm().robot.servo, "log")
    settings = {"effort": servo_words(servo_arm().robot.servo)}
    run = Recording("run", servo_arm(), signals, settings=settings)
    found = delayed_command(run, np.full(2, -0.02))
    assert np.abs(run.signals["current"].values[50:-50]).max() > 0.05
    assert np.abs(found.signals["current"].values[50:-50]).max() < 1e-9
    assert delayed_command(Recording("run", servo_arm(), signals), np.full(2, -0.02)) is None


def test_a_replay_gives_commands_when_the_servos_received_them():
    position, _ = follower()
    sent = Signal(position.time, position.values + [0.1, 0.2])
    arm = servo_arm()
    delayed = replace(arm, measurements=(TimeDelay(-0.03),))  # commands are stamped 0.03 s before they act
    signals = with_servo_error({"position": position, "command": sent}, arm.robot.servo, "log")
    settings = {LAW: servo_words(arm.robot.servo)}
    at_once, later = (
        Run.of(Recording("run", model, signals, settings=settings), Filtering()).command
        for model in (arm, delayed)
    )
    time = Run.of(Recording("run", arm, signals, settings=settings), Filtering()).time
    inner = slice(50, -50)
    expected = np.stack([np.sin(2.0 * (time - 0.03)) + 0.1, np.cos(3.0 * (time - 0.03)) + 0.2], axis=1)
    np.testing.assert_allclose(later[inner], expected[inner], atol=1e-3)
    assert np.abs(at_once - expected)[inner].max() > 0.02


@pytest.mark.parametrize(
    ("keys", "words"),
    [("servo_limit = 0.2", "give servo_gain too"), ("servo_gain = 0.0", "servo_gain: .* has a zero")],
)
def test_wrong_servos_are_refused(keys, words):
    with pytest.raises(RobotError, match=words):
        parse_model(model_text(NOMINAL).replace("[drive]\n", f"[drive]\n{keys}\n"))


TIME = np.arange(0.0, 10.0, 0.02)
POSITION = np.round(np.stack([np.sin(1.7 * TIME), np.cos(2.9 * TIME)], axis=1), 4)


@pytest.mark.parametrize("samples", [0, 1, 2, 10])
def test_copied_positions_are_no_commands(samples):
    copied = POSITION[np.minimum(np.arange(len(TIME)) + samples, len(TIME) - 1)]
    words = {0: "are the positions:", 1: "of the next sample"}.get(samples, f"{samples} samples later")
    assert words in no_commands(copied, POSITION)


def test_steps_are_no_commands():
    steps = np.diff(POSITION, axis=0, append=POSITION[-1:])
    assert "look like steps" in no_commands(steps, POSITION)
    assert "look like steps" in no_commands(50.0 * steps, POSITION)


@pytest.mark.parametrize("error", [1e-3, 0.1])
def test_commands_that_a_servo_follows_are_commands(error):
    ahead = np.stack([np.sin(1.7 * (TIME + 0.02)), np.cos(2.9 * (TIME + 0.02))], axis=1)
    assert not no_commands(ahead + error * np.sin(7.0 * TIME)[:, None], POSITION)
