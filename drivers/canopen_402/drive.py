"""Object dictionary of one drive over SDO, and the object that measures its current or torque."""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from canopen.sdo import SdoClient
from canopen.sdo.exceptions import SdoAbortedError

from ..errors import BadSettings, LinkLost, NotReady
from ..host_clock import Clock
from . import cia402 as c
from .cia402 import DEVICE_NAME, Entry

TRIES = 3
"""Number of attempts to get an answer."""
ABSENT = (0x06020000, 0x06090011)
"""SDO abort codes of a drive that has no such object, or no such sub-index."""


class Refused(NotReady):
    """A drive aborted the transfer: `why` is its reason, `absent` whether it has no such object."""

    def __init__(self, text: str, error: SdoAbortedError) -> None:
        super().__init__(text)
        self.why, self.absent = str(error), error.code in ABSENT


class Drive:
    """Reads values from a drive and writes them; nothing is stored beyond the next power-off."""

    def __init__(self, sdo: SdoClient, name: str, clock: Clock) -> None:
        self.name, self.clock, self._sdo = name, clock, sdo

    def read(self, entry: Entry) -> int:
        """Read a value.

        Raises NotReady if the drive refuses or has no such object, LinkLost if it does not answer.
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
        """Read a value; None if the drive refuses or has no such object. Raises LinkLost."""
        try:
            return self.read(entry)
        except NotReady:
            return None

    def size(self, entry: Entry) -> int | None:
        """Size of an object [bytes]; None without such an object, 0 without a value now. Raises LinkLost."""
        try:
            return len(self._upload(entry))
        except Refused as refusal:
            return None if refusal.absent else 0

    def text(self, entry: Entry = DEVICE_NAME) -> str:
        """Read a text; empty if the drive has none. Raises LinkLost."""
        try:
            data = self._upload(entry)
        except Refused:
            return ""
        return "".join(c for c in data.decode("ascii", "replace") if c.isprintable()).strip()

    def write(self, entry: Entry, value: int) -> None:
        """Write a value. Raises the errors of `read`."""
        request, data = f"{entry} := {value}", struct.pack(entry.form, value)
        self._transfer(entry, request, f"refuses {request}", self._sdo.download, data)

    def set(self, entry: Entry, value: int) -> None:
        """Ensure that an object has a value: write it and read it back. Raises the errors of `read`.

        A drive may refuse to write a value that it already has.
        """
        try:
            self.write(entry, value)
        except Refused:  # a read-only object may already have the value
            if self.look_up(entry) != value:
                raise
            return
        actual = self.read(entry)
        if actual != value:
            raise NotReady(f"{self.name} was set to {entry} := {value} and still has {actual}")

    def offer(self, entry: Entry, value: int) -> str:
        """Set a value that not every drive takes; returns why it was refused, empty if it was taken."""
        try:
            self.set(entry, value)
        except NotReady as error:
            return str(error)
        return ""

    def _upload(self, entry: Entry) -> bytes:
        data: bytes = self._transfer(entry, str(entry), f"refuses to read {entry}", self._sdo.upload)
        return data

    def _transfer(
        self, entry: Entry, request: str, refusal: str, transfer: Callable[..., Any], *data: bytes
    ) -> Any:
        """Transfer an object, with repetitions; `request` and `refusal` are for messages."""
        for attempt in range(1, TRIES + 1):
            try:
                return transfer(entry.index, entry.sub, *data)
            except SdoAbortedError as error:
                why = f"has no {entry}" if error.code in ABSENT else f"{refusal}: {error}"
                raise Refused(f"{self.name} {why}", error) from error
            except Exception as error:  # an answer that noise has damaged raises errors of any type
                if attempt == TRIES:
                    raise LinkLost(
                        f"{self.name} does not answer when asked for {request}: {error}. Check its power, "
                        "node number and bitrate, and the termination of the bus"
                    ) from error
        raise AssertionError("the last try returns or raises")


TYPES = {
    "int8": "<b",
    "int16": "<h",
    "int32": "<i",
    "uint8": "<B",
    "uint16": "<H",
    "uint32": "<I",
    "float32": "<f",
}
"""Type of an object that can be mapped -> `struct` format."""
FIRST, LAST = 0x2000, 0x9FFF
"""Range of indices of manufacturer and profile objects; lower ones belong to communication."""
STEP = 1e-3
"""Unit of 0x6075 [A] and of 0x6076 [N m]."""
ADVICE = "Set current_object to its maker's object, such as '0x30D1:2 int32', and current_scale [A per count]"


@dataclass(frozen=True)
class EffortSettings:
    """Settings of one drive's current and torque; 0 uses the value in the drive."""

    current: c.Entry  # object that measures the current
    scale: float  # current per count of this object [A]
    rated_current: float  # current of 1000 counts [A]
    rated_torque: float  # motor torque of 1000 counts [N m]


