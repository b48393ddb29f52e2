"""CiA 402 drives on a CAN bus, one for each joint of a simulated arm.

    python tests/peers/can_nodes.py --robot cobot            prints "ready PORT" and later what happens
    python tests/peers/can_nodes.py --adapter                prints "ready /dev/pts/N": a slcan adapter

Faults are given as KIND:NODE@CYCLE, in cycles after all drives are enabled: silent (nothing more is sent),
mute (no PDO), quiet (no heartbeat), double (a second drive has its number), emergency, fault (0x3210),
restart, noise, deaf and creep (moves on whatever it is told), unpowered, leave (pre-operational). Lines on
its standard input are such faults, KIND NODE, or as in `sensors.py`. Ends when that does.
"""

import argparse
import sys

import can
import numpy as np
from can_arm import COUNTS, GEAR, make_arm, sign, zero
from can_ends import NO_BUS, Multicast, SerialAdapter, frame, noise
from cia402_node import PRE_OPERATIONAL, STATUS, Node
from pace import Pace
from sensors import Sensors
from served import ended_of, schedule
from virtual_clock import of_this_peer

CLOCK = of_this_peer()
RATED = 4000
"""Rated current [mA]."""
FOR_ONE = (0x200 >> 7, 0x600 >> 7)
"""Upper bits of identifiers that name their node: targets and SDO."""
FOR_ALL = (0x000, 0x700 >> 7)
"""Those of network management and heartbeats; what nodes themselves send is none of these but the last."""
RUNS = {"deaf": 0.8, "creep": 0.08}
"""Speed of a joint that moves on [rad/s]."""
SPEED = 3.0
"""What motors can do [rad/s at the joint]."""


class Fault:
    """One thing that goes wrong."""

    def __init__(self, text):
        self.kind, _, rest = text.partition(":")
        node, _, cycle = rest.partition("@")
        self.node, self.cycle, self.done = int(node), int(cycle), False


class CanPeer:
    """Nodes at one bus end, which go wrong some cycles after all of them are on."""

    def __init__(self, end, plant, faults):
        self.end, self.plant, self.faults = end, plant, faults
        self.cycles = self.on_at = 0
        self.random = np.random.default_rng(0)
        self.pace, self.sensors = Pace(plant), Sensors()

    def go_wrong(self, identifiers):
        """Let happen what is due; noise comes with these identifiers too."""
        for fault in self.faults:
            due = self.on_at and self.cycles - self.on_at >= fault.cycle
            if fault.kind == "noise" and due:
                noise(self.end, self.random, identifiers)
            elif due and not fault.done:
                fault.done = True
                self.let_go_wrong(fault.kind, fault.node)

    def told(self, words):
        """A line on standard input: of the sensors, or KIND NODE as in `--fault`."""
        if not self.sensors.told(words):
            self.let_go_wrong(words[0], int(words[1]))

    def serve(self, options):
        """Print that all is ready, and answer until standard input ends."""
        ended = ended_of(self.told)
        self.pace.lockstep = options.lockstep
        emit(f"ready {self.end.address}")
        if options.fifo:
            schedule()
        while not ended():
            message = self.receive(0.005)
            while message is not None:  # what came while this process had to wait was no silence of the host
                self.handle(message)
                message = self.receive(0.0)
            self.pass_time()
        self.end.shutdown()

    def receive(self, timeout):
        try:
            return self.end.recv(timeout)
        except Exception:  # noise, one's own too
            return None


