"""Session: the data that client and controller agree to exchange, their meaning, and samples of them."""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..driver import Info
from ..errors import NotReady
from ..samples import ControllerSamples, word
from ..values import Sample, nanoseconds
from . import rtde
from .dashboard import Dashboard
from .program import Registers, UrSettings, require_cycle
from .rtde import Recipe, RtdeLink

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


MEASURED = (
    "timestamp", "actual_q", "target_q", "actual_qd", "actual_current", "joint_temperatures", "joint_mode",
)  # fmt: skip
"""Requested data, besides the controller's state and the registers."""
NEWER = "3.10 on a CB3, 5.4 on an e-Series, or newer"
"""Software versions that have all of them."""


@dataclass(frozen=True)
class Session:
    """An agreement with a controller."""

    version: str  # version of the controller
    outputs: Recipe  # recipe of the data that it sends
    inputs: Recipe | None  # recipe of the registers that it takes; None if the arm is only read


def agree(link: RtdeLink, settings: UrSettings, registers: Registers, commanding: bool) -> Session:
    """Agree with the controller on all data that the driver needs.

    Raises LinkLost without an answer, NotReady if the answer is invalid, the controller is too old or another
    client uses the registers, BadSettings if the controller does not support the cycle.
    """
    if link.ask(rtde.VERSION, struct.pack(">H", rtde.PROTOCOL)) != b"\x01":
        raise NotReady(
            "driver ur_rtde: the controller does not support version 2 of RTDE: its software is too old. Try "
            f"{NEWER}"
        )
    answer = link.ask(rtde.CONTROLLER)
    try:
        version = ".".join(map(str, struct.unpack(">4I", answer)))
    except struct.error as error:
        raise NotReady(f"driver ur_rtde: the controller's version cannot be read: {answer!r}") from error
    require_cycle(settings.cycle, int(version.split(".")[0]))
    names = [*MEASURED, *FIELDS, registers.session, registers.ended]
    outputs = _recipe(link, rtde.OUTPUTS, names, struct.pack(">d", 1.0 / settings.cycle))
    _require_known(outputs, registers, version)
    if not outputs.accepted:
        raise NotReady(f"driver ur_rtde: the controller refuses to send {', '.join(names)}")
    return Session(version, outputs, _inputs(link, registers, version) if commanding else None)


def _inputs(link: RtdeLink, registers: Registers, version: str) -> Recipe:
    inputs = _recipe(link, rtde.INPUTS, registers.inputs)
    if used := inputs.refused(rtde.IN_USE):
        raise NotReady(
            f"driver ur_rtde: another program writes {', '.join(used)}: end it, or use other registers by "
            f"first_register = {24 - registers.first}"
        )
    _require_known(inputs, registers, version)
    if not inputs.accepted:
        raise NotReady(f"driver ur_rtde: the controller refuses to take {', '.join(registers.inputs)}")
    return inputs


def _recipe(link: RtdeLink, kind: bytes, names: list[str], before: bytes = b"") -> Recipe:
    try:
        return Recipe(names, link.ask(kind, before + ",".join(names).encode()))
    except ValueError as error:
        raise NotReady(f"driver ur_rtde: the controller's answer cannot be read: {error}") from error


def _require_known(recipe: Recipe, registers: Registers, version: str) -> None:
    missing = recipe.refused(rtde.NOT_FOUND)
    lower = registers.first and any("register" in name for name in missing)
    if missing:
        raise NotReady(
            f"driver ur_rtde: version {version} of the controller does not have {', '.join(missing)}. Try "
            f"{NEWER}{'; or first_register = 0' * bool(lower)}"
        )


SIGNALS = ("position", "velocity", "current", "temperature")
SOFT = 0.05
"""Smoothing of servoj above which the monitors of a run may treat its latency as a tracking error [s]."""


def info_of(settings: UrSettings, version: str, record: np.void, dashboard: Dashboard | None) -> Info:
    """Metadata that explain the measurements later, and warnings."""
    warnings = []
    if dashboard is not None and not dashboard.there:
        warnings.append(
            "the dashboard server does not answer: a stop of level OFF cannot switch the arm off, and remote "
            "control cannot be checked"
        )
    if settings.lookahead > SOFT:
        warnings.append(
            f"lookahead is {settings.lookahead:g} s: the arm follows later than that, which `--tracking` may "
            "treat as an error"
        )
    if float(record["speed_scaling"]) < FULL:
        warnings.append(f"the controller scales speed by {float(record['speed_scaling']):.3g}")
    return Info(
        cycle=settings.cycle,
        clock="controller",
        signals=SIGNALS,
        dead_man=f"the program on the controller stops the arm (stopj) after {settings.dead_man:g} s without "
        "a command",
        settings={
            "controller": settings.address,
            "version": version,
            "servoj": f"lookahead {settings.lookahead:g} s, gain {settings.gain:g}",
            "deceleration": f"{settings.deceleration:g} rad/s^2",
            "dead_man": f"{settings.dead_man:g} s",
            "registers": f"from {settings.first_register} on",
            "robot_mode": word(ROBOT_MODE, int(record["robot_mode"])),
            "safety_mode": word(SAFETY_MODE, int(record["safety_mode"])),
            "speed_slider": f"{100 * float(record['target_speed_fraction']):.4g} %",
        },
        warnings=tuple(warnings),
        state=STATE,
    )
