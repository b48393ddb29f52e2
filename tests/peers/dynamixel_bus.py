"""Dynamixel X servos on a pseudo-terminal, one for each joint of a simulated arm.

    python tests/peers/dynamixel_bus.py --robot cobot         prints "ready /dev/pts/N"

Written from the protocol's description, with a checksum and a stuffing of its own. What goes wrong is sent
through standard input, as in `servo_line.py`. Ends when its standard input does.
"""

import struct

import numpy as np
from arm import make_plant
from served import schedule
from servo_line import ServoLine, arguments
from servo_units import GEARS

PING, READ, WRITE, STATUS, SYNC_READ, SYNC_WRITE, FAST = 1, 2, 3, 0x55, 0x82, 0x83, 0x8A
HEADER = bytes([0xFF, 0xFF, 0xFD])
FIRMWARE, DELAY, MODE, HIGH, LOW, SHUTDOWN, TORQUE, LEVEL, HARDWARE = 6, 9, 11, 48, 52, 63, 64, 68, 70
WATCHDOG, GOAL, CURRENT, VELOCITY, POSITION, VOLTAGE, TEMPERATURE = 98, 116, 126, 128, 132, 144, 146
SIZES = {116: 4, 108: 4, 112: 4, 98: 1, 64: 1}
END = 148  # behind it are no registers that could be read
CURRENT_UNIT, VELOCITY_UNIT = 2.69e-3, 0.229 * 2.0 * np.pi / 60.0


def crc(data):
    value = 0
    for byte in data:
        value ^= byte << 8
        for _ in range(8):
            value = (value << 1) ^ (0x18005 if value & 0x8000 else 0)
    return value


CRC = [crc([byte]) for byte in range(256)]


def quick_crc(data, value=0):
    for byte in data:
        value = ((value & 0xFF) << 8) ^ CRC[(value >> 8) ^ byte]
    return value


def stuffed(data):
    out = bytearray()
    for byte in data:
        out.append(byte)
        if bytes(out[-3:]) == HEADER:
            out.append(0xFD)
    return bytes(out)


def unstuffed(data):
    out, skip = bytearray(), False
    for byte in data:
        if skip:
            skip = False
            continue
        out.append(byte)
        skip = bytes(out[-3:]) == HEADER
    return bytes(out)


