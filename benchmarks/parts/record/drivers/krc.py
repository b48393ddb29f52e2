"""How soon the KUKA controller's telegrams are answered: by the driver, and by the barest echo."""

import json
import re
import socket
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.acquire.run.realtime import realtime

from ..controllers import Peer, krc, rsi_config
from .processors import move_away, on_the_loops

ANSWER = (
    b'<Sen Type="ImFree"><AK A1="0" A2="0" A3="0" A4="0" A5="0" A6="0"/><Stop>0</Stop><IPOC>%s</IPOC></Sen>'
)


def report(peer: Peer) -> dict[str, Any]:
    """What the controller counted in a session; it is ended with that."""
    peer.close()
    return json.loads(peer.lines[-1])


def timeouts(report: dict[str, Any]) -> int:
    """Whether it stopped because too many answers were missing."""
    return int("RSITimeout" in report["stopped"])


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
