"""Cyclic part of CiA 402 over CANopen: targets, SYNC, measurements, emergencies and heartbeats."""

import math
import struct
from collections.abc import Callable, Sequence

from ..can.can_bus import CanBus
from ..can.can_driver import CanRound
from . import cia402 as c

STOOD = "<Hi"
"""Beginning of TPDO1: statusword, position. An effort of at most two bytes follows; a longer one is in
TPDO2."""
COMMANDED = struct.Struct("<Hi")
"""RPDO1: controlword, target position."""
EMERGENCY = struct.Struct("<HB5x")
"""Emergency: error code, error register, five manufacturer-specific bytes."""
STOOD_PART, EFFORT_PART = 1, 2
"""Bits for TPDO1 and TPDO2, the parts of an answer."""
LONGEST = 8
"""Maximum number of data bytes in a frame."""
LOST = 3.5
"""Number of consecutive missing heartbeats after which a node counts as lost."""


def beside(effort: c.Entry) -> bool:
    """Whether an effort fits into TPDO1, beside statusword and position."""
    return struct.calcsize(STOOD + effort.form[1:]) <= LONGEST


def measured_sizes(effort: c.Entry) -> list[int]:
    """Number of data bytes of each frame with a drive's measurements."""
    sizes = [struct.calcsize(STOOD), struct.calcsize(effort.form)]
    return [sum(sizes)] if beside(effort) else sizes


