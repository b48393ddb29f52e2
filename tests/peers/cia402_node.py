"""One CiA 402 drive: object dictionary, SDO server, network states, PDOs and the drive's own states.

It does what a drive does and knows nothing of the driver: PDOs hold what was mapped into them, a target that
is too far away ends in a following error, and a host whose heartbeat is missed in a quick stop.
"""

import struct
from statistics import median

PRE_OPERATIONAL, OPERATIONAL, STOPPED = 127, 5, 4
STATUS = {
    "switch-on disabled": 0x0250, "ready": 0x0231, "switched on": 0x0233, "enabled": 0x1237,
    "stopping": 0x0217, "fault reaction": 0x021F, "fault": 0x0218,
}  # fmt: skip
VOLTAGE = 0x0010
INVALID = 0x80000000
ENABLE_CYCLES = 10
"""SYNCs that pass until the brake is open."""


class Abort(Exception):
    """An SDO transfer that is refused, with its code."""


class Node:
    """A drive.

    `speed` is the most that the motor can do [counts/s], `rated` its rated current [mA].
    """

    def __init__(self, number, send, emit, speed, rated):
        self.number, self.send, self.speed = number, send, speed
        self.emit = lambda text: emit(f"node {number}: {text}")
        self.state, self.nmt = "switch-on disabled", 0
        self.actual = self.demand = self.held = 0.0  # counts
        self.velocity = 0.0  # of the demand [counts/s]
        self.opening = self.late_following = 0
        self.word, self.target, self.effort = 0, 0, 0
        self.transfer, self.pending = None, None
        self.syncs, self.last_beat, self.next_beat = [], None, 0.0
        self.objects = dict(standard_objects(number, rated))
        self.runs, self.powered = 0.0, True
        self.withheld = set()  # objects that are there and empty
        self.map()

    def start(self):
        """Begin anew, as after power-on, and print it."""
        self.nmt, self.pending, self.last_beat = PRE_OPERATIONAL, None, None
        self.send(0x700 + self.number, b"\0")

    def get(self, index, sub=0):
        """The value of an object."""
        return self.objects[index, sub][1]

    def put(self, index, sub, value):
        self.objects[index, sub][1] = value

    def option(self, index, sub, without):
        """The value of an object that not every drive has."""
        return self.get(index, sub) if (index, sub) in self.objects else without

    def show(self, index, value):
        """Put a measurement into an object that not every drive has."""
        if (index, 0) in self.objects:
            self.put(index, 0, value)

    # network

    def manage(self, command):
        if command in (129, 130):
            self.change("switch-on disabled")
            self.start()
        self.nmt = {1: OPERATIONAL, 2: STOPPED, 128: PRE_OPERATIONAL}.get(command, self.nmt)

    def received(self, identifier, data, now):
        """A frame that may be meant for this node."""
        if identifier == self.command_identifier and self.nmt == OPERATIONAL:
            if len(data) == self.command_form.size:
                self.pending = data
        elif identifier == 0x600 + self.number and len(data) == 8 and self.nmt != STOPPED:
            self.send(0x580 + self.number, self.serve(data))
        elif identifier == 0x000 and len(data) == 2 and data[1] in (0, self.number):
            self.manage(data[0])
        elif identifier >> 7 == 0x700 >> 7 and len(data) == 1 and (0x1016, 1) in self.objects:
            if self.get(0x1016, 1) >> 16 == identifier & 0x7F:
                self.last_beat = now

    def tick(self, now):
        """What depends on the time [s]: heartbeats, sent and missed."""
        period = self.option(0x1017, 0, 0) * 1e-3
        if period and now >= self.next_beat:
            self.next_beat = now + period
            self.send(0x700 + self.number, bytes([self.nmt]))
        patience = (self.option(0x1016, 1, 0) & 0xFFFF) * 1e-3
        if self.last_beat is not None and patience and now - self.last_beat > patience:
            self.last_beat = None
            self.emergency(0x8130)
            if self.state == "enabled" and (0x6007, 0) in self.objects:
                self.lose_host()

    def lose_host(self):
        reaction = self.get(0x6007)
        if reaction == 3:
            self.quick_stop()
        elif reaction == 2:
            self.change("switch-on disabled")
        elif reaction == 1:
            self.fail(0x8130)

    def emergency(self, code):
        self.put(0x1001, 0, 0x11 if code else 0)
        self.emit(f"emergency 0x{code:04X}")
        self.send(0x080 + self.number, struct.pack("<HB5s", code, self.get(0x1001), b"\1\2\3\4\5"))

    # SYNC

    def synchronised(self, now):
        """Answer SYNC with what is measured, then take what was received before it."""
        if self.nmt != OPERATIONAL:
            return
        self.syncs.append(now)
        self.put(0x6041, 0, STATUS[self.state] & ~(0 if self.powered else VOLTAGE))
        if self.answer_identifier is not None:
            self.send(self.answer_identifier, self.answer_form.pack(*(self.get(*p) for p in self.answers)))
        if self.pending is not None:
            for place, value in zip(self.commands, self.command_form.unpack(self.pending), strict=True):
                self.put(*place, value)
            self.pending = None
            self.control(self.get(0x6040))

    def map(self):
        """Look up what is in the PDOs, when they may have changed."""
        self.commands, self.command_form = self.mapped(0x1600)
        self.answers, self.answer_form = self.mapped(0x1A00)
        self.command_identifier = self.identifier(0x1400)
        self.answer_identifier = self.identifier(0x1800)

    def identifier(self, index):
        value = self.get(index, 1)
        return None if value & INVALID or self.get(index, 2) != 1 else value & 0x7FF

    def mapped(self, index):
        """Places and form of what is in a PDO."""
        entries = [self.get(index, sub) for sub in range(1, self.get(index, 0) + 1)]
        places = [(entry >> 16, entry >> 8 & 0xFF) for entry in entries]
        return places, struct.Struct("<" + "".join(self.objects[place][0][1] for place in places))

    # the drive

    def change(self, state):
        if state != self.state:
            self.emit(state)
            self.state = state
            self.held = self.demand if state in ("stopping", "fault reaction") else self.actual
        if state not in ("enabled", "stopping", "fault reaction"):
            self.velocity, self.demand = 0.0, self.actual

    def control(self, word):
        rising, self.word = word & ~self.word, word
        if self.state in ("fault", "fault reaction"):
            if self.state == "fault" and rising & 0x80:
                self.show(0x603F, 0)
                self.change("switch-on disabled")
                self.emergency(0)
        elif not word & 0x02:
            self.change("switch-on disabled")
        elif not word & 0x04:
            self.quick_stop()
        elif word & 0x0F == 0x0F:
            self.enable()
        elif word & 0x07 == 0x06 and self.state in ("switch-on disabled", "switched on", "enabled"):
            self.change("ready")
        elif word & 0x0F == 0x07 and self.state in ("ready", "enabled"):
            self.change("switched on")

    def enable(self):
        stopping = (
            self.state == "stopping" and self.option(0x605A, 0, 2) in (5, 6, 7, 8) and not self.velocity
        )
        if self.state not in ("switched on", "enabled") and not stopping:
            return
        self.opening += 1
        if self.state != "enabled" and self.opening > ENABLE_CYCLES and self.get(0x6061) == 8:
            self.opening = self.late_following = 0
            self.demand = self.actual
            self.change("enabled")

    def quick_stop(self):
        if self.state == "enabled":
            self.change("stopping" if self.option(0x605A, 0, 2) else "switch-on disabled")
        elif self.state in ("ready", "switched on"):
            self.change("switch-on disabled")

    def lose_power(self):
        """The supply of the power stage is gone."""
        self.powered = False
        self.change("switch-on disabled")

    def fail(self, code):
        self.show(0x603F, code)
        self.emergency(code)
        self.change("fault reaction")

    def move(self, seconds):
        """Commanded position of the motor after this time [counts]."""
        most = self.speed * seconds
        if self.runs:  # whatever it is told
            self.demand += self.runs * seconds
        elif self.state == "enabled":
            wish = self.get(0x607A) - self.demand
            step = min(max(wish, -most), most)
            self.velocity = step / seconds
            self.demand += step
            self.look(seconds)
        elif self.state in ("stopping", "fault reaction"):
            slower = abs(self.velocity) - 5.0 * most  # stops from full speed within 0.2 s
            self.velocity = max(slower, 0.0) * (1.0 if self.velocity > 0.0 else -1.0)
            self.demand += self.velocity * seconds
            if not self.velocity:
                self.come_to_rest()
        else:
            self.demand = self.held  # the brake holds it
        return self.demand

    def come_to_rest(self):
        if self.state == "fault reaction":
            self.change("fault")
        elif self.option(0x605A, 0, 2) in (1, 2, 3):
            self.change("switch-on disabled")

    def look(self, seconds):
        """Following error, and whether SYNC comes as often as it was text to."""
        away = abs(self.get(0x607A) - self.actual) > self.option(0x6065, 0, 100000)
        self.late_following = self.late_following + 1 if away else 0
        if self.late_following * seconds * 1e3 > self.option(0x6066, 0, 10):
            self.fail(0x8611)
        elif len(self.syncs) > 100:
            period = median(b - a for a, b in zip(self.syncs, self.syncs[1:], strict=False))
            self.syncs = []
            if not 0.25 < period / self.period < 4.0:  # busy machines are late
                self.fail(0x8700)

    @property
    def period(self):
        if (0x60C2, 1) not in self.objects:
            return 1e-6 * self.get(0x1006)
        return self.get(0x60C2, 1) * 10.0 ** self.get(0x60C2, 2)

    # SDO

    def serve(self, data):
        """The answer to an SDO request."""
        command, index, sub = struct.unpack_from("<BHB", data)
        try:
            if command >> 5 == 1:
                return self.download(command, index, sub, data[4:])
            if command >> 5 == 2:
                return self.upload(index, sub)
            if command >> 5 == 3:
                return self.segment(command & 0x10)
            if command >> 5 == 4:
                self.transfer = None
            raise Abort(0x05040001)
        except Abort as abort:
            return struct.pack("<BHBI", 0x80, index, sub, abort.args[0])

    def upload(self, index, sub):
        if (index, sub) not in self.objects:
            raise Abort(0x06020000)
        if (index, sub) in self.withheld:
            raise Abort(0x060A0023)
        form, value, _ = self.objects[index, sub]
        data = value.encode() if form == "text" else struct.pack(form, value)
        if len(data) <= 4:
            return struct.pack("<BHB", 0x43 | 4 - len(data) << 2, index, sub) + data.ljust(4, b"\0")
        self.transfer = data
        return struct.pack("<BHBI", 0x41, index, sub, len(data))

    def segment(self, toggle):
        if self.transfer is None:
            raise Abort(0x05040001)
        part, self.transfer = self.transfer[:7], self.transfer[7:] or None
        return bytes([toggle | 7 - len(part) << 1 | (self.transfer is None)]) + part.ljust(7, b"\0")

    def download(self, command, index, sub, data):
        if not command & 2:
            raise Abort(0x05040001)
        if (index, sub) not in self.objects:
            raise Abort(0x06020000)
        form, _, access = self.objects[index, sub]
        if access != "rw":
            raise Abort(0x06010002)
        size = 4 - (command >> 2 & 3)
        if size != struct.calcsize(form):
            raise Abort(0x06070010)
        self.written(index, sub, struct.unpack(form, data[:size])[0])
        return struct.pack("<BHB4x", 0x60, index, sub)

    def written(self, index, sub, value):
        if index in (0x1010, 0x1011):
            self.emit("was ordered to store or restore")
        if index == 0x1003 and value:
            raise Abort(0x06090030)
        if index in (0x1400, 0x1600, 0x1800, 0x1A00):
            self.require_pdo(index, sub, value)
        self.put(index, sub, value)
        if index in (0x1400, 0x1600, 0x1800, 0x1A00):
            self.map()
        if index == 0x6060 and 0 < value < 33 and self.option(0x6502, 0, 0x80) >> (value - 1) & 1:
            self.put(0x6061, 0, value)
        if index == 0x6040:
            self.control(value)
        if index == 0x1016:
            self.last_beat = None

    def require_pdo(self, index, sub, value):
        """A PDO may be changed in the pre-operational state only, and its mapping while it is off."""
        if self.nmt != PRE_OPERATIONAL:
            raise Abort(0x08000022)
        mapping = index in (0x1600, 0x1A00)
        valid = not self.get(index - 0x200 if mapping else index, 1) & INVALID
        if (mapping or not (sub == 1 and value & INVALID)) and valid:
            raise Abort(0x06010000)
        if mapping and sub and self.get(index, 0):
            raise Abort(0x06010000)
        if mapping and sub and (value >> 16, value >> 8 & 0xFF) not in self.objects:
            raise Abort(0x06020000)
        if mapping and not sub and sum(self.get(index, place) & 0xFF for place in range(1, value + 1)) > 64:
            raise Abort(0x06040042)


