"""A Universal Robots controller."""

from contextlib import contextmanager

from ..peer_process import Peer
from ..ur_settings import ur_settings
from . import DriverPeer


@contextmanager
def running(folder, *arguments):
    with Peer("ur_controller.py", "--robot", "obedient", "--series", "cb3", *arguments) as process:
        yield process, ur_settings(process.address) | {"cycle": 0.008, "dead_man": 2.0}


PEER = DriverPeer(
    running, states="running", powered=("program",), hasty={"wait": 0.2}, cobot=("--robot", "cobot")
)
