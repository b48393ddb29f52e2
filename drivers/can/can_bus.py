"""CAN bus: checks that it can carry a cycle, and opens it with errors of drivers; in use it never raises."""

import logging
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import can

from ..errors import BadSettings, LinkLost
from ..host_clock import HOST, Clock, Pause
from ..settings import setting
from .claim import Claim
from .transports import ERROR, IDENTIFIER, Frame, transport_of

PATIENCE = 0.1
"""Time for which reading or sending may fail continuously before the bus is given up [s]."""

SENT_WITHIN = 0.002
"""Time within which the bus must take the frames of a cycle [s]; otherwise sending has failed."""

BUS_OFF = 0x40
"""Bit of an error frame's identifier: the CAN controller has switched itself off (Linux, error.h)."""
CONTROLLER = 0x04
"""Bit of an error frame's identifier: the second byte is the state of the CAN controller."""
TROUBLES = {
    0x01: "received frames were lost: the host reads too slowly",
    0x02: "frames to be sent were lost",
    0x04: "many errors in received frames",
    0x08: "many errors in sent frames",
    0x10: "error-passive while receiving: check wiring, termination and bitrate",
    0x20: "error-passive while sending: is there no acknowledge? Check wiring, termination and bitrate",
}

PACKAGES = {
    "canalystii": "canalystii", "cantact": "cantact", "gs_usb": "gs-usb", "neovi": "python-ics filelock",
    "nixnet": "nixnet", "udp_multicast": "msgpack", "usb2can": "pywin32",
}  # fmt: skip
"""Interface -> packages that it needs and that python-can does not install (its optional dependencies)."""


@dataclass(frozen=True, kw_only=True)
class CanSettings(ABC):
    """Settings of every arm on a CAN bus."""

    interface: str = setting("socketcan", "interface of python-can")
    channel: str = setting("can0", "channel of the interface, such as can0 or /dev/ttyACM0")
    bitrate: int = setting(1_000_000, "bitrate of the bus", unit="bit/s", low=10_000, high=1_000_000)
    options: str = setting("", "further options of python-can, as 'name=value, name=value'")
    cycle: float = setting(0.002, "time between commands", unit="s", low=0.0005, high=0.1)
    at_close: str = setting(
        "hold",
        "after the run: hold the position, or switch off, for arms with brakes",
        choices=("hold", "off"),
    )

    @property
    @abstractmethod
    def frames(self) -> list[int]:
        """Maximum number of data bytes of each frame in a cycle."""

    @property
    def beats(self) -> float:
        """Heartbeats on the bus [1/s]."""
        return 0.0

    @property
    def bus(self) -> str:
        """Description of the bus with its worst-case load."""
        load = bus_load(self.frames, self.cycle, self.bitrate, self.beats)
        return f"{self.interface} {self.channel}, {self.bitrate} bit/s, load {100.0 * load:.0f} % at worst"

    def require_bus(self) -> None:
        """Raise BadSettings if there is no such interface, or the bus cannot carry the frames."""
        require_interface(self.interface)
        read_options(self.options)
        require_room(self.frames, self.cycle, self.bitrate, self.beats)


for library in ("can", "canopen"):  # our errors contain their messages; without a handler they print them
    logging.getLogger(library).addHandler(logging.NullHandler())


class CanBus:
    """A python-can bus that tolerates noise; `canopen` sends with it, too.

    Raises:
        BadSettings: If there is no such interface, or the options are invalid.
        NotReady: If another exidyn process uses the bus.
        LinkLost: If the bus cannot be opened.
    """

    def __init__(
        self, interface: str, channel: str, bitrate: int, options: str = "", clock: Clock = HOST
    ) -> None:
        require_interface(interface)
        more = read_options(options)
        self._claim = Claim(f"CAN bus {interface} {channel} {more.get('port', '')}".strip())
        try:
            self._bus = can.Bus(
                channel=channel, interface=interface, ignore_config=True, bitrate=bitrate, **more
            )
        except Exception as error:  # each of python-can's back-ends has errors of its own
            self._claim.release()
            raise LinkLost(_cannot_open(interface, channel, bitrate, error)) from error
        self._transport = transport_of(self._bus, interface)
        self.clock = self._transport.clock = clock
        self.trouble = ""  # why the bus can no longer be used; empty while it can
        self.unreadable = 0  # number of frames so far that could not be read, or were error frames
        self.channel_info = f"{interface} {channel}"
        self._failing = {"read": 0.0, "sent": 0.0}
        self._reported: set[str] = set()
        self._events: list[str] = []

    def watch_for(self, pause: Pause) -> None:
        """From now on, send nothing right after this computer was silent for too long."""
        self._transport.pause = pause

    def send_frames(self, frames: Sequence[Frame]) -> None:
        """Send data frames with 11-bit identifiers, in this order; a lasting failure sets `trouble`."""
        self._try_to_send(self._transport.send, frames, SENT_WITHIN)

    def send(self, message: can.Message, timeout: float = SENT_WITHIN) -> None:
        """Send a frame of any kind, as python-can does; a lasting failure sets `trouble`."""
        self._try_to_send(self._bus.send, message, timeout)

    def _try_to_send(self, send: Callable[..., None], *arguments: Any) -> None:
        try:
            send(*arguments)
        except Exception as error:  # errors of the back-end, of any type
            self._failed("sent", error)
        else:
            self._failing["sent"] = 0.0

    def receive(self, timeout: float) -> Frame | None:
        """Return the next frame, its identifier with flags; None if there was none within the timeout [s].

        None also for a frame that cannot be read and for an error frame, which count as `unreadable`.
        """
        try:
            received = self._transport.receive(timeout)
        except Exception as error:  # errors of the back-end, of any type
            self.unreadable += 1
            self._failed("read", error)
            return None
        self._failing["read"] = 0.0
        if received is not None and received[0] & ERROR:
            self.unreadable += 1
            self._error_frame(received[0] & IDENTIFIER, received[1])
            return None
        return received

    def events(self) -> list[str]:
        """Events since the last call; the same event is reported only once."""
        events, self._events = self._events, []
        return events

    def shutdown(self) -> None:
        """Release the bus; never raises."""
        try:
            self._bus.shutdown()
        except Exception as error:  # errors of the back-end, of any type
            self._report(f"CAN bus could not be closed: {error}")
        self._claim.release()

    def _failed(self, operation: str, error: Exception) -> None:
        now = self.clock.monotonic()
        since = self._failing[operation] = self._failing[operation] or now
        self._report(f"a CAN frame could not be {operation}: {type(error).__name__}: {error}")
        if now - since > PATIENCE and not self.trouble:
            self.trouble = f"CAN bus: nothing can be {operation} any more: {type(error).__name__}: {error}"

    def _error_frame(self, identifier: int, data: bytes) -> None:
        if identifier & BUS_OFF:
            self.trouble = self.trouble or "CAN bus: the host's CAN controller has gone bus-off"
        elif identifier & CONTROLLER and len(data) > 1:
            for bit, text in TROUBLES.items():
                if data[1] & bit:
                    self._report(f"CAN controller: {text}")

    def _report(self, text: str) -> None:
        if text not in self._reported and len(self._reported) < 100:
            self._reported.add(text)
            self._events.append(text)


