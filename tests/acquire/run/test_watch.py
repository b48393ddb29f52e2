"""What `exidyn watch` shows, on the mock and on peers that report that no drive is on."""

import json
import os
import pty
import select
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, STOPPED, main
from exidyn.acquire.commands import watch_command
from exidyn.acquire.run.listener import Listener, Reading
from exidyn.acquire.terminal.watch_text import JointUnits, json_line, line, table_lines
from exidyn.drivers import Arm, Info
from exidyn.drivers.errors import LinkLost
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.controllers.can_peers import peer as can_peer
from ...parts.runs.commissioning_parts import CELLS, controller_file
from ...parts.runs.full_run import model as sliding_model
from ...parts.runs.run_parts import ROBOT, Following
from ...parts.system_needs import TERMINALS
from ...peers.can_arm import mit_settings
from ...peers.driver_peers import peer_of

pytestmark = pytest.mark.clocked

SHORT = ["--length", "1.0"]
"""Long enough for a few answers from a peer whose process has to wait on a busy machine."""


def readings(capsys):
    return [json.loads(one) for one in capsys.readouterr().out.splitlines()]


@pytest.mark.parametrize("name", CELLS)
def test_positions_are_there_and_no_drive_is_on(name, tmp_path, capsys):
    with CELLS[name](tmp_path) as (peer, path):
        arguments = ["--controller", str(path), "--robot", "cobot", "--json", "-", *SHORT]
        assert main(["watch", *arguments]) == 0
        text = readings(capsys)
        assert peer_of(name).off(peer)
    np.testing.assert_allclose(text[-1]["position"], np.radians(peer_of(name).pose), atol=2e-3)
    assert text[-1]["joints"] == list(ROBOT.joints)
    assert text[-1]["fault"] == ""
    assert text[-1]["beyond_limits"] == []
    assert any(None not in text[-1][measured] for measured in ("current", "torque"))
    assert text[-1]["states"] == [peer_of(name).states] * 6


def test_a_controller_that_falls_silent_is_reported_in_a_line(tmp_path, capsys):
    with CELLS["canopen_402"](tmp_path) as (peer, path):
        peer.process.kill()
        assert main(["watch", "--controller", str(path), "--robot", "cobot"]) == REFUSED
    assert "does not answer" in capsys.readouterr().err


class Ending(Following):
    """Answers a few times."""

    error = LinkLost("gone")

    def exchange(self, command):
        if self.number > 5:
            raise self.error
        return super().exchange(command)


@pytest.mark.parametrize("error", [LinkLost("gone"), ZeroDivisionError("gone")])
def test_what_was_heard_before_the_end_is_shown_and_then_why_it_ended(error):
    driver = Ending()
    driver.error = error
    driver.arm = Arm(
        ROBOT.joints, ROBOT.limits.position_lower, ROBOT.limits.position_upper, ROBOT.limits.velocity
    )
    with Listener(driver) as listener:
        listener._thread.join()
        assert listener.look().cycles == 6
        with pytest.raises(type(error), match="gone"):
            listener.look()


def test_without_a_terminal_it_is_a_line_a_reading(capsys):
    assert main(["watch", "--robot", "cobot", "--length", "2.0"]) == 0
    printed = capsys.readouterr()
    lines = printed.out.splitlines()
    assert len(lines) >= 2
    assert all("position -72.00 -126.00 -64.00 -72.00 -72.00 -72.00 deg" in one for one in lines)
    assert "\x1b" not in printed.out
    assert "read only; sent to it: nothing" in printed.err


def test_the_mock_keeps_real_time_whatever_its_file_says(tmp_path):
    path = controller_file(tmp_path, "mock", {"clock": "stepped", "cycle": 0.01})
    given = watch_command.watch_command.parser().parse_args(["--controller", str(path), "--robot", "cobot"])
    driver, _ = watch_command._driver(given, read_model("cobot"))
    assert driver.in_real_time


def test_json_goes_to_a_file_line_by_line(tmp_path, capsys):
    path = tmp_path / "watched.json"
    assert main(["watch", "--robot", "cobot", "--json", str(path), *SHORT]) == 0
    text = [json.loads(one) for one in path.read_text().splitlines()]
    assert len(text) == len(capsys.readouterr().out.splitlines())
    assert text[0]["exidyn_reading"] == 1
    assert text[0]["position"][0] == pytest.approx(np.radians(-72.0), abs=1e-4)