class Effort(NamedTuple):
    """Object that measures the current or torque of a motor."""

    entry: c.Entry  # the object
    unit: float  # current [A] or motor torque [N m] per count
    fact: str  # explanation of object and unit, for the recording
    warnings: tuple[str, ...] = ()  # warnings, a sentence each


class Words(NamedTuple):
    """Words for a quantity in messages: name, unit, setting of its rated value, and what to set instead."""

    name: str
    unit: str
    setting: str
    instead: str


CURRENT_WORDS = Words("current", "A", "rated_current", "rated_current [A], or current_scale [A per count]")
TORQUE_WORDS = Words("torque", "N m", "rated_torque", "rated_torque [N m, of the motor]")


def read_object(text: str, name: str) -> c.Entry:
    """Parse "index:sub type", such as "0x30D1:2 int32", as the object that measures `name`.

    Raises BadSettings if the text has another form, or the object cannot be in a PDO.
    """
    place, _, kind = text.strip().partition(" ")
    index, _, sub = place.partition(":")
    try:
        entry = c.Entry(int(index, 16), int(sub or "0", 0), TYPES[kind.strip()], name)
    except (ValueError, KeyError):
        raise BadSettings(
            f"current_object is '{text}'; expected 'index:sub type', such as '0x30D1:2 int32', of type "
            f"{', '.join(TYPES)}"
        ) from None
    if not (FIRST <= entry.index <= LAST and 0 <= entry.sub <= 255):
        raise BadSettings(
            f"current_object is '{text}'; valid are index 0x{FIRST:04X} to 0x{LAST:04X} and sub 0 to 255"
        )
    return entry


def effort_kind(
    drives: Sequence[Drive], wishes: Sequence[EffortSettings], kind: str
) -> tuple[str, list[str]]:
    """Effort that all drives can measure, "current" or "torque", and warnings about the choice.

    With "auto", torque is used if a drive has no current object. Raises NotReady, with what to set, if a
    drive has neither.
    """
    if kind != "auto":
        return kind, []
    poor = [
        (d, wanted.current)
        for d, wanted in zip(drives, wishes, strict=True)
        if d.size(wanted.current) is None
    ]
    if not poor:
        return "current", []
    drive, current = poor[0]
    poorer = next((other for other in drives if other.size(c.TORQUE) is None), None)
    if poorer is None:
        return "torque", [f"{drive.name} has no {current}: {c.TORQUE} is recorded of all joints instead"]
    if poorer is drive:
        raise NotReady(f"{drive.name} has neither {current} nor {c.TORQUE}. {ADVICE}")
    raise NotReady(f"{drive.name} has no {current}, and {poorer.name} has no {c.TORQUE} instead. {ADVICE}")


def find_effort(drive: Drive, wanted: EffortSettings, kind: str) -> Effort:
    """Find the object of a drive that measures "current" or "torque", and its unit.

    Raises NotReady, with what to set, if there is none, it has another size, or its meaning is unknown, and
    LinkLost if the drive does not answer.
    """
    if kind == "torque":
        _require_object(drive, c.TORQUE, 'Set effort = "current"')
        return _in_thousandths(drive, c.TORQUE, c.RATED_TORQUE, wanted.rated_torque, TORQUE_WORDS)
    _require_object(drive, wanted.current, f'{ADVICE}, or effort = "torque"')
    if wanted.scale:
        return Effort(wanted.current, wanted.scale, f"{wanted.current}, {wanted.scale:g} A per count")
    return _in_thousandths(drive, wanted.current, c.RATED_CURRENT, wanted.rated_current, CURRENT_WORDS)


def _require_object(drive: Drive, entry: c.Entry, advice: str) -> None:
    size, expected = drive.size(entry), struct.calcsize(entry.form)
    if size is None:
        raise NotReady(f"{drive.name} has no {entry}. {advice}")
    if size not in (0, expected):
        raise NotReady(
            f"{drive.name} answers {size} bytes for {entry}, its type here has {expected}. Set "
            "current_object to the type in the drive's manual"
        )


def _in_thousandths(drive: Drive, entry: c.Entry, rating: c.Entry, setting: float, words: Words) -> Effort:
    """Effort in thousandths of a rated value, which is set by the user or read from the drive."""
    value = drive.look_up(rating)
    stored = STEP * (value or 0)
    if not setting and not stored:
        lacking = f"has no {rating}" if value is None else f"has {rating} = 0"
        raise NotReady(
            f"{drive.name} {lacking}, but its {words.name} is in thousandths of that. Set {words.instead}, "
            "or commission the drive with its maker's tool"
        )
    rated, source = (setting, words.setting) if setting else (stored, f"0x{rating.index:04X}")
    differs = setting and stored and abs(setting - stored) > STEP
    warning = f"{drive.name} has {stored:g} {words.unit} in {rating}; {words.setting} = {setting:g} is used"
    fact = f"{entry}, in thousandths of {rated:g} {words.unit} ({source})"
    return Effort(entry, 1e-3 * rated, fact, (warning,) if differs else ())