class Nodes(CanPeer):
    """All drives of an arm at one bus end, and the arm."""

    def __init__(self, end, plant, faults=()):
        super().__init__(end, plant, faults)
        joints = len(plant.joints)
        self.per_radian = sign(joints) * COUNTS * GEAR / (2.0 * np.pi)
        self.zero = zero(joints)
        self.muted, self.silent, self.quiet, self.doubled = set(), set(), set(), set()
        speed = SPEED * COUNTS * GEAR / (2.0 * np.pi)
        self.nodes = [
            Node(number, self.sender(number), emit, speed, RATED) for number in range(1, joints + 1)
        ]
        self.synced = self.moved = self.next_look = CLOCK.monotonic()
        self.measure(1e-9 * CLOCK.host_time())
        for node in self.nodes:
            node.held = node.demand = node.actual

    def sender(self, number):
        def send(identifier, data):
            kind = identifier & 0x780
            if number in self.silent or (kind == 0x180 and number in self.muted):
                return
            if kind == 0x700 and number in self.quiet:
                return
            self.end.send(frame(identifier, data))
            if kind == 0x180 and number in self.doubled:  # another drive of that number stands elsewhere
                self.end.send(frame(identifier, data[:2] + bytes([data[2] ^ 0x40]) + data[3:]))

        return send

    def measure(self, now):
        """Put into the objects what the sensors measure at a time."""
        measured = self.plant.measure()
        position = self.pace.position(now)
        counts = np.rint((position - self.zero) * self.per_radian)
        shown = np.nan_to_num((self.sensors.shown(position) - self.zero) * self.per_radian, nan=-(2**31))
        shown = np.rint(np.clip(shown, -(2**31), 2**31 - 1))
        thousandths = np.rint(sign(len(counts)) * measured.current / (RATED * 1e-6))
        for node, position, reading, effort in zip(
            self.nodes, counts, shown, np.clip(thousandths, -32768, 32767), strict=True
        ):
            node.actual = float(position)
            node.show(0x6064, int(reading))
            node.show(0x6078, int(effort))
            node.show(0x6077, int(effort))

    def handle(self, message):
        if message.is_extended_id or message.is_remote_frame or message.is_error_frame:
            return
        now, identifier, data = CLOCK.monotonic(), message.arbitration_id, bytes(message.data)
        if identifier == 0x080 and not data:
            self.synchronise(now, message.timestamp or 1e-9 * CLOCK.host_time())
        elif identifier >> 7 in FOR_ONE:
            if 0 < identifier & 0x7F <= len(self.nodes):
                self.nodes[(identifier & 0x7F) - 1].received(identifier, data, now)
        elif identifier >> 7 in FOR_ALL:
            for node in self.nodes:
                node.received(identifier, data, now)

    def synchronise(self, now, stamp):
        """SYNC: all drives answer what they see, then the arm moves to where it will be at the next."""
        self.measure(stamp)
        for node in self.nodes:
            node.synchronised(now)
        self.synced = now
        self.cycles += 1
        if not self.on_at and all(node.state == "enabled" for node in self.nodes):
            self.on_at = self.cycles
        self.move(stamp)
        self.go_wrong([0x181, 0x701, 0x081, 0x581])

    def move(self, now):
        self.moved = CLOCK.monotonic()
        seconds = self.pace.length(self.nodes[0].period, now)
        after = np.array([node.move(seconds) for node in self.nodes])
        position = after / self.per_radian + self.zero
        self.pace.step(position, None, seconds)

    def pass_time(self):
        """What goes on without SYNC: heartbeats, and drives that are slowing down by themselves."""
        now = CLOCK.monotonic()
        if now < self.next_look:
            return
        self.next_look = now + 0.001
        for node in self.nodes:
            node.tick(now)
        seconds = self.nodes[0].period
        if self.pace.lockstep:
            return
        if now - self.synced > 5.0 * seconds and now - self.moved > seconds:
            self.move(1e-9 * CLOCK.host_time())

    def let_go_wrong(self, kind, number):
        node = self.nodes[number - 1]
        emit(f"node {number}: now {kind}")
        if kind == "silent":
            self.silent.add(number)
        elif kind == "mute":
            self.muted.add(number)
        elif kind == "quiet":
            self.quiet.add(number)
        elif kind == "double":
            self.doubled.add(number)
        elif kind == "emergency":
            node.emergency(0x4310)
        elif kind == "fault":
            node.fail(0x3210)
        elif kind == "restart":
            node.manage(129)
        elif kind in RUNS:
            node.runs = RUNS[kind] * abs(self.per_radian[number - 1])
        elif kind == "unpowered":
            node.lose_power()
        elif kind == "leave":
            node.nmt = PRE_OPERATIONAL


def emit(text):
    print(text, flush=True)


def arguments(description):
    """Those that all peers on CAN have."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument(
        "--robot", default="cobot", help="or obedient: six joints that follow their commands at once"
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--adapter", action="store_true")
    parser.add_argument("--fifo", action="store_true")
    parser.add_argument("--lockstep", action="store_true", help="a cycle passes with each SYNC or round")
    parser.add_argument("--fault", action="append", default=[], type=Fault)
    return parser


def end_and_arm(options):
    """The bus end and the arm of a command line."""
    try:
        end = SerialAdapter() if options.adapter else Multicast(options.port)
    except (can.CanError, OSError) as error:
        emit(f"no CAN bus on this machine: {error}")
        sys.exit(NO_BUS)
    return end, make_arm(options.robot, seed=options.seed)


def main():
    parser = arguments(__doc__.splitlines()[0])
    parser.add_argument("--begin", choices=STATUS, help="state of all drives")
    parser.add_argument("--object", action="append", default=[], help="NODE:INDEX:SUB=VALUE")
    parser.add_argument("--without", action="append", default=[], help="NODE:INDEX:SUB")
    parser.add_argument("--withhold", action="append", default=[], help="likewise: there, and empty")
    options = parser.parse_args()
    nodes = Nodes(*end_and_arm(options), options.fault)
    for node in nodes.nodes if options.begin else ():
        node.state = options.begin
        node.put(0x6041, 0, STATUS[options.begin])
        node.put(0x603F, 0, 0x3210 if options.begin == "fault" else 0)
    for text in options.object:
        place, _, value = text.partition("=")
        number, index, sub = (int(part, 0) for part in place.split(":"))
        nodes.nodes[number - 1].put(index, sub, int(value, 0))
    for text in options.without:
        number, index, sub = (int(part, 0) for part in text.split(":"))
        del nodes.nodes[number - 1].objects[index, sub]
    for text in options.withhold:
        number, index, sub = (int(part, 0) for part in text.split(":"))
        nodes.nodes[number - 1].withheld.add((index, sub))
    for node in nodes.nodes:
        node.start()
    nodes.serve(options)


if __name__ == "__main__":
    main()
