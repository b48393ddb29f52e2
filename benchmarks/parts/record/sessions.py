"""Floors of drivers whose controller has the clock: the barest programs that answer or take what it sends.

Each is a session with the same controller as the driver's, in real time on the loop's processor, with the arm
held where it stands. What comes late is then the controller's, the network's and this machine's; the driver
adds the rest. Run as a module with an address and seconds, it is that of an FCI, in a process of its own
since its library may end it.
"""

import json
import os
import re
import socket
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.acquire.run.realtime import realtime
from exidyn.drivers.franka.target_stream import CYCLE

from .controllers import Peer, controller, krc, rsi_config
from .floor import move_away, on_the_loops

ANSWER = (
    b'<Sen Type="ImFree"><AK A1="0" A2="0" A3="0" A4="0" A5="0" A6="0"/><Stop>0</Stop><IPOC>%s</IPOC></Sen>'
)


def report(peer: Peer) -> dict[str, Any]:
    """What the controller counted in a session; it is ended with that."""
    peer.close()
    return json.loads(peer.lines[-1])


def latencies(report: dict[str, Any]) -> np.ndarray:
    """Time from each telegram to its answer as the controller measures it, shape (t,) [s]."""
    return 1e-6 * np.array(report["latencies_us"])


def echo(seconds: float) -> tuple[np.ndarray, int]:
    """Latencies where the fewest lines of Python answer each telegram, and answers that came too late.

    In real time and on the processor of our loop, with the arm held where it stands.
    """
    with tempfile.TemporaryDirectory() as folder:
        counted = _session(rsi_config(Path(folder)), seconds)
    return latencies(counted), counted["late"]


def _session(config: Path, seconds: float) -> dict[str, Any]:
    """What the controller counts."""
    address = "127.0.0.1", int(re.findall(r"<PORT>(\d+)", config.read_text())[0])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link, krc(config) as peer:
        link.bind(address)
        move_away(peer.process.pid)
        with on_the_loops(), realtime():
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                data, sender = link.recvfrom(65535)
                link.sendto(ANSWER % data[data.rindex(b"<IPOC>") + 6 : data.rindex(b"</IPOC>")], sender)
        return report(peer)


HEAD = struct.Struct(">Hc")
"""Size and kind of a package of RTDE."""
STAMPED = struct.Struct(">HcBd")
"""A whole package with a recipe's number and a time stamp [s]."""

FIRST = 5
"""One part in so many of a session is the first."""


def rtde(seconds: float) -> tuple[np.ndarray, int]:
    """Lateness of each package of a Universal Robots controller, shape (t,) [s]; how many missed a cycle."""
    with (
        tempfile.TemporaryDirectory() as folder,
        controller("ur_rtde", Path(folder)) as (driver, peer),
        on_the_loops(),
    ):
        move_away(peer.process.pid)
        given = driver.settings
        with socket.create_connection((given.address, given.rtde_port), 10.0) as link, realtime():
            link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            for kind, body in (
                (b"V", struct.pack(">H", 2)),
                (b"O", struct.pack(">d", 1.0 / given.cycle) + b"timestamp"),
                (b"S", b""),
            ):
                link.sendall(HEAD.pack(HEAD.size + len(body), kind) + body)
                link.recv(4096)
            return late(_packages(link, time.monotonic() + seconds), given.cycle)


def _packages(link: socket.socket, end: float) -> list[float]:
    """Time from each package's stamp to its arrival, from any zero [s]."""
    behind = []
    while (now := time.monotonic()) < end:
        data = link.recv(STAMPED.size)
        now = time.monotonic()
        behind.append(now - STAMPED.unpack(data)[3])
    return behind


def fci(seconds: float) -> tuple[np.ndarray, int]:
    """Lateness of each state of a Franka controller, shape (t,) [s], and how many missed a cycle."""
    with (
        tempfile.TemporaryDirectory() as folder,
        controller("franka", Path(folder)) as (driver, peer),
        on_the_loops(),
    ):
        move_away(peer.process.pid)
        command = [sys.executable, "-P", "-m", __name__, driver.settings.address, str(seconds)]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
        done = subprocess.run(command, stdout=subprocess.PIPE, env=environment, check=True)
        return late(np.frombuffer(done.stdout).tolist(), CYCLE)


def _states(address: str, seconds: float) -> None:
    """As `_packages`, on standard output."""
    import pylibfranka

    robot = pylibfranka.Robot(address, pylibfranka.RealtimeConfig.kIgnore)
    behind = []
    with realtime():
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            state = robot.read_once()
            behind.append(time.monotonic() - state.time.to_sec())
    sys.stdout.buffer.write(np.array(behind).tobytes())


def late(behind: list[float], cycle: float) -> tuple[np.ndarray, int]:
    """By how much each came later after its stamp than the quickest, shape (t,) [s]; how many by a cycle.

    The first are left out: a peer stands still for a while when a client connects, clock and all.
    """
    settled = np.array(behind[len(behind) // FIRST :])
    settled -= settled.min()
    return settled, int(np.sum(settled > cycle))


if __name__ == "__main__":
    _states(sys.argv[1], float(sys.argv[2]))