def test_without_a_robot_positions_are_radians(tmp_path, capsys):
    with CELLS["dynamixel"](tmp_path) as (_, path):
        assert main(["watch", "--controller", str(path), *SHORT]) == 0
    out = capsys.readouterr().out
    assert "rad; current" in out
    assert "-1.57" in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "driver mock: the settings list no joints"),
        ([], "Name the arm with --robot, and its controller with --controller"),
        (["--controller", "none.toml"], "none.toml"),
        (["--robot", "nothing"], "nothing"),
        (["--driver", "nothing"], "nothing"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(arguments, words, capsys):
    assert main(["watch", *arguments]) == REFUSED
    printed = capsys.readouterr().err
    assert words in printed
    assert len(printed.splitlines()) == 1


def test_motors_that_reading_makes_limp_are_not_read_unasked(tmp_path, capsys, monkeypatch):
    with can_peer("mit_motors.py", "--robot", "obedient", "--maker", "t-motor") as peer:
        path = controller_file(tmp_path, "can_mit", mit_settings(peer.address, maker="t-motor"))
        monkeypatch.setattr("builtins.input", lambda: "no")
        assert main(["watch", "--controller", str(path), *SHORT]) == STOPPED
        text = capsys.readouterr()
        assert "goes limp" in text.err
        assert "nothing was sent" in text.err
        monkeypatch.setattr("builtins.input", lambda: "yes")
        assert main(["watch", "--controller", str(path), *SHORT]) == 0


def test_a_terminal_has_a_table_in_place_until_ctrl_c():
    TERMINALS.require()
    leader, follower = pty.openpty()
    command = [sys.executable, "-m", "exidyn.acquire.command_line", "watch", "--robot", "cobot"]
    with subprocess.Popen(
        command, stdin=follower, stdout=follower, stderr=subprocess.PIPE, start_new_session=True,
        preexec_fn=lambda: __import__("fcntl").ioctl(0, __import__("termios").TIOCSCTTY, 0),
    ) as process:  # fmt: skip
        os.close(follower)
        seen = b""
        while seen.count(b"\x1b[J") < 3 and select.select([leader], [], [], 60.0)[0]:
            seen += os.read(leader, 4096)
        os.write(leader, b"\x03")
        while select.select([leader], [], [], 20.0)[0]:  # a terminal that is full holds up who writes to it
            try:
                os.read(leader, 4096)
            except OSError:
                break
        assert process.wait(60.0) == 0
        assert b"interrupted" not in process.stderr.read()
    os.close(leader)
    text = seen.decode()
    assert "joint3    -64.00  deg  -160.0 to 160.0" in text
    assert "\x1b[9A\x1b[J" in text


def reading(**changed):
    n = 3
    values = {
        "host_time": 10**18,
        "position": np.array([0.1, np.nan, 0.5]),
        "velocity": np.full(n, np.nan),
        "current": np.array([0.5, np.nan, -1.0]),
        "torque": np.full(n, np.nan),
        "temperature": np.full(n, np.nan),
        "states": ("off", "off", "on"),
        "cycles": 10,
        "silent": np.array([0, 10, 0]),
        "events": ("a sentence",),
        "fault": "",
    }
    return Reading(**values | changed)


UNITS = JointUnits.of(sliding_model().robot)
INFO = Info(cycle=0.01, clock="host", signals=("position", "current"))


def test_what_is_beyond_limits_or_silent_is_marked():
    far = reading(position=np.array([4.1, np.nan, -4.001]))
    rows = table_lines(far, UNITS, INFO, 1.0, ["output before"])
    assert rows[1].split()[1:4] == ["234.91", "deg", "BEYOND"]
    assert rows[2].split()[-1] == "silent"
    assert rows[3].split()[1:4] == ["-4001.00", "mm", "BEYOND"]
    assert rows[-1] == "message: output before"
    text = line(far, UNITS, INFO, 1.0)
    assert "BEYOND limits: achse_1, achse_3; silent: achse_2" in text
    assert "deg/deg/mm" in text
    assert json.loads(json_line(far, UNITS, 1.0))["beyond_limits"] == ["achse_1", "achse_3"]


def test_what_rounds_to_zero_has_no_sign():
    near = np.array([-1e-5, 0.0, -1e-7])
    assert [UNITS.text(near, joint) for joint in (0, 2)] == ["0.00 deg", "0.00 mm"]
    tight = replace(UNITS, lower=-near, upper=near)
    assert tight.range_text(0) == "0.0 to 0.0"


def test_what_is_not_known_is_null_and_a_dash():
    content = json.loads(json_line(reading(fault="tripped"), UNITS, 1.0))
    assert content["position"] == [0.1, None, 0.5]
    assert content["torque"] == [None, None, None]
    text = line(reading(fault="tripped"), UNITS, INFO, 1.0)
    assert "position 5.73 - 500.00" in text
    assert "torque" not in text
    assert text.endswith("fault: tripped; message: a sentence")
