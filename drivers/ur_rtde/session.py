"""Session: agreement of client and controller on the data that they exchange."""

import struct
from dataclasses import dataclass

import numpy as np

from ..driver import Info
from ..errors import NotReady
from ..samples import word
from . import rtde
from .dashboard import Dashboard
from .program import Registers, UrSettings, require_cycle
from .rtde import Recipe, RtdeLink
from .state import FIELDS, FULL, ROBOT_MODE, SAFETY_MODE, STATE

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
    version = _version(link.ask(rtde.CONTROLLER))
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


def _version(answer: bytes) -> str:
    try:
        return ".".join(map(str, struct.unpack(">4I", answer)))
    except struct.error as error:
        raise NotReady(f"driver ur_rtde: the controller's version cannot be read: {answer!r}") from error


def start(link: RtdeLink) -> None:
    """Start the data. Raises NotReady if the controller refuses."""
    if link.ask(rtde.START) != b"\x01":
        raise NotReady("driver ur_rtde: the controller refuses to send data. Try restarting it")


def pause(link: RtdeLink) -> None:
    """Pause the data until the next start, because unread data fill the controller's buffers."""
    link.ask(rtde.PAUSE)


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
