"""Set-up of one CiA 402 drive for cyclic synchronous position; every written value is read back."""

import math
from dataclasses import dataclass, field

import numpy as np

from ..driver import Arm
from ..errors import NotReady
from . import cia402 as c
from .drive import Drive, Effort, Refused
from .frames import beside
from .settings import CanopenSettings

INVALID = 0x80000000
"""Bit of a PDO's identifier that switches the PDO off."""
NO_REMOTE = 0x40000000
"""Bit of a PDO's identifier that forbids remote requests; it keeps the drive's value."""
SYNCHRONOUS = 1
"""Transmission type: with every SYNC."""
MODE_READS = 20
"""Number of further reads of the mode, every 10 ms, until the drive has changed it."""
SHOWN = 3
"""Maximum number of old errors in a warning."""
SPARE_TPDOS = (0x1801, 0x1802, 0x1803)
"""TPDOs that are switched off; the first is switched on again if an effort needs a separate TPDO."""
SPARE_RPDOS = (0x1401, 0x1402, 0x1403)
"""RPDOs through which other devices could command the drive."""


@dataclass
class DriveData:
    """Data of a drive."""

    guarded: bool = False  # whether it is verified that the drive stops by itself when the host falls silent
    beats: bool = False  # whether the drive sends a heartbeat
    position: int = 0  # position at set-up [counts]
    facts: list[str] = field(default_factory=list)  # facts that explain the measurements later
    warnings: list[str] = field(default_factory=list)  # warnings, a sentence each


def inspect(drive: Drive) -> DriveData:
    """Read the identity, state and position of a drive, and clear its error history.

    Raises NotReady if it is not a CiA 402 drive or in use elsewhere, LinkLost if it does not answer.
    """
    data = DriveData()
    _identify(drive, data)
    _check_state(drive, data)
    data.position = drive.read(c.POSITION)
    return data


def set_up(
    drive: Drive, settings: CanopenSettings, arm: Arm, joint: int, effort: Effort, data: DriveData
) -> None:
    """Set up the pre-operational drive of a joint, and add to its data; nothing moves and nothing is powered.

    Raises NotReady if it refuses a required setting, LinkLost if it does not answer.
    """
    data.facts.append(effort.fact)
    data.warnings += effort.warnings
    _set_mode(drive, data)
    _set_cycle(drive, settings, data)
    _set_guard(drive, settings, data)
    _set_limits(drive, settings, arm, joint, data)
    _map_pdos(drive, settings.nodes[joint], effort.entry, data)


def _identify(drive: Drive, data: DriveData) -> None:
    profile = drive.read(c.DEVICE_TYPE) & 0xFFFF
    if profile != c.PROFILE:
        raise NotReady(f"{drive.name} has device profile {profile}; drives have {c.PROFILE} (CiA 402)")
    for entry in (c.VENDOR, c.PRODUCT, c.REVISION, c.SERIAL):
        value = drive.look_up(entry)
        if value is not None:
            data.facts.append(f"{entry.name} 0x{value:08X}")
    name = drive.text()
    if name:
        data.facts.append(f"'{name}'")


def require_not_enabled(drive: Drive) -> None:
    """Raise NotReady if a drive follows another controller, whose network must not be restarted.

    Raises LinkLost if it does not answer.
    """
    word = drive.read(c.STATUSWORD)
    if c.state(word) == c.ENABLED:
        raise NotReady(
            f"{drive.name} is in {c.ENABLED} already (statusword 0x{word:04X}): another controller moves it. "
            "Stop that controller first"
        )


def _check_state(drive: Drive, data: DriveData) -> None:
    require_not_enabled(drive)
    state = c.state(drive.read(c.STATUSWORD))
    if state == c.FAULT:
        code = drive.look_up(c.ERROR_CODE)
        why = "" if code is None else f" {c.error_text(code)}"
        data.warnings.append(f"{drive.name} was in fault{why}; it is reset when the drives are armed")
    _read_history(drive, data)


def _read_history(drive: Drive, data: DriveData) -> None:
    """Report old errors and clear them, so that later errors belong to the next run."""
    count = drive.look_up(c.ERROR_COUNT)
    if not count:
        return
    places = range(1, min(count, SHOWN) + 1)
    entries = [c.Entry(c.ERROR_COUNT.index, place, "<I", "old error") for place in places]
    codes = [c.error_text(code & 0xFFFF) for code in map(drive.look_up, entries) if code is not None]
    errors = "1 error" if count == 1 else f"{count} errors"
    data.warnings.append(f"{drive.name} had {errors} in its history, now cleared: {', '.join(codes)}")
    try:
        drive.write(c.ERROR_COUNT, 0)
    except NotReady as error:
        data.warnings.append(str(error))


def _set_mode(drive: Drive, data: DriveData) -> None:
    modes = drive.look_up(c.SUPPORTED_MODES)
    if modes is not None and not modes >> (c.CYCLIC_POSITION - 1) & 1:
        raise NotReady(
            f"{drive.name} does not offer cyclic synchronous position (mode {c.CYCLIC_POSITION}); 0x6502 is "
            f"0x{modes:08X}. Update its firmware, or choose another drive"
        )
    drive.write(c.MODE, c.CYCLIC_POSITION)
    shown, patience = drive.read(c.MODE_DISPLAY), MODE_READS
    while shown != c.CYCLIC_POSITION and patience:
        drive.clock.sleep(0.01)
        shown, patience = drive.read(c.MODE_DISPLAY), patience - 1
    if shown != c.CYCLIC_POSITION:
        raise NotReady(f"{drive.name} was set to mode {c.CYCLIC_POSITION} and is in mode {shown} (0x6061)")


