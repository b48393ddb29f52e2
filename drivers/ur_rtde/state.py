"""State that a Universal Robots controller reports, and samples of its data."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..samples import ControllerSamples, word
from ..values import Sample, nanoseconds

ROBOT_MODE = {
    -1: "no controller", 0: "disconnected", 1: "confirm safety", 2: "booting", 3: "power off", 4: "power on",
    5: "idle", 6: "backdrive", 7: "running", 8: "updating firmware",
}  # fmt: skip
SAFETY_MODE = {
    1: "normal", 2: "reduced", 3: "protective stop", 4: "recovery", 5: "safeguard stop",
    6: "system emergency stop", 7: "robot emergency stop", 8: "violation", 9: "fault",
    10: "validate joint id", 11: "undefined",
}  # fmt: skip
PROGRAM = {0: "stopping", 1: "stopped", 2: "playing", 3: "pausing", 4: "paused", 5: "resuming"}
JOINT_MODE = {
    235: "reset", 236: "shutting down", 238: "backdrive", 239: "power off", 240: "ready for power off",
    245: "not responding", 246: "motor initialization", 247: "booting", 249: "bootloader", 251: "violation",
    252: "fault", 253: "running", 255: "idle",
}  # fmt: skip
RUNNING, PLAYING, MOVES = 7, 2, (1, 2)
"""Robot mode, program state and safety modes in which the arm can be moved."""
FULL = 0.9995
"""Position of the speed slider that counts as 100 % [-]."""
TRY = {
    3: "find its cause, then wait five seconds and enable the robot again on the pendant",
    5: "close the safeguard, and reset it",
    6: "release the emergency stop",
    7: "release the emergency stop",
}
"""Safety mode -> what to do; for other modes, the pendant shows it."""

_PARTS: Mapping[str, tuple[str, Mapping[int, str]]] = {
    "robot_mode": ("robot_mode", ROBOT_MODE),
    "safety_mode": ("safety_mode", SAFETY_MODE),
    "program": ("runtime_state", PROGRAM),
    "speed_slider": ("target_speed_fraction", {}),
    "speed_scaling": ("speed_scaling", {}),
}
"""Recorded parts of the controller's state -> name in RTDE, and meanings of its codes."""
STATE = {part: meanings for part, (_, meanings) in _PARTS.items()}
FIELDS = [name for name, _ in _PARTS.values()]
REPORTED = ("robot_mode", "safety_mode", "program")
"""Parts of the state whose changes are events; the others change too often."""


def state_of(record: np.void) -> np.ndarray:
    """State of the controller in a data package, in the order of `STATE`."""
    return np.array([float(record[name]) for name in FIELDS])


def obstacle(record: np.void) -> str:
    """Why the arm cannot be moved at all, with what to try; empty if it can be."""
    safety, mode = int(record["safety_mode"]), int(record["robot_mode"])
    if safety not in MOVES:
        return f"{word(SAFETY_MODE, safety)} (safety mode {safety}): {TRY.get(safety, 'see the pendant')}"
    if mode != RUNNING:
        return (
            f"robot mode is {word(ROBOT_MODE, mode)} ({mode}): switch the arm on and release its brakes on "
            "the pendant"
        )
    return ""


def slowed(record: np.void) -> str:
    """Why the arm would follow commands too slowly; empty if it would not."""
    slider = float(record["target_speed_fraction"])
    if slider >= FULL:
        return ""
    return f"the speed slider is at {100 * slider:.3g} %, where servoj falls behind: set it to 100 %"


def sample_of(samples: ControllerSamples, record: np.void, arrival: int, **fields: Any) -> Sample:
    """Sample of a package that arrived at a host time [ns]; `fields` are further fields of the sample.

    Raises Unreadable if the time stamp of the package is invalid.
    """
    time = nanoseconds("timestamp", float(record["timestamp"]))
    return samples.of(
        time,
        arrival,
        samples.cycles(time),
        samples.lateness(arrival, time),
        position=record["actual_q"].astype(float),
        velocity=record["actual_qd"].astype(float),
        current=record["actual_current"].astype(float),
        temperature=record["joint_temperatures"].astype(float),
        **fields,
    )
