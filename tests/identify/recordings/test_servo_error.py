"""Logs of position servos without current: their error takes its place."""

import os
from pathlib import Path

import numpy as np
import pytest

from exidyn.identify.arm.robot import PositionServo
from exidyn.identify.errors import RecordingError, WrongShape
from exidyn.identify.fit.identification import identify
from exidyn.identify.recordings.importers import import_source
from exidyn.identify.recordings.recording import Signal
from exidyn.identify.recordings.servo_error import with_servo_error
from exidyn.identify.robot_files.robot_file import read_model

from ...parts.small.two_joint_files import NOMINAL

BAM = Path(os.environ.get("EXIDYN_DATA", "../shared/data")) / "bam_xl330"


def test_what_is_left_to_the_command_stands_for_the_current(tmp_path):
    rows = [f"{0.01 * k},{0.1 * k},{-0.1 * k},{0.1 * k + 0.02},{-0.1 * k - 0.5}" for k in range(100)]
    log = tmp_path / "log.csv"
    log.write_text("t,q1,q2,q_ref1,q_ref2\n" + "\n".join(rows) + "\n")
    with pytest.raises(
        WrongShape, match=r"needs position and one of .*\. Of position servos, --effort command"
    ):
        import_source(log, NOMINAL)
    [run] = import_source(log, NOMINAL, effort="command", servo_gain=10.0, servo_limit=3.0)
    np.testing.assert_allclose(run.signals["current"].values, np.tile([0.2, -3.0], (100, 1)), atol=1e-12)
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


@pytest.mark.slow
@pytest.mark.skipif(not BAM.exists(), reason=f"no {BAM}")
def test_commands_alone_give_the_model_that_duty_gives():
    """The servo's law is duty = kp / 256 x error in counts, 4096 a turn, of which 885 are all."""
    model, by_duty, by_command = read_model(BAM / "robot.toml"), [], []
    for kp in (100, 200, 400):
        log, counts = BAM / f"kp{kp}_sin_sin.csv.gz", kp / 256.0 * 4096.0 / (2.0 * np.pi)
        by_duty += import_source(log, model)
        by_command += import_source(log, model, effort="command", servo_gain=counts, servo_limit=885.0)
    duty, command = identify(by_duty), identify(by_command)
    assert duty.names == command.names
    np.testing.assert_allclose(command.estimate.values, duty.estimate.values, rtol=0.02)