def _set_cycle(drive: Drive, settings: CanopenSettings, data: DriveData) -> None:
    """Set the time between targets: 0x60C2, or 0x1006 if the drive takes that instead."""
    if drive.look_up(c.SYNC_ID) not in (None, c.SYNC):
        drive.set(c.SYNC_ID, c.SYNC)
    refused = ""
    known = drive.look_up(c.SYNC_PERIOD) is not None
    if known:
        refused = drive.offer(c.SYNC_PERIOD, round(1e6 * settings.cycle))
        data.warnings += filter(None, [refused])
    if drive.size(c.PERIOD_VALUE) is None:
        data.warnings.append(
            f"{drive.name} has no {c.PERIOD_VALUE}: with its maker's tool, set its time between targets to "
            f"{1e3 * settings.cycle:g} ms{', unless it uses 0x1006' * (known and not refused)}"
        )
        return
    period = c.period_of(settings.cycle)
    assert period is not None  # checked by `require_sound`
    for entry, value in zip((c.PERIOD_VALUE, c.PERIOD_POWER), period, strict=True):
        drive.set(entry, value)


def _set_guard(drive: Drive, settings: CanopenSettings, data: DriveData) -> None:
    """Make the drive stop by itself when the host falls silent, and record whether it will."""
    missing = [
        drive.offer(c.CONSUMER_HEARTBEAT, settings.host_node << 16 | round(1e3 * settings.dead_man)),
        drive.offer(c.ABORT_CONNECTION, settings.abort_connection),
    ]
    data.guarded = not any(missing)
    if not data.guarded:
        why = f"{', '.join(filter(None, missing))}: nothing makes it stop by itself when this computer dies"
        if settings.require_dead_man:
            raise NotReady(
                f"{why}. Set require_dead_man = false to continue, with a hand on the emergency stop"
            )
        data.warnings.insert(0, why)
    stops = [
        drive.offer(c.QUICK_STOP_OPTION, settings.quick_stop),
        drive.offer(c.FAULT_REACTION, settings.fault_reaction),
    ]
    data.warnings += filter(None, stops)
    silent = drive.offer(c.OWN_HEARTBEAT, round(1e3 * settings.heartbeat))
    data.beats = not silent
    if silent:
        data.warnings.append(f"{silent}: only its measurements show that it is there")


def _set_limits(drive: Drive, settings: CanopenSettings, arm: Arm, joint: int, data: DriveData) -> None:
    """Set following error and position limits [counts], unless the drive keeps its own."""
    window = round(abs(settings.following_error[joint] * settings.per_radian[joint]))
    if window:
        _set_or_advise(drive, c.FOLLOWING_WINDOW, window, "following_error = 0")
        data.warnings += filter(None, [drive.offer(c.FOLLOWING_TIME, round(1e3 * settings.following_time))])
    low, high = sorted(settings.to_counts(np.array([arm.position_lower, arm.position_upper]))[:, joint])
    if settings.write_limits and math.isfinite(low) and math.isfinite(high):
        _set_or_advise(drive, c.LOWER_LIMIT, math.ceil(low), "write_limits = false")
        _set_or_advise(drive, c.UPPER_LIMIT, math.floor(high), "write_limits = false")


def _set_or_advise(drive: Drive, entry: c.Entry, value: int, without: str) -> None:
    why = drive.offer(entry, value)
    if why:
        raise NotReady(f"{why}. Set {without} to continue without it")


def _map_pdos(drive: Drive, node: int, effort: c.Entry, data: DriveData) -> None:
    for index in SPARE_TPDOS:
        _switch_off(drive, index)
    for index in SPARE_RPDOS:
        try:
            _switch_off(drive, index)
        except NotReady as refusal:
            data.warnings.append(f"{refusal}: frames of others with that identifier command it")
    _map(drive, 0x1400, 0x1600, c.RPDO1 + node, (c.CONTROLWORD, c.TARGET))
    if beside(effort):
        _map(drive, 0x1800, 0x1A00, c.TPDO1 + node, (c.STATUSWORD, c.POSITION, effort))
    else:
        _map(drive, 0x1800, 0x1A00, c.TPDO1 + node, (c.STATUSWORD, c.POSITION))
        _map(drive, 0x1801, 0x1A01, c.TPDO2 + node, (effort,))


def _switch_off(drive: Drive, communication: int) -> None:
    switch = c.Entry(communication, 1, "<I", "identifier of a spare PDO")
    if drive.size(switch) is None:
        return
    value = drive.read(switch)
    if not value & INVALID:
        drive.set(switch, value | INVALID)


def _map(
    drive: Drive, communication: int, mapping: int, identifier: int, values: tuple[c.Entry, ...]
) -> None:
    switch = c.Entry(communication, 1, "<I", "identifier of a PDO")
    others = drive.read(switch) & NO_REMOTE
    drive.write(switch, INVALID | others | identifier)
    drive.set(c.Entry(communication, 2, "<B", "transmission type"), SYNCHRONOUS)
    count = c.Entry(mapping, 0, "<B", "number of values in a PDO")
    drive.write(count, 0)
    for place, entry in enumerate(values, 1):
        try:
            drive.set(c.Entry(mapping, place, "<I", "value in a PDO"), entry.mapping)
        except Refused as refusal:  # the drive has no such entry, or cannot map it
            raise NotReady(f"{drive.name} takes {entry} into no PDO: {refusal.why}") from refusal
    drive.set(count, len(values))
    drive.set(switch, others | identifier)
