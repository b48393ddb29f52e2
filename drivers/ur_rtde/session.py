"""Session: what client and controller agree on before data come, or what they do not."""

import struct
from dataclasses import dataclass

from ..errors import NotReady
from .modes import FIELDS
from .program import Registers
from .rtde_link import RtdeLink
from .rtde_packets import (
    CONTROLLER,
    IN_USE,
    INPUTS,
    NOT_FOUND,
    OUTPUTS,
    PAUSE,
    PROTOCOL,
    START,
    VERSION,
    Recipe,
)
from .ur_settings import UrSettings, require_cycle

MEASURED = (
    "timestamp", "actual_q", "target_q", "actual_qd", "actual_current", "joint_temperatures", "joint_mode",
)  # fmt: skip
"""What is asked for beside the controller's state and the registers."""
NEWER = "3.10 on a CB3, 5.4 on an e-Series, or newer"
"""Software that has all of it."""


@dataclass(frozen=True)
class Session:
    """What was agreed on.

    Attributes:
        version: Of the controller, such as "5.12.4.1101".
        outputs: Recipe of what it sends.
        inputs: Recipe of the registers that it takes; None where the arm is only read.
    """

    version: str
    outputs: Recipe
    inputs: Recipe | None


def agree(link: RtdeLink, settings: UrSettings, registers: Registers, commanding: bool) -> Session:
    """Ask for all that the driver needs.

    Raises:
        LinkLost: No answer, or one that makes no sense.
        NotReady: The controller is too old, or the registers are another's.
        BadSettings: It does not keep such cycles.
    """
    if link.ask(VERSION, struct.pack(">H", PROTOCOL)) != b"\x01":
        raise NotReady(
            "driver ur_rtde: the controller does not know version 2 of RTDE: its software is too old. Try "
            f"{NEWER}"
        )
    version = _version(link.ask(CONTROLLER))
    require_cycle(settings.cycle, int(version.split(".")[0]))
    names = [*MEASURED, *FIELDS.values(), registers.session, registers.ended]
    outputs = _recipe(link, OUTPUTS, names, struct.pack(">d", 1.0 / settings.cycle))
    _require_known(outputs, registers, version)
    if not outputs.accepted:
        raise NotReady(f"driver ur_rtde: the controller refuses to send {', '.join(names)}")
    return Session(version, outputs, _inputs(link, registers, version) if commanding else None)


def _inputs(link: RtdeLink, registers: Registers, version: str) -> Recipe:
    inputs = _recipe(link, INPUTS, registers.inputs)
    if used := inputs.refused(IN_USE):
        raise NotReady(
            f"driver ur_rtde: another program writes {', '.join(used)}: end it, or take other registers by "
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
    missing = recipe.refused(NOT_FOUND)
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
    """Let data come.

    Raises:
        NotReady: The controller refuses.
    """
    if link.ask(START) != b"\x01":
        raise NotReady("driver ur_rtde: the controller refuses to send data. Try restarting it")


def pause(link: RtdeLink) -> None:
    """Let none come until the next start: what nobody takes fills the controller's buffers."""
    link.ask(PAUSE)
