"""One drive's object dictionary over SDO, with our errors."""

import struct

import canopen
from canopen.sdo.exceptions import SdoAbortedError

from ..errors import LinkLost, NotReady
from .cia402 import DEVICE_NAME, Entry

TRIES = 3
"""How often an answer is asked for."""
ANSWER = 0.3
"""How long one is waited for [s]."""
ABSENT = (0x06020000, 0x06090011)
"""What a drive aborts with where it has no such object, or no such sub-index of it."""


class Refused(NotReady):
    """A drive aborted the transfer: `why` in its words, `absent` whether for want of the object."""

    def __init__(self, text: str, error: SdoAbortedError) -> None:
        super().__init__(text)
        self.why, self.absent = str(error), error.code in ABSENT


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
        try:
            data = self._upload(entry)
        except Refused as refusal:
            why = ", which this driver needs" if refusal.absent else ""
            raise NotReady(f"{refusal}{why}") from refusal
        size = struct.calcsize(entry.form)
        if len(data) < size:
            raise NotReady(f"{self.name} answers {len(data)} bytes for {entry}, which has {size}")
        return int(struct.unpack(entry.form, data[:size])[0])

    def look_up(self, entry: Entry) -> int | None:
        """The value of an object that the driver can do without; None where the drive does not have it.

        Raises:
            LinkLost: The drive does not answer.
        """
        try:
            return self.read(entry)
        except NotReady:
            return None

    def size(self, entry: Entry) -> int | None:
        """Bytes of an object's value; None where there is no such object, 0 where it has no value now.

        Raises as `look_up`.
        """
        try:
            return len(self._upload(entry))
        except Refused as refusal:
            return None if refusal.absent else 0

    def text(self, entry: Entry = DEVICE_NAME) -> str:
        """A text; empty where the drive has none. Raises as `look_up`."""
        try:
            data = self._upload(entry)
        except Refused:
            return ""
        return "".join(c for c in data.decode("ascii", "replace") if c.isprintable()).strip()

    def write(self, entry: Entry, value: int) -> None:
        """Write a value. Raises as `read`."""
        data = struct.pack(entry.form, value)
        for attempt in range(1, TRIES + 1):
            try:
                return self._sdo.download(entry.index, entry.sub, data)
            except SdoAbortedError as error:
                raise self._refused(entry, f"refuses {entry} := {value}", error) from error
            except Exception as error:  # what noise on the bus makes of an answer has no common type
                if attempt == TRIES:
                    raise LinkLost(self._silent(f"{entry} := {value}", error)) from error

    def set(self, entry: Entry, value: int) -> None:
        """See to it that a value is there: written and read back, or there already. Raises as `read`."""
        try:
            self.write(entry, value)
        except Refused:  # what can only be read may be right as it is
            if self.look_up(entry) != value:
                raise
            return
        found = self.read(entry)
        if found != value:
            raise NotReady(f"{self.name} was set to {entry} := {value} and still has {found}")

    def offer(self, entry: Entry, value: int) -> str:
        """As `set`, for a value that not every drive takes; gives why it did not, empty if it did."""
        try:
            self.set(entry, value)
        except NotReady as error:
            return str(error)
        return ""

    def _upload(self, entry: Entry) -> bytes:
        for attempt in range(1, TRIES + 1):
            try:
                return self._sdo.upload(entry.index, entry.sub)
            except SdoAbortedError as error:
                raise self._refused(entry, f"refuses to read {entry}", error) from error
            except Exception as error:  # likewise
                if attempt == TRIES:
                    raise LinkLost(self._silent(str(entry), error)) from error
        raise AssertionError("the last try returns or raises")

    def _refused(self, entry: Entry, what: str, error: SdoAbortedError) -> Refused:
        absent = error.code in ABSENT
        return Refused(f"{self.name} has no {entry}" if absent else f"{self.name} {what}: {error}", error)

    def _silent(self, what: str, error: Exception) -> str:
        return (
            f"{self.name} does not answer when asked for {what}: {error}. Check its power, node number and "
            "bitrate, and the termination of the bus"
        )
