"""One drive's object dictionary over SDO, with our errors."""

import struct

import canopen
from canopen.sdo.exceptions import SdoAbortedError

from .cia402 import DEVICE_NAME, Entry
from .errors import LinkLost, NotReady

TRIES = 3
"""How often an answer is asked for."""
ANSWER = 0.3
"""How long one is waited for [s]."""
ABSENT = (0x06020000, 0x06090011)
"""What a drive aborts with where it has no such object."""


class Drive:
    """What can be read from a drive and written to it; nothing is ever stored beyond the next power-off.

    Args:
        node: Of a network that is being read.
        name: For messages.
    """

    def __init__(self, node: canopen.RemoteNode, name: str) -> None:
        self.name = name
        self._sdo = node.sdo
        self._sdo.RESPONSE_TIMEOUT = ANSWER

    def read(self, entry: Entry) -> int:
        """The value.

        Raises:
            NotReady: The drive refuses, or has no such object.
            LinkLost: It does not answer.
        """
        value = self.look_up(entry)
        if value is None:
            raise NotReady(f"{self.name} has no object {entry}, which this driver needs")
        return value

    def look_up(self, entry: Entry) -> int | None:
        """The value; None where the drive has no such object. Raises as `read`."""
        data = self._upload(entry)
        if data is None:
            return None
        size = struct.calcsize(entry.form)
        if len(data) < size:
            raise NotReady(f"{self.name} answers {len(data)} bytes for {entry}, which has {size}")
        return int(struct.unpack(entry.form, data[:size])[0])

    def text(self, entry: Entry = DEVICE_NAME) -> str:
        """A text; empty where the drive has none. Raises as `read`."""
        data = self._upload(entry) or b""
        return "".join(c for c in data.decode("ascii", "replace") if c.isprintable()).strip()

    def write(self, entry: Entry, value: int) -> None:
        """Write a value. Raises as `read`."""
        data = struct.pack(entry.form, value)
        for attempt in range(1, TRIES + 1):
            try:
                return self._sdo.download(entry.index, entry.sub, data)
            except SdoAbortedError as error:
                raise NotReady(f"{self.name} refuses {entry} := {value}: {error}") from error
            except Exception as error:  # what noise on the bus makes of an answer has no common type
                if attempt == TRIES:
                    raise LinkLost(self._silent(f"{entry} := {value}", error)) from error

    def set(self, entry: Entry, value: int) -> None:
        """Write a value and see that it is there. Raises as `read`."""
        self.write(entry, value)
        found = self.read(entry)
        if found != value:
            raise NotReady(f"{self.name} was told {entry} := {value} and still has {found}")

    def offer(self, entry: Entry, value: int) -> str:
        """Write a value that not every drive takes; gives why it did not, empty if it did."""
        try:
            self.set(entry, value)
        except NotReady as error:
            return str(error)
        return ""

    def _upload(self, entry: Entry) -> bytes | None:
        for attempt in range(1, TRIES + 1):
            try:
                return self._sdo.upload(entry.index, entry.sub)
            except SdoAbortedError as error:
                if error.code in ABSENT:
                    return None
                raise NotReady(f"{self.name} refuses to tell {entry}: {error}") from error
            except Exception as error:  # likewise
                if attempt == TRIES:
                    raise LinkLost(self._silent(str(entry), error)) from error
        return None

    def _silent(self, what: str, error: Exception) -> str:
        return (
            f"{self.name} does not answer when asked for {what}: {error}. Check its power, node number and "
            "bitrate, and the termination of the bus"
        )