class Frames(CanRound):
    """Frames to the drives and from them, in the units of the drives.

    The host has a node number too, and sends a heartbeat every `beat` [s]; drives that are `beating` send one
    every `heartbeat` [s]. `efforts` are the objects that measure current or torque.
    """

    def __init__(
        self,
        bus: CanBus,
        nodes: Sequence[int],
        names: list[str],
        host: int,
        beat: float,
        heartbeat: float,
        efforts: Sequence[c.Entry],
        beating: Sequence[bool],
    ) -> None:
        super().__init__(bus, names, may_skip=False)  # a drive without SYNC may take it for a fault
        self._nodes = nodes
        count = len(nodes)
        self.control, self.target = [c.SHUT_DOWN] * count, [0] * count  # controlwords, targets [counts]
        self.commanding = False  # whether both are sent
        self.status = [-1] * count  # statusword of each drive; -1 before the first
        # Position and effort of each drive at the last SYNC that it answered [counts].
        self.position, self.effort = [0] * count, list[float]([0] * count)
        self._measured_form = [struct.Struct(STOOD + e.form[1:] * beside(e)) for e in efforts]
        self._effort_form = [struct.Struct(e.form) for e in efforts]
        self._parts = [STOOD_PART if beside(e) else STOOD_PART | EFFORT_PART for e in efforts]
        self._missing = list(self._parts)
        self._commands = [c.RPDO1 + node for node in nodes]
        self._sync, self._beat = [(c.SYNC, b"")], [(c.HEARTBEAT + host, bytes([c.OPERATIONAL]))]
        self._beat_time, self._next_beat = beat, 0.0
        self._lost_after, self._beating = LOST * heartbeat, beating
        self._alive = self._all_alive()
        self._states = [""] * count
        self._readers: dict[int, tuple[Callable[[int, bytes], None], int]] = {}
        for joint, node in enumerate(nodes):
            self._readers[c.TPDO1 + node] = (self._measured, joint)
            if self._parts[joint] & EFFORT_PART:
                self._readers[c.TPDO2 + node] = (self._measured_effort, joint)
            self._readers[c.EMERGENCY + node] = (self._emergency, joint)
            self._readers[c.HEARTBEAT + node] = (self._heartbeat, joint)

    def begin(self) -> None:
        super().begin()
        self.status = [-1] * len(self._nodes)
        self._alive = self._all_alive()

    def cycle(self, patience: float) -> int:
        """Send targets, then SYNC, at which all drives take their targets and measure."""
        self.send()
        self._ask()
        self._missing = list(self._parts)
        now = self._clock.host_time()
        self._bus.send_frames(self._sync)
        self._collect(self._clock.monotonic() + patience)
        self._check_heartbeats()
        return now

    def send(self) -> None:
        """Send controlwords and targets while `commanding`, and the host's heartbeat when it is due."""
        if not self.commanding:
            return
        pack = COMMANDED.pack
        joints = zip(self._commands, self.control, self.target, strict=True)
        self._bus.send_frames([(number, pack(control, target)) for number, control, target in joints])
        if self._clock.monotonic() >= self._next_beat:
            self._next_beat = self._clock.monotonic() + self._beat_time
            self._bus.send_frames(self._beat)

    def synchronize(self) -> None:
        """Send an additional SYNC, at which the drives take what was sent."""
        self._answers.add_question()
        self._missing = list(self._parts)
        self._bus.send_frames(self._sync)

    def leave(self) -> None:
        """Make the drives no longer expect the host's heartbeat, and leave a quiet bus.

        No answer is waited for, because a drive may be absent.
        """
        entry = c.CONSUMER_HEARTBEAT
        expect_nothing = struct.pack("<BHBI", 0x23, entry.index, entry.sub, 0)
        for node in self._nodes:
            self._bus.send_frames([(c.SDO_TO_NODE + node, expect_nothing)])
        self._clock.sleep(0.02)
        for node in self._nodes:
            self._bus.send_frames([(c.NMT, bytes([c.PRE_OPERATIONAL, node]))])

    def state(self, joint: int) -> str:
        return c.state(self.status[joint])

    def _understand(self, identifier: int, data: bytes) -> bool:
        reader = self._readers.get(identifier)
        if reader is None:
            return False
        reader[0](reader[1], data)
        return True

    def _commanded_by(self, identifier: int) -> str:
        fixed = {c.NMT: "network management", c.SYNC: "SYNC", self._beat[0][0]: "the host's heartbeat"}
        if identifier in self._commands:
            return f"targets of {self._names[self._commands.index(identifier)]}"
        return fixed.get(identifier, "")

    def _measured(self, joint: int, data: bytes) -> None:
        form = self._measured_form[joint]
        if len(data) != form.size:
            return
        before = self.status[joint]
        self.status[joint], self.position[joint], *effort = form.unpack(data)
        if effort:
            self.effort[joint] = effort[0]
        self._complete_part(joint, STOOD_PART)
        if self.status[joint] != before:
            self._status_changed(joint, max(before, 0))

    def _measured_effort(self, joint: int, data: bytes) -> None:
        form = self._effort_form[joint]
        if len(data) == form.size:
            (self.effort[joint],) = form.unpack(data)
            self._complete_part(joint, EFFORT_PART)

    def _complete_part(self, joint: int, part: int) -> None:
        """Count a drive as answered once all of its measuring PDOs are there."""
        self._missing[joint] &= ~part
        if not self._missing[joint]:
            self._answered(joint)

    def _status_changed(self, joint: int, before: int) -> None:
        word, state = self.status[joint], self.state(joint)
        if state != self._states[joint]:
            self._states[joint] = state
            self.report(f"{self._names[joint]}: {state} (statusword 0x{word:04X})")
        if word & ~before & c.LIMIT_ACTIVE:
            self.report(f"{self._names[joint]}: a limit inside the drive is active")

    def _emergency(self, joint: int, data: bytes) -> None:
        if len(data) != EMERGENCY.size:
            return
        code, register = EMERGENCY.unpack(data)
        if code & 0xFF00:
            why = f"{self._names[joint]}: emergency {c.error_text(code)}, error register 0x{register:02X}"
            self.fail(f"{why}, 0x{data[3:].hex()}")
        else:
            self.report(f"{self._names[joint]}: emergency over")

    def _heartbeat(self, joint: int, data: bytes) -> None:
        if len(data) != 1:
            return
        if self._beating[joint]:
            self._alive[joint] = self._clock.monotonic()
        state = data[0] & 0x7F
        if state != c.OPERATIONAL and not self.fault:
            word = c.NMT_STATES.get(state, f"in an unknown state {state}")
            self.fail(f"{self._names[joint]}: is {word} on the network, no longer operational")

    def _all_alive(self) -> list[float]:
        """Time of the last heartbeat of each drive; infinite for a drive without heartbeat."""
        return [self.received if beats else math.inf for beats in self._beating]

    def _check_heartbeats(self) -> None:
        if self.fault:
            return
        oldest = min(self._alive)
        if self._clock.monotonic() - oldest > self._lost_after:
            joint = self._alive.index(oldest)
            self.fail(f"{self._names[joint]}: its heartbeat is lost, none came for {self._lost_after:g} s")
