"""CiA 402 drives."""

from contextlib import contextmanager

from ...parts.controllers.can_peers import late_answers_count, peer
from ..can_arm import canopen_settings
from . import DriverPeer


@contextmanager
def running(folder, *arguments):
    with late_answers_count(), peer("can_nodes.py", *arguments) as process:
        yield process, canopen_settings(process.address) | {"cycle": 0.01}


PEER = DriverPeer(running, states="switch-on disabled", powered=(": ready", ": switched on", ": enabled"))
