"""A Franka controller by franky-sim's server, where it and the maker's library are installed."""

import importlib.util
from contextlib import contextmanager

import pytest

from ...peers.peer_process import Peer

PACKAGES = ("pylibfranka", "franky_sim")
MISSING = [name for name in PACKAGES if importlib.util.find_spec(name) is None]
REASON = f"not installed: {', '.join(MISSING)}; pip install '.[franka-sim]'"
INSTALLED = pytest.mark.skipif(bool(MISSING), reason=REASON)
BUFFER = 0.2
"""Of commands, for machines that are busy with other things [s]."""


@contextmanager
def running(*arguments, patience=2000):
    """Its process, and settings that reach it."""
    if MISSING:
        pytest.skip(REASON)
    with Peer("franka_controller.py", "--patience", patience, *arguments, shared=False) as peer:
        yield peer, {"address": peer.address, "buffer": BUFFER, "wait": 60.0}
