"""The bus ends that peers on CAN sit at: multicast that does not leave this machine, or a serial adapter."""

import os
import select
import socket
import struct
import tty

import can
from can.interfaces.udp_multicast.utils import pack_message, unpack_message

SO_TIMESTAMPNS = 35
"""Linux gives the receive time with each datagram; the socket module has no name for it."""

CHANNEL = "ff11:7079:7468:6f6e:6465:6d6f:6d63:6173"
"""Interface-local scope: no frame leaves the machine."""
NO_BUS = 77
"""Exit status of a peer that could not open its bus."""


def free_port():
    """A UDP port of this test's own, so that parallel ones do not meet."""
    with socket.socket(socket.AF_INET6, socket.SOCK_DGRAM) as probe:
        probe.bind(("::", 0))
        return probe.getsockname()[1]


def multicast(port):
    """A python-can bus on that port."""
    return can.Bus(channel=CHANNEL, interface="udp_multicast", port=port, fd=False, ignore_config=True)


class SerialAdapter:
    """A CAN adapter with slcan over a pseudo-terminal, with the nodes on its other side."""

    def __init__(self):
        self._master, slave = os.openpty()
        tty.setraw(self._master)
        tty.setraw(slave)
        self.address, self._slave = os.ttyname(slave), slave
        self._text, self._frames, self._open = b"", [], False

    def recv(self, timeout):
        if not self._frames and select.select([self._master], [], [], timeout)[0]:
            self._text += os.read(self._master, 4096)
            *lines, self._text = self._text.split(b"\r")
            self._frames += filter(None, map(self._understand, lines))
        return self._frames.pop(0) if self._frames else None

    def send(self, message):
        if self._open:
            data = bytes(message.data).hex().upper()
            kind = (
                f"T{message.arbitration_id:08X}"
                if message.is_extended_id
                else f"t{message.arbitration_id:03X}"
            )
            os.write(self._master, f"{kind}{message.dlc}{data}\r".encode())

    def garbage(self, data):
        os.write(self._master, data)

    def shutdown(self):
        os.close(self._master)
        os.close(self._slave)

    def _understand(self, line):
        text = line.decode("ascii", "replace")
        if text[:1] == "S":
            print(f"adapter got {text}", flush=True)
        elif text[:1] in ("O", "C"):
            self._open = text[0] == "O"
        elif text[:1] == "t" and self._open:
            data = bytes.fromhex(text[5:])
            return can.Message(arbitration_id=int(text[1:4], 16), data=data, is_extended_id=False)
        return None


class Multicast:
    """A python-can bus that spends no time on its own echo, and can send what is no frame."""

    def __init__(self, port=0):
        port = port or free_port()
        self.address, self._group = str(port), (CHANNEL, port)
        self._bus = multicast(port)
        self._socket = socket.socket(fileno=os.dup(self._bus.fileno()))
        self._socket.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        self._echoes = set()

    def recv(self, timeout):
        if not select.select([self._socket], [], [], timeout)[0]:
            return None
        data, stamps, *_ = self._socket.recvmsg(4096, socket.CMSG_SPACE(16))
        if data in self._echoes:
            self._echoes.discard(data)
            return None
        message = unpack_message(data, check=True)
        for level, kind, stamp in stamps:  # when the kernel had it, however late this process is
            if level == socket.SOL_SOCKET and kind == SO_TIMESTAMPNS:
                seconds, rest = struct.unpack("qq", stamp)
                message.timestamp = seconds + 1e-9 * rest
        return message

    def send(self, message):
        data = pack_message(message)
        self._echoes.add(data)
        self._socket.sendto(data, self._group)

    def garbage(self, data):
        self._socket.sendto(data, self._group)

    def shutdown(self):
        self._socket.close()
        self._bus.shutdown()


def frame(identifier, data):
    """A classic frame with an 11-bit identifier."""
    return can.Message(arbitration_id=identifier, data=data, is_extended_id=False)


def noise(end, random, identifiers):
    """Send what is of no use: foreign frames, frames of wrong lengths on known identifiers, and garbage."""
    for _ in range(4):
        kind = random.integers(5)
        data = random.bytes(int(random.integers(9)))
        known = int(random.choice(identifiers))
        if kind == 0:
            end.send(can.Message(arbitration_id=int(random.integers(2**29)), data=data, is_extended_id=True))
        elif kind == 1:
            end.send(frame(int(random.integers(0x690, 0x6F0)), data))
        elif kind == 2:
            end.send(frame(known, data[:5]))
        elif kind == 3:
            remote = can.Message(arbitration_id=known, is_remote_frame=True, is_extended_id=False)
            end.send(remote)
        else:
            end.garbage(data or b"\xff")
