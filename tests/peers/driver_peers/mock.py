"""The simulated arm needs no process."""

from contextlib import contextmanager

from . import DriverPeer


@contextmanager
def running(folder):
    yield None, {"clock": "real", "cycle": 0.01, "dead_man": 2.0}


PEER = DriverPeer(running, states="simulated", cobot=None)