class Dynamixels(ServoLine):
    """Their registers and instructions."""

    def __init__(self, plant, options):
        super().__init__(plant, options, GEARS["dynamixel"])
        self.tables = [bytearray(256) for _ in self.ids]
        for servo, table in zip(self.ids, self.tables, strict=True):
            struct.pack_into("<H4xBB", table, 0, 1030, 46, servo)
            table[DELAY], table[MODE], table[SHUTDOWN] = options.return_delay, options.mode, 0x34
            struct.pack_into("<ii", table, HIGH, 4095, 0)
        for place, _ in enumerate(self.tables):
            self.reboot(place)
            self.tables[place][TORQUE] = options.torque
        self.sense()

    def reboot(self, place):
        self.tables[place][TORQUE:] = bytes(192)
        table = self.tables[place]
        table[LEVEL] = 2
        struct.pack_into("<ii", table, 108, 100, 200)  # a profile that a host must take away
        self.arm.stay(np.arange(len(self.ids)) == place)
        self.sense()

    def hardware_error(self, place, bits):
        table = self.tables[place]
        table[HARDWARE] = bits
        if bits & table[SHUTDOWN]:
            table[TORQUE] = 0
            self.arm.stay(np.arange(len(self.ids)) == place)

    def sense(self):
        """Put into the registers what the sensors measure."""
        seen = self.arm.plant.measure()
        currents = np.clip(np.rint(self.direction * seen.current / CURRENT_UNIT), -32768, 32767).astype(int)
        speeds = np.rint(self.direction * self.gear * seen.velocity / VELOCITY_UNIT).astype(int)
        rows = zip(self.tables, currents, speeds, self.shown_counts(2**31 - 1), seen.temperature, strict=True)
        for table, current, speed, position, temperature in rows:
            if self.mirror:
                position = struct.unpack_from("<i", table, GOAL)[0]
            struct.pack_into("<hii", table, CURRENT, current, speed, position)
            struct.pack_into("<HB", table, VOLTAGE, 120, int(temperature))

    def watch(self, now):
        """The bus watchdog of each servo."""
        for place, table in enumerate(self.tables):
            if (
                table[TORQUE]
                and 0 < table[WATCHDOG] < 128
                and now - self.received_at > 0.02 * table[WATCHDOG]
            ):
                table[WATCHDOG] = 0xFF
                self.arm.stay(np.arange(len(self.ids)) == place)

    def write(self, place, address, data):
        """Change registers; the number of the error, if there is one."""
        table = self.tables[place]
        if address < TORQUE and table[TORQUE]:
            return 7
        if len(data) < SIZES.get(address, 1):
            return 5
        if address == GOAL:
            return self.take_goal(place, data)
        table[address : address + len(data)] = data
        if address == TORQUE and not data[0]:
            self.arm.stay(np.arange(len(self.ids)) == place)
        return 0

    def take_goal(self, place, data):
        table, goal = self.tables[place], struct.unpack("<i", data)[0]
        if table[WATCHDOG] > 127:
            return 4
        high, low = struct.unpack_from("<ii", table, HIGH)
        if table[MODE] == 3 and not low <= goal <= high:
            return 6
        table[GOAL : GOAL + 4] = data
        if table[TORQUE]:
            self.arm.goal = self.arm.goal.copy()
            self.arm.goal[place] = (goal - self.zero[place]) / self.per_radian[place]
        if self.mirror:
            self.sense()
        return 0

    def understand(self, data):
        """Execute the packets in these bytes, and return what is not whole yet."""
        while (start := data.find(HEADER + b"\0")) >= 0 and len(data) >= start + 7:
            end = start + 7 + int.from_bytes(data[start + 5 : start + 7], "little")
            if len(data) < end:
                return data[start:]
            packet, data = data[start:end], data[end:]
            if quick_crc(packet[:-2]) == int.from_bytes(packet[-2:], "little"):
                self.do(packet[4], packet[7], unstuffed(packet[8:-2]))
        return data[start:] if start >= 0 else data[-3:]

    def do(self, servo, instruction, given):
        if instruction in (SYNC_READ, FAST):
            self.read_all(instruction, *struct.unpack_from("<HH", given), given[4:])
        elif instruction == SYNC_WRITE:
            self.write_all(*struct.unpack_from("<HH", given), given[4:])
        elif servo in self.ids:
            self.do_one(self.ids.index(servo), instruction, given)

    def do_one(self, place, instruction, given):
        table, error, data = self.tables[place], 0, b""
        if instruction == PING:
            data = bytes([*table[0:2], table[FIRMWARE]])
        elif instruction == READ:
            address, length = struct.unpack("<HH", given)
            data = table[address : address + length]
        elif instruction == WRITE:
            error = self.write(place, int.from_bytes(given[:2], "little"), given[2:])
        else:
            error = 2
        if instruction == PING or table[LEVEL] > (instruction == WRITE):
            self.answer([(self.ids[place], self.status(place, error, data))], 2e-6 * table[DELAY])

    def read_all(self, instruction, address, length, asked):
        places = [self.ids.index(servo) for servo in asked if servo in self.ids]
        delay = 2e-6 * sum(self.tables[place][DELAY] for place in places)
        if address + length > END:
            self.answer([(self.ids[place], self.status(place, 7, b"")) for place in places], delay)
        elif instruction == SYNC_READ:
            answers = [
                (self.ids[p], self.status(p, 0, self.tables[p][address : address + length])) for p in places
            ]
            self.answer(answers, delay)
        elif self.tables[0][FIRMWARE] >= 45:
            self.answer(self.joined(places, address, length), delay)

    def joined(self, places, address, length):
        """The parts of the answer to a fast read; behind a silent servo it ends."""
        total = 1 + len(places) * (4 + length)
        sent, parts = HEADER + bytes([0, 0xFE, *total.to_bytes(2, "little"), STATUS]), []
        check, part = quick_crc(sent), sent
        for place in places:
            if self.ids[place] in self.silent:
                break
            error = self.error_byte(place)
            own = bytes([error, self.ids[place], *self.tables[place][address : address + length]])
            check = quick_crc(own, check)
            mark = check.to_bytes(2, "little")
            check = quick_crc(mark, check)
            parts.append((self.ids[place], part + own + mark))
            part = b""
        return parts

    def error_byte(self, place, number=0):
        alert = 0x80 if self.tables[place][HARDWARE] else 0
        return alert | (number or self.refusing.get(self.ids[place], 0))

    def status(self, place, error, data):
        body = stuffed(bytes([STATUS, self.error_byte(place, error), *data]))
        head = HEADER + bytes([0, self.ids[place], *(len(body) + 2).to_bytes(2, "little")])
        return head + body + quick_crc(head + body).to_bytes(2, "little")


def main():
    options = arguments(mode=4).parse_args()
    plant = make_plant(options.robot)
    schedule()
    Dynamixels(plant, options).run()


if __name__ == "__main__":
    main()
