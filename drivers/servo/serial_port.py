"""A serial port for exclusive use: exact reads with a deadline, and only errors of drivers."""

import os
from contextlib import suppress
from pathlib import Path

import serial
from serial.tools import list_ports

from ..errors import BadSettings, LinkLost, NotReady
from ..host_clock import HOST, Clock

WRITE_WITHIN = 0.005
"""Time within which the port must take a packet [s]; otherwise it is lost, and the next cycle sends again."""

MOST = 4096
"""Size of Linux's buffer for received bytes."""

ADAPTERS = Path("/sys/bus/usb-serial/devices")
"""Directory in which Linux describes USB adapters."""

TROUBLE: tuple[type[Exception], ...] = (OSError, ValueError, TypeError)
"""Errors raised by a port that is gone or was closed."""

with suppress(ImportError):  # not every system has terminals
    import termios

    TROUBLE += (termios.error,)


class SerialPort:
    """An open port such as "/dev/ttyUSB0" or "COM3"; a short read has reached its deadline [s].

    Raises BadSettings if there is no such port or baud rate [bit/s], NotReady if the port is in use or this
    user may not open it.
    """

    def __init__(self, name: str, baudrate: int, patience: float, clock: Clock = HOST) -> None:
        self.clock, self.name, self._patience = clock, name, patience
        self.waited = False  # whether the last read had to wait for bytes
        try:
            self._port = serial.Serial(
                name, baudrate, timeout=patience, write_timeout=WRITE_WITHIN, exclusive=True
            )
        except TROUBLE as error:
            raise _cannot_open(name, baudrate, error) from error
        self._direct = hasattr(self._port, "fd")  # on POSIX systems, pyserial waits for each piece
        with suppress(*TROUBLE, AttributeError, NotImplementedError):
            self._port.set_low_latency_mode(True)

    def set_patience(self, patience: float) -> None:
        """Set how long reads wait [s]. This may reconfigure the port: do not call it in every cycle."""
        self._patience = patience
        if self._direct:
            return
        try:
            self._port.timeout = patience
        except TROUBLE as error:
            raise self._gone(error) from error

    @property
    def waiting(self) -> int:
        """Number of bytes received but not read. Raises LinkLost if the port is gone."""
        try:
            return self._port.in_waiting
        except TROUBLE as error:
            raise self._gone(error) from error

    def read(self, count: int) -> bytes:
        """Read a number of bytes, or fewer if the patience ends. Raises LinkLost if the port is gone."""
        try:
            if self._direct:
                return self._read_directly(count)
            self.waited = self._port.in_waiting < count
            return self._port.read(count)
        except TROUBLE as error:
            raise self._gone(error) from error

    def _read_directly(self, count: int) -> bytes:
        """Read from the file descriptor; bytes already there are taken without a `select`."""
        descriptor, end = self._port.fd, self.clock.monotonic() + self._patience
        data = _read_now(descriptor, count)
        self.waited = len(data) < count
        while len(data) < count:
            remaining = max(end - self.clock.monotonic(), 0.0)
            if not self.clock.readable([descriptor], remaining):
                break
            more = _read_now(descriptor, count - len(data))
            if not more:
                raise OSError("it reports data, but none can be read")
            data += more
        return data

    def write(self, data: bytes) -> None:
        """Send bytes, as many as the port takes in time. Raises LinkLost if the port is gone."""
        try:
            if self._direct:
                self._write_directly(data)
            else:
                with suppress(serial.SerialTimeoutException):
                    self._port.write(data)
        except TROUBLE as error:
            raise self._gone(error) from error

    def _write_directly(self, data: bytes) -> None:
        """Write to the file descriptor; after a truncated packet, servos find the beginning of the next."""
        descriptor, end = self._port.fd, self.clock.monotonic() + WRITE_WITHIN
        while data:
            with suppress(BlockingIOError):
                data = data[os.write(descriptor, data) :]
            if data and not self.clock.writable([descriptor], max(end - self.clock.monotonic(), 0.0)):
                return

    def drain(self) -> int:
        """Discard received bytes, and return their number. Raises LinkLost if the port is gone."""
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
    """Latency timer of a port's USB adapter [s]; zero if unknown."""
    try:
        text = (adapters / Path(name).resolve().name / "latency_timer").read_text()
        return 1e-3 * int(text)
    except (OSError, ValueError):
        return 0.0


def latency_warnings(name: str, latency: float) -> tuple[str, ...]:
    """Warning about an adapter with a long latency [s]."""
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
