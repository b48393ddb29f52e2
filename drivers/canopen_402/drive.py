"""One drive's object dictionary over SDO, with our errors, and which object measures its motor's effort."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import canopen
from canopen.sdo.exceptions import SdoAbortedError

from ..errors import BadSettings, LinkLost, NotReady
from . import cia402 as c
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
    """What can be read from a drive and written to it; nothing is ever stored beyond the next power-off."""

    def __init__(self, node: canopen.RemoteNode, name: str) -> None:
        self.name = name
        self._sdo = node.sdo
        self._sdo.RESPONSE_TIMEOUT = ANSWER

    def read(self, entry: Entry) -> int:
        """The value. Raises NotReady if the drive refuses or has no such object, LinkLost if it is silent."""
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
        """The value; None where the drive refuses or has no such object. Raises LinkLost."""
        try:
            return self.read(entry)
        except NotReady:
            return None

    def size(self, entry: Entry) -> int | None:
        """Bytes of an object's value; None without such an object, 0 without a value now. Raises LinkLost."""
        try:
            return len(self._upload(entry))
        except Refused as refusal:
            return None if refusal.absent else 0

    def text(self, entry: Entry = DEVICE_NAME) -> str:
        """A text; empty where the drive has none. Raises LinkLost."""
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


TYPES = {
    "int8": "<b",
    "int16": "<h",
    "int32": "<i",
    "uint8": "<B",
    "uint16": "<H",
    "uint32": "<I",
    "float32": "<f",
}
"""Types of an object that can be mapped -> as `struct` writes them."""
FIRST, LAST = 0x2000, 0x9FFF
"""Index of the objects of makers and of profiles; those before them are of communication."""
STEP = 1e-3
"""Step of 0x6075 [A] and of 0x6076 [N m]."""
ADVICE = "Set current_object to what its maker has, such as '0x30D1:2 int32', and current_scale [A per count]"


@dataclass(frozen=True)
class EffortSettings:
    """What a user sets of one drive's current and torque; 0 for what the drive has.

    `scale` is [A per count] of the current's object. Rated current [A] and torque, at the motor [N m], are
    what a thousand counts mean.
    """

    current: c.Entry
    scale: float
    rated_current: float
    rated_torque: float


class Effort(NamedTuple):
    """Object that measures a motor's effort; `unit` is [A] or, at the motor, [N m] a count.

    Facts explain that later; warnings are a sentence each.
    """

    entry: c.Entry
    unit: float
    fact: str
    warnings: tuple[str, ...] = ()


class Words(NamedTuple):
    """How messages call a quantity, its unit, the setting of its rated value, and what may be set instead."""

    name: str
    unit: str
    setting: str
    instead: str


CURRENT_WORDS = Words("current", "A", "rated_current", "rated_current [A], or current_scale [A per count]")
TORQUE_WORDS = Words("torque", "N m", "rated_torque", "rated_torque [N m, of the motor]")


def read_object(text: str, name: str) -> c.Entry:
    """The object that "index:sub type" names, such as "0x30D1:2 int32", which measures what `name` says.

    Raises BadSettings if the text is of another form, or the object is none that can be in a PDO.
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
    """What all drives have an object of, "current" or "torque", and the facts about it.

    With "auto", torque is used where a drive has no current object. Raises NotReady, with what to set, if one
    has neither.
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
    raise NotReady(f"{drive.name} has no {current}, {poorer.name} no {c.TORQUE} in its stead. {ADVICE}")


def find_effort(drive: Drive, wanted: EffortSettings, kind: str) -> Effort:
    """The object of a drive that measures "current" or "torque", and its unit.

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
            f"{drive.name} answers {size} bytes for {entry}, its type here has {expected}. Set the type in "
            "current_object that the drive's manual names"
        )


def _in_thousandths(drive: Drive, entry: c.Entry, rating: c.Entry, own: float, words: Words) -> Effort:
    """An object in thousandths of a rated value, which is set, or read from the drive."""
    value = drive.look_up(rating)
    stated = STEP * (value or 0)
    if not own and not stated:
        lacking = f"has no {rating}" if value is None else f"has {rating} = 0"
        raise NotReady(
            f"{drive.name} {lacking}, in thousandths of which its {words.name} is. Set {words.instead}, "
            "or commission the drive with its maker's tool"
        )
    rated, source = (own, words.setting) if own else (stated, f"0x{rating.index:04X}")
    differs = own and stated and abs(own - stated) > STEP
    warning = f"{drive.name} has {stated:g} {words.unit} in {rating}; {words.setting} = {own:g} is used"
    fact = f"{entry}, in thousandths of {rated:g} {words.unit} ({source})"
    return Effort(entry, 1e-3 * rated, fact, (warning,) if differs else ())
