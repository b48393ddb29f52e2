"""The bus ends that peers on CAN sit at: multicast that does not leave this machine, or a serial adapter."""

import os
import socket
import struct
import tty

import can
from can.interfaces.udp_multicast.utils import pack_message, unpack_message
from can_arm import CHANNEL, free_port, multicast
from virtual_clock import of_this_peer

CLOCK = of_this_peer()
SO_TIMESTAMPNS = 35
"""Linux gives the receive time with each datagram; the socket module has no name for it."""

NO_BUS = 77
"""Exit status of a peer that could not open its bus."""


class SerialAdapter:
    """A CAN adapter with slcan over a pseudo-terminal, with the nodes on its other side."""

    def __init__(self):
        self._master, slave = os.openpty()
        tty.setraw(self._master)
        tty.setraw(slave)
        self.address, self._slave = os.ttyname(slave), slave
        self._text, self._frames, self._open = b"", [], False

    def recv(self, timeout):
        if not self._frames and CLOCK.readable([self._master], timeout):
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
        if not CLOCK.readable([self._socket], timeout):
            return None
        data, stamps, *_ = self._socket.recvmsg(4096, socket.CMSG_SPACE(16))
        if data in self._echoes:
            self._echoes.discard(data)
            return None
        message = unpack_message(data, check=True)
        for level, kind, stamp in stamps:  # when the kernel had it, however late this process is
            if level == socket.SOL_SOCKET and kind == SO_TIMESTAMPNS:
                seconds, rest = struct.unpack("qq", stamp)
                late = CLOCK.age(seconds * 1_000_000_000 + rest)
                message.timestamp = 1e-9 * (CLOCK.host_time() - late)
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
