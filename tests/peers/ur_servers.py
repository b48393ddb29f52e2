"""The servers of a Universal Robots controller: RTDE by its public protocol, and lines of text."""

import socket
import struct

HEAD = struct.Struct(">Hc")
FORMATS = {
    "BOOL": "?", "UINT8": "B", "UINT32": "I", "UINT64": "Q", "INT32": "i", "DOUBLE": "d", "VECTOR3D": "3d",
    "VECTOR6D": "6d", "VECTOR6INT32": "6i", "VECTOR6UINT32": "6I",
}  # fmt: skip
FULL = 1 << 20
"""Bytes that nobody takes, after which a client is given up."""


def listening(address):
    """A socket on a free port that never waits."""
    server = socket.create_server((address, 0))
    server.setblocking(False)
    return server


class Connection:
    """One client's connection, which never waits."""

    def __init__(self, link):
        self.link, self.open, self.waiting = link, True, b""
        link.setblocking(False)
        link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def received(self):
        """What has come since the last time."""
        data = b""
        while self.open:
            try:
                more = self.link.recv(65536)
            except BlockingIOError:
                return data
            except OSError:
                more = b""
            if not more:
                self.close()
            data += more
        return data

    def send(self, data):
        self.waiting += data
        try:
            self.waiting = self.waiting[self.link.send(self.waiting) :]
        except BlockingIOError:
            if len(self.waiting) > FULL:
                self.close()
        except OSError:
            self.close()

    def close(self):
        self.open = False
        self.link.close()


class TextServer(Connection):
    """Hands over what a client sends: line by line, or from a `def` to its `end` in the first column."""

    def __init__(self, link, take, until="\nend\n"):
        super().__init__(link)
        self.take, self.until, self.text = take, until, ""

    def receive(self):
        self.text += self.received().decode()
        while self.until in self.text:
            one, _, self.text = self.text.partition(self.until)
            self.take(one + self.until)


class RtdeClient(Connection):
    """One client of RTDE; the controller has `type_of`, `value`, `type_of_input`, `inputs` and `version`."""

    def __init__(self, link, controller):
        super().__init__(link)
        self.controller, self.data, self.started = controller, b"", False
        self.protocol, self.every, self.number = 1, 1, 0
        self.names, self.recipes, self.held = [], {}, None
        self.outbox = []

    def receive(self):
        self.data += self.received()
        while len(self.data) >= HEAD.size:
            size, kind = HEAD.unpack_from(self.data)
            if size < HEAD.size:
                self.close()
            if len(self.data) < size or not self.open:
                return
            body, self.data = self.data[HEAD.size : size], self.data[size:]
            if kind == b"U":
                self.take(body)
            else:
                self.package(kind, self.answer(kind, body))

    def package(self, kind, body):
        self.send(HEAD.pack(HEAD.size + len(body), kind) + body)

    def answer(self, kind, body):
        if kind == b"V":
            (asked,) = struct.unpack(">H", body)
            taken = asked <= self.controller.given.protocol
            self.protocol = asked if taken else self.protocol
            return bytes([taken])
        if kind == b"v":
            return struct.pack(">4I", *self.controller.version)
        if kind == b"O":
            return self.outputs(body)
        if kind == b"I":
            return self.inputs(body.decode().split(","))
        if kind in b"SP":
            self.started = kind == b"S" and bool(self.names)
            return bytes([self.started or kind == b"P"])
        return b""

    def outputs(self, body):
        own = 1.0 / self.controller.step
        frequency = own
        if self.protocol > 1:
            (frequency,), body = struct.unpack_from(">d", body), body[8:]
        self.every = max(round(own / frequency), 1)
        names = body.decode().split(",")
        types = [self.controller.type_of(name) for name in names]
        good = "NOT_FOUND" not in types
        self.names = names if good else []
        self.format = ">B" + "".join(FORMATS[kind] for kind in types) if good else ""
        return bytes([good] * (self.protocol > 1)) + ",".join(types).encode()

    def inputs(self, names):
        types = [self.controller.type_of_input(name) for name in names]
        good = all(kind in FORMATS for kind in types)
        number = len(self.recipes) + 1 if good else 0
        if good:
            self.recipes[number] = names, ">B" + "".join(FORMATS[kind] for kind in types)
        return bytes([number]) + ",".join(types).encode()

    def take(self, body):
        if not self.started or body[0] not in self.recipes:
            return
        names, layout = self.recipes[body[0]]
        self.controller.inputs.update(zip(names, struct.unpack(layout, body)[1:], strict=True))

    def dispatch(self):
        self.number += 1
        if self.held is not None and self.controller.time >= self.held:
            self.held = None
        if not self.started or self.number % self.every or not self.open:
            return
        values = []
        for name in self.names:
            kind, value = self.controller.value(name)
            values += list(value) if kind.startswith("VECTOR") else [value]
        body = struct.pack(self.format, 1, *values)
        self.outbox.append(HEAD.pack(HEAD.size + len(body), b"U") + body)
        if self.held is None:
            self.send(b"".join(self.outbox))
            self.outbox = []

    def hold(self, seconds):
        self.held = self.controller.time + seconds

    def say(self, text):
        body = bytes([len(text)]) + text.encode() + bytes([4]) + b"peer" + b"\x01"
        self.package(b"M", body)
