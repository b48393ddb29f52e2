"""Servos on a pseudo-terminal: what both protocols have in common.

What goes wrong is sent through standard input, a line each, and "did ..." comes back:

    silent ID            this servo answers no more
    corrupt ID COUNT     a bit of its next answers is wrong
    short COUNT          the last bytes of the next answers to all are lost
    late SECONDS COUNT   the next answers to all come later
    stall SECONDS        nothing is received nor sent
    babble BYTES         bytes that were not asked for
    echo                 the line sends back what it is sent
    error ID BITS        hardware errors
    refuse ID NUMBER     this servo answers everything with an error number and data (Dynamixel); 0 for none
    reboot ID            power was lost: registers of the memory that forgets are as at first
    set ADDRESS SIZE N   this register of all servos
    show ADDRESS SIZE    prints this register of all servos: "shows [...]"
    clear                all servos answer again, in time
    heal                 all is as in the beginning, but for where the arm stands
    sensor, truth        as in `sensors.py`
"""

import argparse
import heapq
import os
import random
import tty

import numpy as np
from pace import Pace
from sensors import Sensors
from servo_units import TURN, ids, sign, zero
from virtual_clock import of_this_peer

from exidyn.drivers.host_clock import HOST

CLOCK = of_this_peer()


def arguments(mode):
    """Those that all peers on a line have, with the operating mode of their servos."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--robot", default="cobot")
    parser.add_argument("--cycle", type=float, default=0.002)
    parser.add_argument("--baudrate", type=int, default=0)
    parser.add_argument("--mirror", action="store_true")
    parser.add_argument("--lockstep", action="store_true", help="a cycle passes with each question")
    parser.add_argument("--mode", type=int, default=mode)
    parser.add_argument("--return-delay", type=int, default=250)
    parser.add_argument("--torque", type=int, default=0)
    return parser


class MovedArm:
    """The simulated arm and its own clock, which does not wait for the host."""

    def __init__(self, plant, cycle):
        self.plant, self.cycle, self.pace = plant, cycle, Pace(plant)
        self.goal = np.array(plant.measure().position)

    def follow(self, now):
        """Move to the goal, to be there when the host asks again."""
        self.pace.step(self.goal, None, self.pace.length(self.cycle, now))

    def pass_time(self, now):
        """What goes on without the host."""
        if self.pace.behind(now) > 0.5 * self.cycle:
            self.follow(now)

    def stay(self, where):
        """No goal but where these joints are."""
        measured = self.plant.measure().position
        self.goal = np.where(where, measured, self.goal)


class ServoLine:
    """All servos of an arm; a protocol defines what packets mean.

    With a baudrate, bytes take their time. With `mirror`, servos are at their goals at once and send that.
    """

    def __init__(self, plant, options, gear):
        self.master, self.slave = os.openpty()
        tty.setraw(self.master)
        tty.setraw(self.slave)
        os.set_blocking(self.master, False)
        self.address = os.ttyname(self.slave)
        joints = len(plant.joints)
        self.ids, self.baudrate, self.mirror = ids(joints), options.baudrate, options.mirror
        self.arm = MovedArm(plant, options.cycle)
        self.arm.pace.lockstep = options.lockstep
        self.per_radian, self.zero = sign(joints) * gear * TURN / (2.0 * np.pi), zero(joints)
        self.direction, self.gear, self.sensors = sign(joints), gear, Sensors()
        self.waiting, self.received, self.received_at = [], b"", CLOCK.monotonic()
        self.random = random.Random(0)
        self.clear()

    def clear(self):
        self.silent, self.corrupt, self.short, self.late = set(), {}, 0, [0.0, 0]
        self.echo = False
        self.refusing = {}

    def counts(self, position):
        return np.rint(self.zero + position * self.per_radian).astype(int)

    def shown_counts(self, largest):
        """Counts that the sensors show now; the largest, either way, for what has no value."""
        shown = self.sensors.shown(self.arm.pace.position(CLOCK.monotonic()))
        counts = np.nan_to_num(self.zero + shown * self.per_radian, nan=-largest)
        return np.rint(np.clip(counts, -largest, largest)).astype(int)

    def radians(self, counts):
        return (np.asarray(counts) - self.zero) / self.per_radian

    def answer(self, packets, delay):
        """Send the answers of servos, [(id, bytes), ...], with what goes wrong on the way."""
        parts = [self._wronged(servo, data) for servo, data in packets if servo not in self.silent]
        data = b"".join(parts)
        if self.short and data:
            self.short, data = self.short - 1, data[:-5]
        when = CLOCK.monotonic() + delay
        if self.baudrate:
            when += 10.0 * (len(data) + self.heard_bytes) / self.baudrate
        if self.late[1] and data:
            self.late[1] -= 1
            when += self.late[0]
        heapq.heappush(self.waiting, (when, data))

    def _wronged(self, servo, data):
        if not self.corrupt.get(servo):
            return data
        self.corrupt[servo] -= 1
        place = self.random.randrange(4, len(data))
        return data[:place] + bytes([data[place] ^ 0x10]) + data[place + 1 :]

    def write_all(self, address, length, blocks):
        """Write registers of several servos; a block is an id and the data."""
        for at in range(0, len(blocks) - length, length + 1):
            if blocks[at] in self.ids:
                self.write(self.ids.index(blocks[at]), address, blocks[at + 1 : at + 1 + length])

    def run(self):
        """Until standard input ends."""
        self.first = [bytes(table) for table in self.tables]
        print(f"ready {self.address}", flush=True)
        while True:
            now = CLOCK.monotonic()
            until = self.waiting[0][0] - now if self.waiting else 0.5 * self.arm.cycle
            if 0.0 < until < 3e-4:
                CLOCK.sleep(until)  # more exact than to select
            CLOCK.readable([self.master, 0], max(min(until, 0.5 * self.arm.cycle), 0.0))
            if HOST.readable([0], 0.0) and not self._told():
                return
            if HOST.readable([self.master], 0.0):
                self._hear()
            sent = self._send()
            now = CLOCK.monotonic()
            if sent:
                self.arm.follow(now)
            elif not self.waiting:
                self.arm.pass_time(now)
            self.watch(now)

    def _hear(self):
        try:
            data = os.read(self.master, 4096)
        except BlockingIOError:
            return
        except OSError:  # nobody has the other end open
            CLOCK.sleep(0.01)
            return
        if not self.received:
            self.sense()  # what is asked for is of this moment
        if self.echo:
            heapq.heappush(self.waiting, (0.0, data))
        self.received += data
        self.received_at = CLOCK.monotonic()
        self.heard_bytes = len(self.received)
        self.received = self.understand(self.received)[-4096:]

    def _send(self):
        sent = False
        while self.waiting and self.waiting[0][0] <= CLOCK.monotonic():
            data = heapq.heappop(self.waiting)[1]
            sent = sent or bool(data)
            try:
                os.write(self.master, data)
            except OSError:  # nobody reads
                pass
        return sent

    def _told(self):
        lines = os.read(0, 4096)
        for line in lines.decode().splitlines():
            kind, *numbers = line.split()
            if not self.sensors.told(line.split()):
                self.go_wrong(kind, *map(float, numbers))
            print(f"did {line}", flush=True)
        return bool(lines)

    def go_wrong(self, kind, *numbers):
        if kind == "silent":
            self.silent.add(int(numbers[0]))
        elif kind == "corrupt":
            self.corrupt[int(numbers[0])] = int(numbers[1])
        elif kind == "short":
            self.short = int(numbers[0])
        elif kind == "late":
            self.late = [numbers[0], int(numbers[1])]
        elif kind == "stall":
            CLOCK.sleep(numbers[0])
        elif kind == "babble":
            heapq.heappush(self.waiting, (0.0, self.random.randbytes(int(numbers[0]))))
        elif kind == "echo":
            self.echo = True
        elif kind == "error":
            self.hardware_error(self.ids.index(int(numbers[0])), int(numbers[1]))
        elif kind == "refuse":
            self.refusing[int(numbers[0])] = int(numbers[1])
        elif kind == "reboot":
            self.reboot(self.ids.index(int(numbers[0])))
        elif kind == "set":
            address, size, value = map(int, numbers)
            for table in self.tables:
                table[address : address + size] = value.to_bytes(size, "little")
        elif kind == "show":
            address, size = map(int, numbers)
            values = [int.from_bytes(table[address : address + size], "little") for table in self.tables]
            print(f"shows {values}", flush=True)
        elif kind == "clear":
            self.clear()
        elif kind == "heal":
            self.clear()
            for table, first in zip(self.tables, self.first, strict=True):
                table[:] = first
            self.arm.stay(np.ones(len(self.ids), bool))
            self.sense()
