"""A clock that processes and threads share: its time passes only while all of them wait.

One participant runs at a time, the holder of the turn. A participant that waits hands the turn on, and the
next one checks whether one of its files is ready or its time has come. If the turn has come round and nobody
can go on, the time jumps to the earliest deadline. So no run depends on how fast or busy the machine is. The
time and the deadlines are in shared memory; a turn is a datagram to the address of the next participant.
"""

import atexit
import fcntl
import json
import mmap
import os
import select
import socket
import tempfile
import threading
import time
from contextlib import suppress
from functools import cache
from pathlib import Path

from exidyn.drivers.host_clock import HOST, Clock

SLOTS = 16
"""Participants at most."""
NOW, IDLE, HOLDER = range(3)
"""Places in the shared memory of the time [ns], of how many in a row could not go on, and of who runs."""
PROCESS, DEADLINE, THREAD = 4, 4 + SLOTS, 4 + 2 * SLOTS
"""Places of the process of each participant, 0 for none, of its deadline [ns], and of its thread."""
NEVER = 1 << 62
GONE = 2.0
"""Time of the machine after which one who waits for its turn looks whether the holder has died [s]."""
VARIABLE = "EXIDYN_PEER_CLOCK"
"""Environment variable by which a process knows that it takes part, and as whom."""


