"""A serial port, held by this program alone: exact reads with a deadline, and no errors but ours."""

import os
import select
import time
from contextlib import suppress
from pathlib import Path

import serial
from serial.tools import list_ports

from ..errors import BadSettings, LinkLost, NotReady

WRITE_WITHIN = 0.005
"""A port that does not take a packet within this time has not taken it [s]; the next cycle has another."""

MOST = 4096
"""Bytes that Linux keeps of what nobody has read."""

ADAPTERS = Path("/sys/bus/usb-serial/devices")
"""Where Linux keeps what it knows of USB adapters."""

TROUBLE: tuple[type[Exception], ...] = (OSError, ValueError, TypeError)
"""What a port raises that is gone, or closed meanwhile."""

with suppress(ImportError):  # not everywhere are there terminals
    import termios

    TROUBLE += (termios.error,)


class SerialPort:
    """An open port such as "/dev/ttyUSB0" or "COM3"; a read that comes back short has met its deadline [s].

    Attributes:
        waited: Whether the last read had to wait for bytes.

    Raises BadSettings without such a port or baud rate [bit/s], NotReady for a port that is in use, or that
    this user may not open.
    """

    def __init__(self, name: str, baudrate: int, patience: float) -> None:
        self.name, self._patience, self.waited = name, patience, False
        try:
            self._port = serial.Serial(
                name, baudrate, timeout=patience, write_timeout=WRITE_WITHIN, exclusive=True
            )
        except TROUBLE as error:
            raise _cannot_open(name, baudrate, error) from error
        self._direct = hasattr(self._port, "fd")  # so on POSIX systems, where pyserial waits for each piece
        with suppress(*TROUBLE, AttributeError, NotImplementedError):
            self._port.set_low_latency_mode(True)

    def be_patient(self, patience: float) -> None:
        """From now on reads wait for so long [s]. May set the port up anew: not for every cycle."""
        self._patience = patience
        if self._direct:
            return
        try:
            self._port.timeout = patience
        except TROUBLE as error:
            raise self._gone(error) from error

    @property
    def waiting(self) -> int:
        """Bytes that have come and were not read. Raises LinkLost if the port is gone."""
        try:
            return self._port.in_waiting
        except TROUBLE as error:
            raise self._gone(error) from error

    def read(self, count: int) -> bytes:
        """So many bytes, or fewer when patience ends. Raises LinkLost if the port is gone."""
        try:
            if self._direct:
                return self._read_directly(count)
            self.waited = self._port.in_waiting < count
            return self._port.read(count)
        except TROUBLE as error:
            raise self._gone(error) from error

    def _read_directly(self, count: int) -> bytes:
        """As `read`; what is there already is taken without asking whether it is."""
        descriptor, end = self._port.fd, time.monotonic() + self._patience
        data = _read_now(descriptor, count)
        self.waited = len(data) < count
        while len(data) < count:
            left = max(end - time.monotonic(), 0.0)
            if not select.select([descriptor], [], [], left)[0]:
                break
            more = _read_now(descriptor, count - len(data))
            if not more:
                raise OSError("it has something to read, and nothing can be read")
            data += more
        return data

    def write(self, data: bytes) -> None:
        """Send bytes, as far as the port takes them in time. Raises LinkLost if the port is gone."""
        try:
            if self._direct:
                self._write_directly(data)
            else:
                with suppress(serial.SerialTimeoutException):
                    self._port.write(data)
        except TROUBLE as error:
            raise self._gone(error) from error

    def _write_directly(self, data: bytes) -> None:
        """As `write`; servos find the beginning of the next packet behind one that was cut."""
        descriptor, end = self._port.fd, time.monotonic() + WRITE_WITHIN
        while data:
            with suppress(BlockingIOError):
                data = data[os.write(descriptor, data) :]
            if data and not select.select([], [descriptor], [], max(end - time.monotonic(), 0.0))[1]:
                return

    def drain(self) -> int:
        """Throw away what has come, and return its number of bytes. Raises LinkLost if the port is gone."""
        if not self._direct:
            waiting = self.waiting
            return len(self.read(waiting)) if waiting else 0
        try:
            return len(_read_now(self._port.fd, MOST))
        except TROUBLE as error:
            raise self._gone(error) from error

    def close(self) -> None:
        with suppress(*TROUBLE):
            self._port.close()

    def _gone(self, error: Exception) -> LinkLost:
        return LinkLost(f"{self.name} is gone ({error}). Look at the plug and at the power of the adapter")


def _read_now(descriptor: int, count: int) -> bytes:
    try:
        return os.read(descriptor, count)
    except BlockingIOError:
        return b""


def adapter_latency(name: str, adapters: Path = ADAPTERS) -> float:
    """How long a port's USB adapter may keep bytes before it hands them over [s]; zero where unknown."""
    try:
        text = (adapters / Path(name).resolve().name / "latency_timer").read_text()
        return 1e-3 * int(text)
    except (OSError, ValueError):
        return 0.0


def latency_warnings(name: str, latency: float) -> tuple[str, ...]:
    """Warning about an adapter that keeps bytes for so long [s]."""
    if latency <= 1e-3:
        return ()
    return (
        f"the adapter keeps bytes for up to {1e3 * latency:g} ms. Try: echo 1 | sudo tee "
        f"{ADAPTERS}/{name.rsplit('/', 1)[-1]}/latency_timer",
    )


def _cannot_open(name: str, baudrate: int, error: Exception) -> BadSettings | NotReady:
    text = str(error)
    if "lock" in text or "busy" in text.lower():
        return NotReady(f"{name} is in use by another program. Close it and try again")
    if "ermission" in text:
        return NotReady(f"{name}: no permission. On Linux, try to become a member of the group dialout")
    there = ", ".join(port.device for port in list_ports.comports()) or "none at all"
    return BadSettings(f"{name} does not open at {baudrate} bit/s ({text}). Ports found: {there}")