def require_interface(name: str) -> None:
    """Raise BadSettings, with a list of all interfaces, if python-can has no interface of this name."""
    if name not in can.VALID_INTERFACES:
        raise BadSettings(f"interface is '{name}'. Valid: {', '.join(sorted(can.VALID_INTERFACES))}")


def read_options(text: str) -> dict[str, Any]:
    """Parse "name=value, name=value" into numbers, flags and texts. Raises BadSettings for another form."""
    options = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or not name.isidentifier():
            raise BadSettings(f"options: '{part}' is not name=value, such as tty_baudrate=3000000")
        options[name] = _value(value)
    return options


def _value(text: str) -> Any:
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _cannot_open(interface: str, channel: str, bitrate: int, error: Exception) -> str:
    advice = {
        "socketcan": f"Is it there and up? 'ip link set {channel} up type can bitrate {bitrate}'",
        "slcan": "Is the adapter plugged in, and may you read and write its port?",
    }.get(interface, "Is the adapter plugged in, and its driver installed?")
    if isinstance(error, can.CanInterfaceNotImplementedError | ImportError):
        package = PACKAGES.get(interface)
        advice = (
            f"python-can needs {package} for this interface: 'pip install {package}'."
            if package
            else "python-can lacks a library for this interface, such as that of its maker: see its page on "
            f"'{interface}'."
        )
    return (
        f"CAN bus {interface} {channel} cannot be opened: {type(error).__name__}: {error}. {advice} "
        "Other interfaces are chosen by 'interface' and 'channel'"
    )


FULL = 0.95
"""Usable fraction of a bus [-]; the rest is for repeated frames, errors and set-up."""


def frame_bits(data: int) -> int:
    """Maximum number of bits of a classic frame with an 11-bit identifier and a number of data bytes.

    The frame takes 44 bits, the silence after it 3, each byte 8, and stuffing adds one bit after every four
    bits of identifier, length, data and checksum.
    """
    return 47 + 8 * data + (34 + 8 * data - 1) // 4


def bus_load(frames: Sequence[int], cycle: float, bitrate: int, others: float = 0.0) -> float:
    """Worst-case load of a bus [-] with this bitrate [bit/s].

    Frames with these numbers of data bytes are sent once per cycle [s], and others, with one data byte, at a
    rate [1/s].
    """
    return (sum(frame_bits(data) for data in frames) / cycle + others * frame_bits(1)) / bitrate


def require_room(frames: Sequence[int], cycle: float, bitrate: int, others: float = 0.0) -> float:
    """Return the load as `bus_load` does. Raises BadSettings if the bus cannot carry it."""
    load = bus_load(frames, cycle, bitrate, others)
    if load > FULL:
        fits = math.ceil(1e3 * cycle * load / FULL) * 1e-3
        raise BadSettings(
            f"{len(frames)} frames a cycle at {1.0 / cycle:g} Hz need up to {100.0 * load:.0f} % of "
            f"{bitrate / 1e3:g} kbit/s, limit {100.0 * FULL:.0f} %. Try cycle = {fits:g}, a bitrate of "
            f"{math.ceil(bitrate * load / FULL / 1e5) / 10.0:g} Mbit/s or more (1 Mbit/s is the most of "
            "classic CAN), or fewer joints on this bus"
        )
    return load