class VirtualClock(Clock):
    """The clock of one process; each of its threads takes part from its first wait on.

    The first participant, 0, begins with the turn.
    """

    def __init__(self, path, slot):
        self._path, self._local, self._lock = str(path), threading.local(), threading.Lock()
        with open(path, "r+b") as file:
            self._memory = memoryview(mmap.mmap(file.fileno(), 0)).cast("q")
        self._local.slot, self._local.socket = self._enter(slot)
        self._local.first = slot > 0

    def monotonic_ns(self):
        return self._memory[NOW]

    def monotonic(self):
        return 1e-9 * self._memory[NOW]

    uptime_ns = monotonic_ns

    def age(self, arrival):
        return 0

    def sleep(self, seconds):
        self._wait(lambda: False, seconds)

    def until(self, condition, seconds):
        """Wait until a condition holds; returns whether it does within so many seconds."""
        return self._wait(condition, seconds)

    def readable(self, files, timeout):
        return self._wait(lambda: select.select(files, [], [], 0.0)[0], timeout)

    def writable(self, files, timeout):
        return self._wait(lambda: select.select([], files, [], 0.0)[1], timeout)

    def start(self, thread):
        """Start a thread that takes part: time does not pass before it has begun to wait."""
        place, run = self._enter(), thread.run

        def taking_part():
            self._local.slot, self._local.socket = place
            self._memory[THREAD + place[0]] = threading.get_native_id()
            try:
                self._await_turn()
                run()
            finally:
                self.leave()

        thread.run = taking_part
        thread.start()

    def join(self, thread):
        """Wait until a thread has ended, which others may need time for."""
        while thread.is_alive():
            self.sleep(0.001)

    def allot(self):
        """The place of a process that will take part, and has no turn before it does."""
        slot = next(k for k in range(SLOTS) if not self._memory[PROCESS + k])
        self._memory[PROCESS + slot] = os.getpid()
        return slot

    def environment(self, slot):
        """What a process needs to take part."""
        return {VARIABLE: json.dumps([self._path, slot])}

    def free(self, slot):
        """Take a participant out that has ended or never began."""
        self._memory[PROCESS + slot] = 0

    def takes_part(self, slot):
        return bool(self._memory[PROCESS + slot])

    def leave(self):
        """Take this thread out, and hand its turn on if it has it."""
        slot = self._local.slot
        self.free(slot)
        if self._memory[HOLDER] == slot:
            self._memory[IDLE] = 0
            with suppress(StopIteration):
                self._hand_to(self._next(slot))
        self._local.socket.close()

    def _enter(self, slot=None):
        """Take part, at a place of its own: its number, and the socket on which turns come."""
        with self._lock:
            if slot is None:
                slot = next(k for k in range(SLOTS) if not self._memory[PROCESS + k])
            turns = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
            turns.bind(self._address(slot))
            turns.settimeout(GONE)
            self._memory[DEADLINE + slot] = self._memory[NOW]
            self._memory[PROCESS + slot] = os.getpid()
            self._memory[THREAD + slot] = threading.get_native_id()
        return slot, turns

    def _address(self, slot):
        return f"\0{self._path} {slot}"

    def _wait(self, ready, seconds):
        """Wait until something is ready; returns whether it is within so many seconds."""
        if ready():
            return True
        if seconds <= 0.0:
            return False
        if not hasattr(self._local, "slot"):  # a thread that nobody has announced
            self._local.slot, self._local.socket = self._enter()
            self._local.first = True
        if self._local.first:
            self._await_turn()
            return self._wait(ready, seconds)
        memory, slot = self._memory, self._local.slot
        deadline = NEVER if seconds > 1e8 else memory[NOW] + max(round(1e9 * seconds), 1)
        done = False
        while not done and memory[NOW] < deadline:
            memory[DEADLINE + slot] = deadline
            memory[IDLE] += 1
            following = self._following(slot)
            if following != slot:
                self._hand_to(following)
                self._await_turn()
            done = bool(ready())
        memory[IDLE] = 0
        return done

    def _following(self, slot):
        """Who has the turn next; moves the time on if nobody can go on before."""
        memory = self._memory
        present = [k for k in range(SLOTS) if memory[PROCESS + k]]
        if memory[IDLE] < len(present):
            return self._next(slot)
        first = min(present, key=lambda k: memory[DEADLINE + k])
        memory[IDLE] = 0
        if memory[DEADLINE + first] == NEVER:  # only the world outside can go on
            time.sleep(0.001)
            return self._next(slot)
        memory[NOW] = max(memory[NOW], memory[DEADLINE + first])
        return first

    def _next(self, slot):
        places = (*range(slot + 1, SLOTS), *range(slot + 1))
        return next(k for k in places if self._memory[PROCESS + k])

    def _hand_to(self, slot):
        """Hand the turn on; who is not there any more is passed over."""
        while True:
            self._memory[HOLDER] = slot
            try:
                self._local.socket.sendto(b".", self._address(slot))
                return
            except (ConnectionRefusedError, FileNotFoundError):
                self.free(slot)
                slot = self._next(slot)

    def _await_turn(self):
        self._local.first = False
        while True:
            try:
                self._local.socket.recv(1)
                return
            except TimeoutError:
                if self._take_from_dead():
                    return

    def _take_from_dead(self):
        """Take the turn if its holder has ended without handing it on; returns whether it was taken."""
        memory, slot = self._memory, self._local.slot
        with open(self._path, "rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX)  # of several that wait, one takes it
            holder = memory[HOLDER]
            if holder == slot or _lives(memory[THREAD + holder]):
                return False
            self.free(holder)
            memory[HOLDER], memory[IDLE] = slot, 0
            return True


def _lives(thread):
    """Whether a thread of any process is still there."""
    try:
        status = Path(f"/proc/{thread}/stat").read_text()
    except OSError:
        return False
    return status.rpartition(")")[2].split()[0] not in "ZX"


@cache
def of_this_test():
    """The clock of this process and of the peers that it starts; its first participant is this thread."""
    with tempfile.NamedTemporaryFile(prefix="clock", delete=False) as file:
        file.write(bytes(8 * (THREAD + SLOTS)))
    clock = VirtualClock(file.name, 0)
    atexit.register(os.unlink, file.name)
    atexit.register(clock.leave)
    clock._memory[NOW] = HOST.monotonic_ns()
    return clock


@cache
def of_this_peer():
    """The clock of a peer: that of the test that started it, or the host's if nobody shares it."""
    return VirtualClock(*json.loads(os.environ[VARIABLE])) if VARIABLE in os.environ else HOST
