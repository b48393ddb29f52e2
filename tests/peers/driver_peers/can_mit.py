"""Motors with the MIT frame."""

from contextlib import contextmanager

from ...parts.controllers.can_peers import late_answers_count, peer
from ..can_arm import mit_settings
from . import DriverPeer


@contextmanager
def running(folder, *arguments):
    with late_answers_count(), peer("mit_motors.py", "--cycle", 0.01, *arguments) as process:
        yield process, mit_settings(process.address) | {"cycle": 0.01}


PEER = DriverPeer(running, states="off", powered=(": on,", "ordered to store"))
