"""All drives of an arm over `canopen`: set-up, start, and error codes."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple, cast

import canopen

from ..can.can_bus import CanBus
from ..driver import Arm
from ..errors import DriverError, LinkLost, NotReady
from . import cia402 as c
from .drive import Drive, Effort, effort_kind, find_effort
from .settings import CanopenSettings
from .setup import DriveData, inspect, require_not_enabled, set_up


class SetUp(NamedTuple):
    """Drives of an arm after set-up.

    Attributes:
        kind: Effort that all drives measure, "current" or "torque".
        efforts: Object of each drive that measures it.
        drives: Data of each drive.
        warnings: Warnings that concern the whole arm, a sentence each.
    """

    kind: str
    efforts: list[Effort]
    drives: list[DriveData]
    warnings: list[str]


class DriveNetwork:
    """The drives, through their SDO servers.

    A thread of canopen reads the bus only during `set_up_all` and `error_of`, with the scheduling of the
    caller. At other times, the caller may use the bus.
    """

    def __init__(self, bus: CanBus, settings: CanopenSettings, names: Sequence[str]) -> None:
        self._settings, self._names = settings, names
        self._network = canopen.Network(cast(Any, bus))
        self._network.NOTIFIER_CYCLE = 0.02
        for node in settings.nodes:
            self._network.add_node(canopen.RemoteNode(node, canopen.ObjectDictionary()))

    def set_up_all(self, arm: Arm) -> SetUp:
        """Set up all drives and start them; nothing moves and nothing is powered.

        Raises NotReady if a drive refuses a required setting, LinkLost if a drive does not answer.
        """
        with self._reading():
            with suppress(LinkLost):  # an absent or stopped drive is not enabled, and is asked again
                for joint in range(arm.dof):
                    require_not_enabled(self._drive(joint))
            for node in self._settings.nodes:
                self._network[node].nmt.state = "PRE-OPERATIONAL"
            drives = [self._drive(joint) for joint in range(arm.dof)]
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
            with self._reading():
                return f"0x603F is {c.error_text(self._drive(joint).read(c.ERROR_CODE))}"
        except DriverError as error:
            return f"its error code cannot be read ({error})"

    @contextmanager
    def _reading(self) -> Iterator[None]:
        self._network.connect()
        try:
            yield
        finally:
            if self._network.notifier is not None:
                self._network.notifier.stop()
            self._network.notifier = None

    def _drive(self, joint: int) -> Drive:
        node = self._network[self._settings.nodes[joint]]
        return Drive(cast(canopen.RemoteNode, node), self._names[joint])

    def _start(self, beating: Sequence[bool]) -> None:
        """Start all drives, and check by their heartbeats that they are operational."""
        for node in self._settings.nodes:
            self._network[node].nmt.state = "OPERATIONAL"
        for name, node, beats in zip(self._names, self._settings.nodes, beating, strict=True):
            if not beats:
                continue
            try:
                manager = cast(canopen.RemoteNode, self._network[node]).nmt
                state = manager.wait_for_heartbeat(4.0 * self._settings.heartbeat + 0.5)
                if state != "OPERATIONAL":  # this heartbeat may have been sent before the command
                    state = manager.wait_for_heartbeat(4.0 * self._settings.heartbeat + 0.5)
            except Exception as error:  # canopen raises errors of any type
                raise NotReady(f"{name} sends no heartbeat, though it took 0x1017") from error
            if state != "OPERATIONAL":
                raise NotReady(f"{name} was set operational and is {state.lower()}")
