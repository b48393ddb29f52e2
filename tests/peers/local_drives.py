"""CiA 402 drives made of `canopen.LocalNode`, with an object dictionary that is not ours: one for each joint.

    python tests/peers/local_drives.py 0 0 0 0 0 0            prints "ready PORT" and later what happens

SDO server, network states and heartbeat are those of the package `canopen`; here is what it leaves out: PDOs
that act with SYNC, the states of a drive behind the controlword, and a motor that is at once where it is
commanded. Ends when its standard input does.
"""

import argparse
import os
import struct
import sys

import canopen

CHANNEL = "ff11:7079:7468:6f6e:6465:6d6f:6d63:6173"
"""Interface-local scope: no frame leaves the machine."""
NO_BUS = 77
"""Exit status of a peer that could not open its bus."""
INVALID = 0x80000000
SYNCHRONOUS = range(241)
"""Transmission types with which a PDO waits for SYNC."""
OFF, READY, ON, ENABLED, STOPPED = "switch-on disabled", "ready", "switched on", "enabled", "quick stop"
STATUS = {OFF: 0x0250, READY: 0x0231, ON: 0x0233, ENABLED: 0x1237, STOPPED: 0x0217}
SHUT_DOWN, SWITCH_ON, ENABLE, NO_VOLTAGE, QUICK_STOP = range(5)
NEXT = {
    (OFF, SHUT_DOWN): READY,
    (READY, SWITCH_ON): ON,
    (READY, ENABLE): ON,
    (READY, QUICK_STOP): OFF,
    (READY, NO_VOLTAGE): OFF,
    (ON, SHUT_DOWN): READY,
    (ON, ENABLE): ENABLED,
    (ON, QUICK_STOP): OFF,
    (ON, NO_VOLTAGE): OFF,
    (ENABLED, SHUT_DOWN): READY,
    (ENABLED, SWITCH_ON): ON,
    (ENABLED, QUICK_STOP): STOPPED,
    (ENABLED, NO_VOLTAGE): OFF,
    (STOPPED, ENABLE): ENABLED,
    (STOPPED, NO_VOLTAGE): OFF,
}
"""State and command -> the next state, where it changes; quick stop holds, as by 0x605A = 5 and 6."""


def command(word):
    """Meaning of a controlword for a drive that is not in fault."""
    if not word & 0x02:
        return NO_VOLTAGE
    if not word & 0x04:
        return QUICK_STOP
    return SHUT_DOWN if not word & 0x01 else ENABLE if word & 0x08 else SWITCH_ON


class LocalDrive:
    """What is behind the dictionary of a LocalNode."""

    def __init__(self, node, position, emit=print):
        self.node, self.emit = node, emit
        self.state, self.pending = OFF, {}
        for index, value in ((0x6041, STATUS[OFF]), (0x6061, 0), (0x6064, position), (0x606C, 0)):
            self.put(index, value)
        node.add_write_callback(self.written)
        for base in (0x200, 0x300, 0x400, 0x500):
            node.network.subscribe(base + node.id, self.commanded)
        node.network.subscribe(0x080, self.synchronised)
        node.nmt.state = "INITIALISING"
        node.nmt.state = "PRE-OPERATIONAL"

    def get(self, index, sub=0):
        entry = self.node.object_dictionary[index]
        return (entry if isinstance(entry, canopen.objectdictionary.ODVariable) else entry[sub]).decode_raw(
            self.node.get_data(index, sub)
        )

    def put(self, index, value):
        self.node.set_data(index, 0, self.node.object_dictionary[index].encode_raw(value))

    def written(self, index, data, **_):
        """What happens when an object is written, by SDO or by a PDO."""
        if index == 0x6040:
            self.control(struct.unpack("<H", data)[0])
        elif index == 0x6060:
            self.put(0x6061, data[0])

    def control(self, word):
        state = NEXT.get((self.state, command(word)), self.state)
        if state != self.state:
            self.emit(f"node {self.node.id}: {state}", flush=True)
        self.state = state
        self.put(0x6041, STATUS[state])

    def commanded(self, identifier, data, _):
        """A frame that may be of one of the RPDOs."""
        for index in range(0x1400, 0x1404):
            switch = self.get(index, 1)
            if self.node.nmt.state != "OPERATIONAL" or switch & INVALID or switch & 0x7FF != identifier:
                continue
            if self.get(index, 2) in SYNCHRONOUS:
                self.pending[index] = bytes(data)
            else:
                self.take(index, bytes(data))

    def take(self, index, data):
        for entry in self.mapped(index + 0x200):
            size = (entry & 0xFF) // 8
            self.node.set_data(entry >> 16, entry >> 8 & 0xFF, data[:size])
            data = data[size:]

    def mapped(self, index):
        return [self.get(index, sub) for sub in range(1, self.get(index, 0) + 1)]

    def synchronised(self, *_):
        """Send what is measured, then take what was received, then be where the target is."""
        if self.node.nmt.state != "OPERATIONAL":
            return
        for index in range(0x1800, 0x1804):
            switch = self.get(index, 1)
            if not switch & INVALID and self.get(index, 2) in SYNCHRONOUS:
                values = (self.node.get_data(e >> 16, e >> 8 & 0xFF) for e in self.mapped(index + 0x200))
                self.node.network.send_message(switch & 0x7FF, b"".join(values))
        for index, data in self.pending.items():
            self.take(index, data)
        self.pending.clear()
        self.move()

    def move(self):
        before = self.get(0x6064)
        after = self.get(0x607A) if self.state == ENABLED and self.get(0x6061) == 8 else before
        self.put(0x6064, after)
        self.put(0x606C, round((after - before) / (self.get(0x60C2, 1) * 10.0 ** self.get(0x60C2, 2))))


def drives_on(network, dictionary, positions, emit=print):
    """Drives 1, 2, ... on a connected network, which stand at these counts."""
    nodes = [network.create_node(number, dictionary(number)) for number in range(1, len(positions) + 1)]
    return [LocalDrive(node, position, emit) for node, position in zip(nodes, positions, strict=True)]


def main():
    from can_arm import free_port
    from ros2_dictionary import ros2_dictionary

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("positions", nargs="+", type=int, help="where each stands [counts]")
    parser.add_argument("--fifo", action="store_true", help="real-time scheduling, where it is allowed")
    options, port, network = parser.parse_args(), free_port(), canopen.Network()
    if options.fifo:  # before there are threads, which take it over
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(70))
    try:
        network.connect(interface="udp_multicast", channel=CHANNEL, port=port, fd=False, ignore_config=True)
    except (canopen.network.can.CanError, OSError) as error:
        print(f"no CAN bus on this machine: {error}", flush=True)
        sys.exit(NO_BUS)
    drives_on(network, ros2_dictionary, options.positions)
    print(f"ready {port}", flush=True)
    while os.read(0, 1024):
        pass
    network.disconnect()


if __name__ == "__main__":
    main()
