"""A command that is killed leaves no process behind: no server, no worker."""

import signal
import socket
import sys

import pytest

from exidyn.identification.robot_files.robot_file import model_text

from ...parts.descendants import started, within
from ...parts.pages.browser import free_port
from ...parts.small import two_joints
from ...parts.small.two_joint_files import run, write

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")

EXIDYN = ["-m", "exidyn.acquire.command_line"]
PATIENCE = 120.0
"""Of a busy machine, until processes have started or ended [s]."""


def listening(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), 1.0).close()
    except OSError:
        return False
    return True


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGHUP])
def test_the_server_of_a_view_ends_with_it(tmp_path, how):
    [path] = write(tmp_path, run("run"))
    port = free_port()
    with started([*EXIDYN, "view", path, "--serve", f"127.0.0.1:{port}"]) as view:
        assert b"view: http" in view.process.stderr.readline()
        assert listening(port)
        assert len(view.alive()) == 2
        view.process.send_signal(how)
        view.process.wait(PATIENCE)
        assert within(PATIENCE, lambda: not view.alive())
        assert within(PATIENCE, lambda: not listening(port) and not listening(port + 1))


def test_the_workers_of_a_search_end_with_it(tmp_path):
    (tmp_path / "robot.toml").write_text(model_text(two_joints.model()))
    output = ["-o", str(tmp_path / "trajectory.toml"), "--search", "600"]
    command = [*EXIDYN, "excite", str(tmp_path / "robot.toml"), *output]
    with started(command, OMP_NUM_THREADS="1") as killed:
        # two workers, the command itself, and Python's process that tracks resources
        assert within(PATIENCE, lambda: len(killed.alive()) >= 4), killed.alive()
        killed.process.kill()
        killed.process.wait(PATIENCE)
        assert within(PATIENCE, lambda: not killed.alive())
