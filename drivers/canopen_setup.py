"""Set-up of one CiA 402 drive for cyclic synchronous position: all that is written is read back."""

import time
from dataclasses import dataclass, field
from typing import NamedTuple

from . import cia402 as c
from .canopen_drive import Drive
from .errors import NotReady

INVALID = 0x80000000
"""Bit of a PDO's identifier that switches the PDO off."""
NO_REMOTE = 0x40000000
"""Bit of a PDO's identifier that is the drive's own business: the PDO cannot be asked for."""
SYNCHRONOUS = 1
"""Transmission type: with every SYNC."""
MODE_READS = 20
"""How often a drive is asked again whether it is in the mode it was told, every 10 ms."""
SHOWN = 3
"""Old errors that are told of."""
SPARE_TPDOS = (0x1801, 0x1802, 0x1803)
"""TPDOs that this driver does not want on its bus."""


class Wish(NamedTuple):
    """What a drive is to be set to, in its own units.

    Attributes:
        node: Its number.
        host: Number under which the host sends its heartbeat.
        cycle: Time between SYNCs [s].
        effort: `cia402.CURRENT` or `cia402.TORQUE`.
        dead_man: Silence of the host after which the drive stops by itself [s].
        heartbeat: Time between its own heartbeats [s].
        quick_stop: Value of 0x605A.
        fault_reaction: Value of 0x605E.
        abort_connection: Value of 0x6007.
        following_window: Counts; None leaves the drive's own.
        following_time: For so long it may be beyond the window [s].
        limits: Lowest and highest position in counts; None leaves the drive's own.
    """

    node: int
    host: int
    cycle: float
    effort: c.Entry
    dead_man: float
    heartbeat: float
    quick_stop: int
    fault_reaction: int
    abort_connection: int
    following_window: int | None
    following_time: float
    limits: tuple[int, int] | None


@dataclass
class Found:
    """What a drive said of itself.

    Attributes:
        rated: What a thousand of `effort` mean [A] or, at the motor, [N m].
        guarded: Whether it is verified that the drive stops by itself when the host falls silent.
        position: Where it stands, in counts.
        facts: What explains the measurement later.
        warnings: Doubts, a sentence each.
    """

    rated: float = 0.0
    guarded: bool = False
    position: int = 0
    facts: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def set_up(drive: Drive, wish: Wish) -> Found:
    """Set a drive up. It must be pre-operational; nothing moves and nothing is powered.

    Raises:
        NotReady: It is no such drive, in use by somebody else, or does not take what it must.
        LinkLost: It does not answer.
    """
    found = Found()
    _identify(drive, found)
    _look_at_state(drive, found)
    _set_rating(drive, wish, found)
    _set_mode(drive, wish, found)
    _set_guard(drive, wish, found)
    _set_limits(drive, wish)
    _map_pdos(drive, wish)
    found.position = drive.read(c.POSITION)
    return found


def _identify(drive: Drive, found: Found) -> None:
    profile = drive.read(c.DEVICE_TYPE) & 0xFFFF
    if profile != c.PROFILE:
        raise NotReady(f"{drive.name} has device profile {profile}; drives have {c.PROFILE} (CiA 402)")
    for entry in (c.VENDOR, c.PRODUCT, c.REVISION, c.SERIAL):
        value = drive.look_up(entry)
        if value is not None:
            found.facts.append(f"{entry.name} 0x{value:08X}")
    name = drive.text()
    if name:
        found.facts.append(f"'{name}'")


def _look_at_state(drive: Drive, found: Found) -> None:
    word = drive.read(c.STATUSWORD)
    state = c.state(word)
    if state == c.ENABLED:
        raise NotReady(
            f"{drive.name} is in {state} already (statusword 0x{word:04X}): another controller moves it. "
            "Stop that one first"
        )
    if state == c.FAULT:
        code = drive.look_up(c.ERROR_CODE)
        why = "" if code is None else f" {c.error_text(code)}"
        found.warnings.append(f"{drive.name} was in fault{why}; it is reset when the drives are armed")
    _read_history(drive, found)


def _read_history(drive: Drive, found: Found) -> None:
    """Tell of old errors and clear them, so that those of the next run are its own."""
    count = drive.look_up(c.ERROR_COUNT)
    if not count:
        return
    places = range(1, min(count, SHOWN) + 1)
    entries = [c.Entry(c.ERROR_COUNT.index, place, "<I", "old error") for place in places]
    codes = [c.error_text(code & 0xFFFF) for code in map(drive.look_up, entries) if code is not None]
    found.warnings.append(f"{drive.name} had {count} errors in its history, now cleared: {', '.join(codes)}")
    try:
        drive.write(c.ERROR_COUNT, 0)
    except NotReady as error:
        found.warnings.append(str(error))


