"""CiA 402, the device profile of drives on CANopen: objects, states, words and codes, without a bus.

From CiA 301 and CiA 402 (IEC 61800-7-201). Multi-byte values are little-endian.
"""

import struct
from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    """A value in a drive's object dictionary; `form` is its `struct` format, `name` is for messages."""

    index: int
    sub: int
    form: str
    name: str

    def __str__(self) -> str:
        return f"0x{self.index:04X}:{self.sub} ({self.name})"

    @property
    def mapping(self) -> int:
        """This entry in the mapping of a PDO: index, sub-index and length in bits."""
        return self.index << 16 | self.sub << 8 | 8 * struct.calcsize(self.form)


DEVICE_TYPE = Entry(0x1000, 0, "<I", "device type")
ERROR_COUNT = Entry(0x1003, 0, "<B", "number of errors in the history")
SYNC_ID = Entry(0x1005, 0, "<I", "identifier of SYNC")
SYNC_PERIOD = Entry(0x1006, 0, "<I", "period of SYNC in us")
DEVICE_NAME = Entry(0x1008, 0, "", "device name")
CONSUMER_HEARTBEAT = Entry(0x1016, 1, "<I", "heartbeat to listen to")
OWN_HEARTBEAT = Entry(0x1017, 0, "<H", "heartbeat to send")
VENDOR, PRODUCT, REVISION, SERIAL = (
    Entry(0x1018, sub, "<I", name) for sub, name in enumerate(("vendor", "product", "revision", "serial"), 1)
)
ABORT_CONNECTION = Entry(0x6007, 0, "<h", "reaction to a lost connection")
ERROR_CODE = Entry(0x603F, 0, "<H", "error code")
CONTROLWORD = Entry(0x6040, 0, "<H", "controlword")
STATUSWORD = Entry(0x6041, 0, "<H", "statusword")
QUICK_STOP_OPTION = Entry(0x605A, 0, "<h", "how to stop quickly")
FAULT_REACTION = Entry(0x605E, 0, "<h", "reaction to a fault")
MODE = Entry(0x6060, 0, "<b", "mode of operation")
MODE_DISPLAY = Entry(0x6061, 0, "<b", "mode in operation")
POSITION = Entry(0x6064, 0, "<i", "position")
FOLLOWING_WINDOW = Entry(0x6065, 0, "<I", "following error window")
FOLLOWING_TIME = Entry(0x6066, 0, "<H", "following error time-out in ms")
RATED_CURRENT = Entry(0x6075, 0, "<I", "rated current in mA")
RATED_TORQUE = Entry(0x6076, 0, "<I", "rated torque in mN m")
TORQUE = Entry(0x6077, 0, "<h", "torque in thousandths of rated")
TARGET = Entry(0x607A, 0, "<i", "target position")
LOWER_LIMIT = Entry(0x607D, 1, "<i", "lowest position")
UPPER_LIMIT = Entry(0x607D, 2, "<i", "highest position")
PERIOD_VALUE = Entry(0x60C2, 1, "<B", "interpolation time")
PERIOD_POWER = Entry(0x60C2, 2, "<b", "power of ten of the interpolation time")
SUPPORTED_MODES = Entry(0x6502, 0, "<I", "supported modes")

CYCLIC_POSITION = 8
"""Mode of operation: cyclic synchronous position, in which the host interpolates."""
PROFILE = 402
"""Device profile of a drive, the lower half of its device type."""

NMT, SYNC = 0x000, 0x080
"""Identifiers of network management and of SYNC."""
EMERGENCY, TPDO1, RPDO1, TPDO2, SDO_TO_NODE, HEARTBEAT = 0x080, 0x180, 0x200, 0x280, 0x600, 0x700
"""Identifiers to which the node's number is added."""
START, PRE_OPERATIONAL = 1, 128
"""Commands of network management."""
NMT_STATES = {0: "starting up", 4: "stopped", 5: "operational", 127: "pre-operational"}
OPERATIONAL = 5

STATES = {
    (0x4F, 0x00): "not ready to switch on",
    (0x4F, 0x40): "switch-on disabled",
    (0x6F, 0x21): "ready to switch on",
    (0x6F, 0x23): "switched on",
    (0x6F, 0x27): "operation enabled",
    (0x6F, 0x07): "quick stop active",
    (0x4F, 0x0F): "fault reaction",
    (0x4F, 0x08): "fault",
}
"""Mask and value of the statusword -> state."""
ENABLED, FAULT, STOPPING = "operation enabled", "fault", "quick stop active"

SHUT_DOWN, SWITCH_ON, ENABLE = 0x06, 0x07, 0x0F
QUICK_STOP, NO_VOLTAGE, RESET_FAULT = 0x02, 0x00, 0x80
"""Controlwords; RESET_FAULT acts on the rising edge of its bit."""
TOWARDS_ENABLED = {
    "switch-on disabled": SHUT_DOWN,
    "ready to switch on": SWITCH_ON,
    "switched on": ENABLE,
    ENABLED: ENABLE,
    STOPPING: ENABLE,
}
"""State -> controlword of the next transition; in other states, wait or reset the fault."""

VOLTAGE = 0x0010
"""Bit of the statusword: the power stage has its supply."""
LIMIT_ACTIVE = 0x0800
"""Bit of the statusword: a limit inside the drive is active."""

EMERGENCIES = {
    0x2310: "continuous over-current", 0x2320: "short circuit", 0x3110: "mains over-voltage",
    0x3120: "mains under-voltage", 0x3210: "DC link over-voltage", 0x3220: "DC link under-voltage",
    0x4210: "drive too hot", 0x4310: "motor too hot", 0x5441: "contactor", 0x5530: "data storage",
    0x6320: "parameter error", 0x7121: "motor blocked", 0x7305: "first encoder", 0x7306: "second encoder",
    0x7500: "communication", 0x8110: "CAN frames lost", 0x8120: "CAN error-passive", 0x8130: "heartbeat lost",
    0x8140: "back from bus-off", 0x8180: "SYNC", 0x8210: "PDO of a wrong length", 0x8400: "velocity control",
    0x8611: "following error", 0x8612: "reference limit", 0x8700: "SYNC does not fit the cycle",
}  # fmt: skip
KINDS = {
    0x10: "generic", 0x20: "current", 0x21: "input current", 0x22: "inner current", 0x23: "output current",
    0x30: "voltage", 0x40: "temperature", 0x50: "hardware", 0x60: "software", 0x70: "additional modules",
    0x80: "monitoring", 0x90: "external", 0xF0: "additional functions", 0xFF: "of the manufacturer's own",
}  # fmt: skip


def state(statusword: int) -> str:
    """State of a drive, from its statusword."""
    for (mask, value), name in STATES.items():
        if statusword & mask == value:
            return name
    return "a state that CiA 402 does not define"


def error_text(code: int) -> str:
    """Description of an error code."""
    text = EMERGENCIES.get(code) or KINDS.get(code >> 8) or KINDS.get(code >> 8 & 0xF0, "unknown")
    return f"0x{code:04X} ({text})"


def period_of(cycle: float) -> tuple[int, int] | None:
    """Interpolation time of a cycle [s] as value and power of ten; None if a drive cannot represent it."""
    for power in (-3, -4, -5):
        value = round(cycle / 10.0**power)
        if 0 < value < 256 and abs(value * 10.0**power - cycle) < 1e-9:
            return value, power
    return None
