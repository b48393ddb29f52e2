"""Messages between the driver and its process: a byte for the kind, then a record or a text."""

from typing import Any

import numpy as np

from .fci_limits import JOINTS
from .modes import STATE

ASK, FLOW, TARGET, STOP, OFF = b"A", b"F", b"C", b"Q", b"O"
"""To the process: send one state; send all from now on; a command, seven float64 [rad]; stop the arm; end the
motion at once, whatever the arm does."""
READY, SEEN, FAULT, FATAL = b"R", b"S", b"X", b"E"
"""From it: connected, with the library's version; a state; why commands are not taken any more; why it has
ended."""

IDLE, FOLLOWING, STOPPING, ENDED = range(4)
"""Of the motion, in a state."""

RECORD = np.dtype(
    [
        ("time", "<i8"),  # of the controller [ns]
        ("arrival", "<i8"),  # monotonic clock of this computer [ns]
        ("q", "<f8", JOINTS),
        ("dq", "<f8", JOINTS),
        ("q_d", "<f8", JOINTS),
        ("tau_J", "<f8", JOINTS),
        ("state", "<f8", len(STATE)),
        ("motion", "<i8"),
    ]
)
"""A state of the controller: what libfranka's `RobotState` calls them, in radians and newton metres; `state`
has the names of `STATE`."""
VECTORS = ("q", "dq", "q_d", "tau_J")


def target(position: np.ndarray) -> bytes:
    """A command, shape (7,) [rad]."""
    return TARGET + np.asarray(position, "<f8").tobytes()


def read_target(body: bytes) -> np.ndarray:
    """Its position, shape (7,) [rad]."""
    return np.frombuffer(body, "<f8", JOINTS)


def record(**fields: Any) -> bytes:
    """A state as a message."""
    one = np.zeros(1, RECORD)
    for name, value in fields.items():
        one[name] = value
    return SEEN + one.tobytes()


def read_record(body: bytes) -> np.void:
    """A state.

    Raises:
        ValueError: It is none.
    """
    found: np.void = np.frombuffer(body, RECORD)[0]
    return found
