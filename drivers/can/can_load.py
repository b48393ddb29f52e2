"""Load of a CAN bus: what the frames of one cycle need at worst, and whether the bus can carry them."""

import math
from collections.abc import Sequence

from ..errors import BadSettings

FULL = 0.95
"""Share of a bus that can be used [-]; the rest is for frames that are sent again, errors and set-up."""


def frame_bits(data: int) -> int:
    """Bits that a classic frame with an 11-bit identifier and so many bytes of data has at most.

    These are 44 of frame, 3 of silence after it, 8 a byte, and a stuffing bit after every four of those that
    are stuffed (identifier, length, data and checksum).
    """
    return 47 + 8 * data + (34 + 8 * data - 1) // 4


def bus_load(frames: Sequence[int], cycle: float, bitrate: int, others: float = 0.0) -> float:
    """Worst-case share of the bus that is in use [-]; above one it cannot be carried.

    Args:
        frames: Bytes of data of every frame in a cycle.
        cycle: Time between cycles [s].
        bitrate: Of the bus [bit/s].
        others: Frames a second besides, of one byte each [1/s].
    """
    return (sum(frame_bits(data) for data in frames) / cycle + others * frame_bits(1)) / bitrate


def require_room(frames: Sequence[int], cycle: float, bitrate: int, others: float = 0.0) -> float:
    """The load, where the bus can carry it.

    Raises:
        BadSettings: It cannot.
    """
    load = bus_load(frames, cycle, bitrate, others)
    if load > FULL:
        fits = math.ceil(1e3 * cycle * load / FULL) * 1e-3
        raise BadSettings(
            f"{len(frames)} frames a cycle at {1.0 / cycle:g} Hz need up to {100.0 * load:.0f} % of "
            f"{bitrate / 1e3:g} kbit/s, usable are {100.0 * FULL:.0f} %. Try cycle = {fits:g}, a bitrate of "
            f"{math.ceil(bitrate * load / FULL / 1e5) / 10.0:g} Mbit/s or more (1 Mbit/s is the most of "
            "classic CAN), or fewer joints on this bus"
        )
    return load
