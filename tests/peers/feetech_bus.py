"""Feetech STS servos on a pseudo-terminal, one for each joint of a simulated arm.

    python tests/peers/feetech_bus.py --robot cobot         prints "ready /dev/pts/N"

What goes wrong is sent through standard input, as in `servo_line.py`. Ends when its standard input does.
"""

import struct

import numpy as np
from arm import make_plant
from served import schedule
from servo_line import ServoLine, arguments
from servo_units import GEARS, TURN

PING, READ, WRITE, SYNC_READ, SYNC_WRITE = 1, 2, 3, 0x82, 0x83
HEADER = b"\xff\xff"
DELAY, LEVEL, LIMITS, PHASE, UNLOADING, MODE, TORQUE = 7, 8, 9, 18, 19, 33, 40
GOAL, LOCK, POSITION, VOLTAGE, STATUS, CURRENT = 42, 55, 56, 62, 65, 69
CURRENT_UNIT = 6.5e-3


def with_sign(number):
    return min(abs(int(number)), 0x7FFF) | (0x8000 if number < 0 else 0)


class Feetechs(ServoLine):
    """Their registers and instructions."""

    def __init__(self, plant, options):
        super().__init__(plant, options, options.gear)
        self.tables = [bytearray(128) for _ in self.ids]
        for servo, table in zip(self.ids, self.tables, strict=True):
            struct.pack_into("<BBBHBBBBHH", table, 0, 3, 10, 0, 777, servo, 0, options.return_delay, 1, 0, 0)
            table[PHASE], table[UNLOADING], table[MODE] = options.phase, 0x2C, options.mode
        for place, _ in enumerate(self.tables):
            self.reboot(place)
            self.tables[place][TORQUE] = options.torque
        self.unit = 1.0 if options.phase & 4 else 50.0
        self.sense()

    def reboot(self, place):
        self.tables[place][TORQUE:] = bytes(128 - TORQUE)
        self.tables[place][LOCK] = 1
        self.arm.stay(np.arange(len(self.ids)) == place)

    def hardware_error(self, place, bits):
        self.tables[place][STATUS] = bits

    def sense(self):
        """Put into the registers what the sensors measure."""
        seen = self.arm.plant.measure()
        currents = np.rint(self.direction * seen.current / CURRENT_UNIT)
        speeds = np.rint(self.direction * self.gear * seen.velocity * TURN / (2.0 * np.pi) / self.unit)
        rows = zip(self.tables, currents, speeds, self.shown_counts(0x7FFF), seen.temperature, strict=True)
        for table, current, speed, position, temperature in rows:
            here = struct.unpack_from("<H", table, GOAL)[0] if self.mirror else with_sign(position)
            struct.pack_into("<HHHBB", table, POSITION, here, with_sign(speed), 0, 74, int(temperature))
            struct.pack_into("<H", table, CURRENT, with_sign(current))

    def watch(self, now):
        """These servos watch nothing."""

    def write(self, place, address, data):
        table = self.tables[place]
        if address < TORQUE and table[LOCK]:
            return
        table[address : address + len(data)] = data
        mine = np.arange(len(self.ids)) == place
        if address == TORQUE and not data[0]:
            self.arm.stay(mine)
        if address <= GOAL < address + len(data) and table[TORQUE]:
            raw = struct.unpack_from("<H", table, GOAL)[0]
            goal = -(raw & 0x7FFF) if raw & 0x8000 else raw
            self.arm.goal = np.where(mine, self.radians(goal), self.arm.goal)
        if self.mirror:
            self.sense()

    def understand(self, data):
        """Execute the packets in these bytes, and return what is not whole yet."""
        while (start := data.find(HEADER)) >= 0 and len(data) >= start + 6:
            end = start + 4 + data[start + 3]
            if data[start + 2] == 0xFF:
                data = data[start + 1 :]
                continue
            if len(data) < end:
                return data[start:]
            body = data[start + 2 : end]
            if (sum(body) & 0xFF) != 0xFF or len(body) < 4:
                data = data[start + 1 :]
                continue
            data = data[end:]
            self.do(body[0], body[2], body[3:-1])
        return data[start:] if start >= 0 else data[-1:]

    def do(self, servo, instruction, given):
        if instruction == SYNC_READ and len(given) > 2:
            places = [self.ids.index(one) for one in given[2:] if one in self.ids]
            answers = [
                (self.ids[p], self.status(p, self.tables[p][given[0] : given[0] + given[1]])) for p in places
            ]
            self.answer(answers, 2e-6 * sum(self.tables[place][DELAY] for place in places))
        elif instruction == SYNC_WRITE:
            self.write_all(*given[:2], given[2:])
        elif servo in self.ids:
            self.do_one(self.ids.index(servo), instruction, given)

    def do_one(self, place, instruction, given):
        table, data = self.tables[place], b""
        if instruction == READ:
            data = table[given[0] : given[0] + given[1]]
        elif instruction == WRITE:
            self.write(place, given[0], given[1:])
        if instruction in (PING, READ) or table[LEVEL]:
            self.answer([(self.ids[place], self.status(place, data))], 2e-6 * table[DELAY])

    def status(self, place, data):
        body = bytes([self.ids[place], len(data) + 2, self.tables[place][STATUS], *data])
        return HEADER + body + bytes([0xFF - (sum(body) & 0xFF)])


def main():
    parser = arguments(mode=0)
    parser.add_argument("--payload", default="", help="name of the body of the robot file that it carries")
    parser.add_argument("--gear", type=float, default=GEARS["feetech"], help="servo turns in a joint turn")
    parser.add_argument("--phase", type=int, default=12)
    options = parser.parse_args()
    plant = make_plant(options.robot, payload=options.payload)
    schedule()
    Feetechs(plant, options).run()


if __name__ == "__main__":
    main()