def standard_objects(number, rated):
    """Index and sub-index -> form, value, access."""
    yield (0x1000, 0), ["<I", 0x00020192, "ro"]
    yield (0x1001, 0), ["<B", 0, "ro"]
    yield (0x1003, 0), ["<B", 1, "rw"]
    yield (0x1003, 1), ["<I", 0x00008130, "ro"]
    yield (0x1005, 0), ["<I", 0x80, "rw"]
    yield (0x1006, 0), ["<I", 0, "rw"]
    yield (0x1008, 0), ["text", f"Example Drive {number}", "ro"]
    yield (0x1010, 1), ["<I", 1, "rw"]
    yield (0x1011, 1), ["<I", 1, "rw"]
    yield (0x1016, 1), ["<I", 0, "rw"]
    yield (0x1017, 0), ["<H", 0, "rw"]
    for sub, value in enumerate((0x1234, 0x402, 0x10001, 1000 + number), 1):
        yield (0x1018, sub), ["<I", value, "ro"]
    for base, identifier in ((0x1400, 0x200), (0x1800, 0x180)):
        yield (base, 1), ["<I", INVALID | identifier + number, "rw"]
        yield (base, 2), ["<B", 255, "rw"]
        yield (base + 0x200, 0), ["<B", 0, "rw"]
        for sub in range(1, 9):
            yield (base + 0x200, sub), ["<I", 0, "rw"]
    for place in (1, 2, 3):  # on, as delivered
        yield (0x1400 + place, 1), ["<I", 0x200 + 0x100 * place + number, "rw"]
    yield (0x1801, 1), ["<I", 0x280 + number, "rw"]
    numbers = {
        0x6007: ("<h", 1), 0x603F: ("<H", 0), 0x6040: ("<H", 0), 0x6041: ("<H", 0x0250), 0x605A: ("<h", 2),
        0x605E: ("<h", 0), 0x6060: ("<b", 0), 0x6061: ("<b", 0), 0x6064: ("<i", 0), 0x6065: ("<I", 100000),
        0x6066: ("<H", 10), 0x6075: ("<I", rated), 0x6076: ("<I", 2000), 0x6077: ("<h", 0),
        0x6078: ("<h", 0), 0x607A: ("<i", 0), 0x6502: ("<I", 0x3AD),
    }  # fmt: skip
    for index, (form, value) in numbers.items():
        yield (index, 0), [form, value, "ro" if index in READ_ONLY else "rw"]
    yield (0x607D, 1), ["<i", -(2**31), "rw"]
    yield (0x607D, 2), ["<i", 2**31 - 1, "rw"]
    yield (0x60C2, 1), ["<B", 20, "rw"]
    yield (0x60C2, 2), ["<b", -3, "rw"]


READ_ONLY = (0x603F, 0x6041, 0x6061, 0x6064, 0x6075, 0x6076, 0x6077, 0x6078, 0x6502)