def _set_rating(drive: Drive, wish: Wish, found: Found) -> None:
    entry = c.RATED_CURRENT if wish.effort == c.CURRENT else c.RATED_TORQUE
    rated = drive.read(entry)
    if not rated:
        raise NotReady(
            f"{drive.name} has {entry} = 0, in thousandths of which it gives its "
            f"{wish.effort.name.split()[0]}. Commission the drive with its maker's tool"
        )
    found.rated = 1e-3 * rated
    found.facts.append(f"{entry.name} {rated}")


def _set_mode(drive: Drive, wish: Wish, found: Found) -> None:
    modes = drive.look_up(c.SUPPORTED_MODES)
    if modes is not None and not modes >> (c.CYCLIC_POSITION - 1) & 1:
        raise NotReady(
            f"{drive.name} does not offer cyclic synchronous position (mode {c.CYCLIC_POSITION}); 0x6502 is "
            f"0x{modes:08X}. Update its firmware, or choose another drive"
        )
    drive.write(c.MODE, c.CYCLIC_POSITION)
    shown, patience = drive.read(c.MODE_DISPLAY), MODE_READS
    while shown != c.CYCLIC_POSITION and patience:
        time.sleep(0.01)
        shown, patience = drive.read(c.MODE_DISPLAY), patience - 1
    if shown != c.CYCLIC_POSITION:
        raise NotReady(f"{drive.name} was told mode {c.CYCLIC_POSITION} and is in mode {shown} (0x6061)")
    period = c.period_of(wish.cycle)
    assert period is not None  # the driver has seen to that
    for entry, value in zip((c.PERIOD_VALUE, c.PERIOD_POWER), period, strict=True):
        drive.set(entry, value)
    if drive.look_up(c.SYNC_ID) not in (None, c.SYNC):
        drive.set(c.SYNC_ID, c.SYNC)
    if drive.look_up(c.SYNC_PERIOD) is not None:
        found.warnings += filter(None, [drive.offer(c.SYNC_PERIOD, round(1e6 * wish.cycle))])


def _set_guard(drive: Drive, wish: Wish, found: Found) -> None:
    """Make the drive stop by itself when the host dies, and say whether it will."""
    missing = [
        drive.offer(c.HEARD_HEARTBEAT, wish.host << 16 | round(1e3 * wish.dead_man)),
        drive.offer(c.ABORT_CONNECTION, wish.abort_connection),
    ]
    found.guarded = not any(missing)
    missing += [
        drive.offer(c.QUICK_STOP_OPTION, wish.quick_stop),
        drive.offer(c.FAULT_REACTION, wish.fault_reaction),
    ]
    found.warnings += filter(None, missing)
    drive.set(c.OWN_HEARTBEAT, round(1e3 * wish.heartbeat))


def _set_limits(drive: Drive, wish: Wish) -> None:
    if wish.following_window is not None:
        drive.set(c.FOLLOWING_WINDOW, wish.following_window)
        drive.set(c.FOLLOWING_TIME, round(1e3 * wish.following_time))
    if wish.limits is not None:
        for entry, value in zip((c.LOWER_LIMIT, c.UPPER_LIMIT), wish.limits, strict=True):
            drive.set(entry, value)


def _map_pdos(drive: Drive, wish: Wish) -> None:
    for index in SPARE_TPDOS:
        spare = c.Entry(index, 1, "<I", "identifier of a spare TPDO")
        value = drive.look_up(spare)
        if value is not None and not value & INVALID:
            drive.set(spare, value | INVALID)
    _map(drive, 0x1400, 0x1600, c.RPDO1 + wish.node, (c.CONTROLWORD, c.TARGET))
    _map(drive, 0x1800, 0x1A00, c.TPDO1 + wish.node, (c.STATUSWORD, c.POSITION, wish.effort))


def _map(drive: Drive, communication: int, mapping: int, identifier: int, what: tuple[c.Entry, ...]) -> None:
    """Switch a PDO off, say what is in it, and switch it on with every SYNC."""
    switch = c.Entry(communication, 1, "<I", "identifier of a PDO")
    others = drive.read(switch) & NO_REMOTE
    drive.write(switch, INVALID | others | identifier)
    drive.set(c.Entry(communication, 2, "<B", "transmission type"), SYNCHRONOUS)
    count = c.Entry(mapping, 0, "<B", "number of values in a PDO")
    drive.write(count, 0)
    for place, entry in enumerate(what, 1):
        drive.set(c.Entry(mapping, place, "<I", "value in a PDO"), entry.mapping)
    drive.set(count, len(what))
    drive.set(switch, others | identifier)
