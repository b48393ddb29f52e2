"""All drives of an arm over `canopen`: set-up, start, and error codes."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, NamedTuple, cast

import canopen
from canopen.sdo import SdoClient

from ..can.can_bus import CanBus
from ..can.transports import STANDARD
from ..driver import Arm
from ..errors import DriverError, LinkLost, NotReady
from . import cia402 as c
from .drive import Drive, Effort, effort_kind, find_effort
from .settings import CanopenSettings
from .setup import DriveData, inspect, require_not_enabled, set_up

ANSWER = 0.3
"""Maximum time to wait for an answer [s]."""
UNREAD = 500
"""Maximum number of frames read before a question: more are a flood, and can wait."""


class SetUp(NamedTuple):
    """Drives of an arm after set-up."""

    kind: str  # effort that all drives measure, "current" or "torque"
    efforts: list[Effort]  # object of each drive that measures it
    drives: list[DriveData]  # data of each drive
    warnings: list[str]  # warnings that concern the whole arm, a sentence each


class Questions(SdoClient):
    """An SDO client that reads the bus while it waits for an answer, in place of a thread of canopen."""

    RESPONSE_TIMEOUT = 0.0  # `network` waits before the response is read

    def __init__(self, node: canopen.RemoteNode, network: "DriveNetwork") -> None:
        super().__init__(node.sdo.rx_cobid, node.sdo.tx_cobid, node.object_dictionary)
        self._drives = network

    def request_response(self, sdo_request: bytes) -> bytes:
        self._drives.read_late_frames()  # among them may be the answer to an earlier question
        return cast(bytes, super().request_response(sdo_request))

    def read_response(self) -> bytes:
        self._drives.read_until(lambda: not self.responses.empty(), ANSWER)
        return cast(bytes, super().read_response())


class DriveNetwork:
    """The drives, through their SDO servers; the bus is read only while a method waits."""

    def __init__(self, bus: CanBus, settings: CanopenSettings, names: Sequence[str]) -> None:
        self._bus, self._settings, self._names = bus, settings, names
        self._network = canopen.Network(cast(Any, bus))
        for number in settings.nodes:
            node = canopen.RemoteNode(number, canopen.ObjectDictionary())
            node.sdo = Questions(node, self)
            node.sdo_channels = [node.sdo]
            self._network.add_node(node)

    def set_up_all(self, arm: Arm) -> SetUp:
        """Set up all drives and start them; nothing moves and nothing is powered.

        Raises NotReady if a drive refuses a required setting, LinkLost if a drive does not answer.
        """
        drives = [self._drive(joint) for joint in range(arm.dof)]
        with suppress(LinkLost):  # an absent or stopped drive is not enabled, and is asked again
            for drive in drives:
                require_not_enabled(drive)
        for node in self._settings.nodes:
            self._network[node].nmt.state = "PRE-OPERATIONAL"
        data = [inspect(drive) for drive in drives]
        wishes = self._settings.efforts
        kind, warnings = effort_kind(drives, wishes, self._settings.effort)
        efforts = [find_effort(d, wanted, kind) for d, wanted in zip(drives, wishes, strict=True)]
        for joint, drive in enumerate(drives):
            set_up(drive, self._settings, arm, joint, efforts[joint], data[joint])
        self._start([drive_data.beats for drive_data in data])
        return SetUp(kind, efforts, data, warnings)

    def error_of(self, joint: int) -> str:
        """Error code of a drive in fault, in words."""
        try:
            return f"0x603F is {c.error_text(self._drive(joint).read(c.ERROR_CODE))}"
        except DriverError as error:
            return f"its error code cannot be read ({error})"

    def read_until(self, condition: Callable[[], bool], seconds: float) -> None:
        """Read frames until a condition holds or the time [s] is up."""
        clock = self._bus.clock
        end = clock.monotonic() + seconds
        while not condition() and (remaining := end - clock.monotonic()) > 0.0:
            self._read(remaining)

    def read_late_frames(self) -> None:
        """Read the frames that are already there."""
        for _ in range(UNREAD):
            unreadable = self._bus.unreadable
            if not self._read(0.0) and self._bus.unreadable == unreadable:
                return

    def _read(self, seconds: float) -> bool:
        received = self._bus.receive(seconds)
        if received is not None and received[0] <= STANDARD:
            with suppress(Exception):  # a frame that noise has damaged raises errors of any type
                self._network.notify(received[0], bytearray(received[1]), self._bus.clock.monotonic())
        return received is not None

    def _drive(self, joint: int) -> Drive:
        node = cast(canopen.RemoteNode, self._network[self._settings.nodes[joint]])
        return Drive(node.sdo, self._names[joint], self._bus.clock)

    def _start(self, beating: Sequence[bool]) -> None:
        """Start all drives, and check by their heartbeats that they are operational."""
        for node in self._settings.nodes:
            self._network[node].nmt.state = "OPERATIONAL"
        for name, node, beats in zip(self._names, self._settings.nodes, beating, strict=True):
            if not beats:
                continue
            state = self._next_state(name, node)
            if state != "OPERATIONAL":  # this heartbeat may have been sent before the command
                state = self._next_state(name, node)
            if state != "OPERATIONAL":
                raise NotReady(f"{name} was set operational and is {state.lower()}")

    def _next_state(self, name: str, node: int) -> str:
        """State in the next heartbeat of a drive. Raises NotReady if none comes."""
        manager = cast(canopen.RemoteNode, self._network[node]).nmt
        manager.timestamp = None
        self.read_until(lambda: manager.timestamp is not None, 4.0 * self._settings.heartbeat + 0.5)
        if manager.timestamp is None:
            raise NotReady(f"{name} sends no heartbeat, though it took 0x1017")
        return str(manager.state)
