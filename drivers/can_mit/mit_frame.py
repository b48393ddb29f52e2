"""Frame of the MIT mini-cheetah motors, which Damiao, T-Motor (CubeMars) and others have adopted.

A frame commands a torque, kp (position - measured) + kd (velocity - measured) + torque, and the motor answers
with its measurements. All values are integers of 12 or 16 bits over a range that motor and host must agree
on.
"""

from typing import NamedTuple

KP, KD = 500.0, 5.0
"""Largest gains that fit into a frame [N m/rad], [N m s/rad]."""

ENABLE, DISABLE, CLEAR = (b"\xff" * 7 + bytes([last]) for last in (0xFC, 0xFD, 0xFB))
"""Frames that switch a motor on, off, and clear its error."""


class Ranges(NamedTuple):
    """Largest magnitude of position [rad], velocity [rad/s], and torque [N m] or current [A] in a frame."""

    position: float
    velocity: float
    torque: float


class Family(NamedTuple):
    """A maker, and whether the registers of its motors can be read and written over the bus."""

    name: str
    registers: bool


DAMIAO = Family("Damiao", True)
T_MOTOR = Family("T-Motor", False)

MODELS: dict[str, tuple[Family, Ranges]] = {
    "DM4310": (DAMIAO, Ranges(12.5, 30.0, 10.0)),
    "DM4340": (DAMIAO, Ranges(12.5, 8.0, 28.0)),
    "DM6006": (DAMIAO, Ranges(12.5, 45.0, 20.0)),
    "DM8009": (DAMIAO, Ranges(12.5, 45.0, 54.0)),
    "AK10-9": (T_MOTOR, Ranges(12.5, 50.0, 65.0)),
    "AK60-6": (T_MOTOR, Ranges(12.5, 45.0, 15.0)),
    "AK70-10": (T_MOTOR, Ranges(12.5, 50.0, 25.0)),
    "AK80-6": (T_MOTOR, Ranges(12.5, 76.0, 12.0)),
    "AK80-8": (T_MOTOR, Ranges(12.5, 37.5, 32.0)),
    "AK80-9": (T_MOTOR, Ranges(12.5, 50.0, 18.0)),
    "AK80-64": (T_MOTOR, Ranges(12.5, 8.0, 144.0)),
}
"""Model -> maker, and ranges as delivered."""


class Motor(NamedTuple):
    """A motor on the bus."""

    name: str  # name in messages
    number: int  # identifier of its commands
    master: int  # identifier of its answers
    family: Family  # maker of the motor
    commanded: Ranges  # ranges of its commands
    answered: Ranges  # ranges of its answers
    kp: float  # stiffness [N m/rad]
    kd: float  # damping [N m s/rad]


class State(NamedTuple):
    """Answer of a motor: the maker's error code, and measurements at the output.

    Position is in [rad], velocity in [rad/s], torque in [N m] or [A], temperature in [degC]; NaN if not sent.
    """

    error: int
    position: float
    velocity: float
    torque: float
    temperature: float


def raw(value: float, low: float, high: float, bits: int) -> int:
    """Integer nearest to a value; values outside the range become its ends."""
    most = (1 << bits) - 1
    return min(max(round((value - low) / (high - low) * most), 0), most)


def pack(
    ranges: Ranges, position: float, velocity: float, kp: float, kd: float, torque: float = 0.0
) -> bytes:
    """Encode a command, in the units of `Ranges`; the gains are in [N m/rad] and [N m s/rad]."""
    return with_motion(ranges, position, velocity, gains(ranges, kp, kd, torque))


def gains(ranges: Ranges, kp: float, kd: float, torque: float = 0.0) -> int:
    """Encode gains and torque, the last 36 bits of a command, which do not change from cycle to cycle."""
    number = raw(kp, 0.0, KP, 12) << 12 | raw(kd, 0.0, KD, 12)
    return number << 12 | raw(torque, -ranges.torque, ranges.torque, 12)


def with_motion(ranges: Ranges, position: float, velocity: float, last: int) -> bytes:
    """Encode a command whose last 36 bits come from `gains`."""
    number = raw(position, -ranges.position, ranges.position, 16) << 12
    number |= raw(velocity, -ranges.velocity, ranges.velocity, 12)
    return (number << 36 | last).to_bytes(8, "big")


def unpack(ranges: Ranges, family: Family, data: bytes) -> State | None:
    """Decode an answer, except its identifier; None if it is not an answer.

    Damiao: identifier and error share the first byte, temperatures of the power stage and of the rotor are
    the last two. T-Motor: the identifier has the first byte, and newer firmware adds temperature and error.
    """
    if len(data) != 8 and (family is DAMIAO or len(data) != 6):
        return None
    number = int.from_bytes(data[1:6], "big")
    most, fast, strong = ranges
    position = (number >> 24) * (2.0 * most) / 0xFFFF - most
    velocity = (number >> 12 & 0xFFF) * (2.0 * fast) / 0xFFF - fast
    torque = (number & 0xFFF) * (2.0 * strong) / 0xFFF - strong
    if family is DAMIAO:
        return State(data[0] >> 4, position, velocity, torque, float(data[7]))
    if len(data) == 6:
        return State(0, position, velocity, torque, float("nan"))
    celsius = int.from_bytes(data[6:7], "big", signed=True)
    return State(data[7], position, velocity, torque, float(celsius))


def answering(family: Family, data: bytes) -> int:
    """Identifier in an answer: the first byte, or its lower half for Damiao."""
    return data[0] & 0x0F if family is DAMIAO else data[0]


OFF, ON = 0, 1
"""Codes of Damiao that are not errors."""
ERRORS = {
    DAMIAO: {
        5: "encoder", 6: "parameters", 8: "over-voltage", 9: "under-voltage", 10: "over-current",
        11: "power stage too hot", 12: "rotor too hot", 13: "host silent", 14: "overload"
    },
    T_MOTOR: {
        1: "motor too hot", 2: "over-current", 3: "over-voltage", 4: "under-voltage", 5: "encoder",
        6: "power stage too hot or phases unbalanced", 7: "motor blocked"
    },
}  # fmt: skip


def error_text(family: Family, code: int) -> str:
    """Description of an error; empty without an error."""
    if code == OFF or (family is DAMIAO and code == ON):
        return ""
    return f"error {code} ({ERRORS[family].get(code, 'unknown')})"
