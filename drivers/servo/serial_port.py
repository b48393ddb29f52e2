"""A serial port, held by this program alone: exact reads with a deadline, and no errors but ours."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import serial
from serial.tools import list_ports

from ..errors import BadSettings, LinkLost, NotReady

WRITE_WITHIN = 0.5
"""A port that does not take a packet within this time is dead [s]."""

ADAPTERS = Path("/sys/bus/usb-serial/devices")
"""Where Linux keeps what it knows of USB adapters."""

TROUBLE: tuple[type[Exception], ...] = (OSError, ValueError, TypeError)
"""What a port raises that is gone, or closed meanwhile."""

with suppress(ImportError):  # not everywhere are there terminals
    import termios

    TROUBLE += (termios.error,)


class SerialPort:
    """An open port; a read that comes back short has met its deadline.

    Args:
        name: Such as "/dev/ttyUSB0" or "COM3".
        baudrate: [bit/s].
        patience: How long a read waits for its bytes [s].

    Raises:
        BadSettings: No such port, or a baud rate it does not have.
        NotReady: A port that is in use, or that this user may not open.
    """

    def __init__(self, name: str, baudrate: int, patience: float) -> None:
        self.name = name
        try:
            self._port = serial.Serial(
                name, baudrate, timeout=patience, write_timeout=WRITE_WITHIN, exclusive=True
            )
        except TROUBLE as error:
            raise _cannot_open(name, baudrate, error) from error
        with suppress(*TROUBLE, AttributeError, NotImplementedError):
            self._port.set_low_latency_mode(True)

    def be_patient(self, patience: float) -> None:
        """From now on reads wait for so long [s]. Sets the port up anew: not for every cycle."""
        with self._linked():
            self._port.timeout = patience

    @property
    def waiting(self) -> int:
        """Bytes that have come and were not read.

        Raises:
            LinkLost: The port is gone.
        """
        with self._linked():
            return self._port.in_waiting

    def read(self, count: int) -> bytes:
        """So many bytes, or fewer when patience ends.

        Raises:
            LinkLost: The port is gone.
        """
        with self._linked():
            return self._port.read(count)

    def write(self, data: bytes) -> None:
        """Send bytes.

        Raises:
            LinkLost: The port is gone, or does not take them.
        """
        with self._linked():
            self._port.write(data)

    def drain(self) -> int:
        """Throw away what has come, and return how many bytes that was.

        Raises:
            LinkLost: The port is gone.
        """
        return len(self.read(self.waiting))

    def close(self) -> None:
        """Let go; never raises."""
        with suppress(*TROUBLE):
            self._port.close()

    @contextmanager
    def _linked(self) -> Iterator[None]:
        try:
            yield
        except TROUBLE as error:
            raise LinkLost(
                f"{self.name} is gone ({error}). Look at the plug and at the power of the adapter"
            ) from error


def adapter_latency(name: str, adapters: Path = ADAPTERS) -> float:
    """How long a USB adapter may keep bytes before it hands them over [s]; zero where unknown.

    Args:
        name: Of the port.
        adapters: Where the system lists it.
    """
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
    """Message about a port that does not open."""
    text = str(error)
    if "lock" in text or "busy" in text.lower():
        return NotReady(f"{name} is in use by another program. Close it and try again")
    if "ermission" in text:
        return NotReady(f"{name}: no permission. On Linux, try to become a member of the group dialout")
    there = ", ".join(port.device for port in list_ports.comports()) or "none at all"
    return BadSettings(f"{name} does not open at {baudrate} bit/s ({text}). Ports found: {there}")
