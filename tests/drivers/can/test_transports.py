"""Transports: they send and receive what python-can does, frame by frame."""

import os
import select
import socket
import tty

import can
import pytest
from can.interfaces.udp_multicast.utils import pack_message

from exidyn.drivers.can.transports import ERROR, OTHER, PythonCanTransport, SlcanTransport, transport_of
from exidyn.drivers.host_clock import Pause

from ...parts.system_needs import MULTICAST, TERMINALS
from ...peers.can_arm import free_port
from ...peers.can_arm import multicast as bus_on

FRAMES = [(0x181, b"12345678"), (0x000, b"\x01\x05"), (0x080, b""), (0x7FF, b"\xff\xa4data\xc4")]


@pytest.fixture
def socketcan(monkeypatch):
    """A transport on a bus of python-can, and the kernel's side of its socket."""
    module = pytest.importorskip("can.interfaces.socketcan.socketcan")
    ours, kernel = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    monkeypatch.setattr(module, "create_socket", lambda: ours)
    monkeypatch.setattr(module, "bind_socket", lambda *_: None)
    with kernel, can.Bus("can0", interface="socketcan", ignore_config=True) as bus:
        yield transport_of(bus, "socketcan"), kernel


@pytest.fixture
def serial():
    """A transport on a pseudo-terminal, and the adapter's side of it."""
    TERMINALS.require()
    master, slave = os.openpty()
    tty.setraw(master)
    tty.setraw(slave)
    options = {"interface": "slcan", "bitrate": 1_000_000, "sleep_after_open": 0, "ignore_config": True}
    bus = can.Bus(channel=os.ttyname(slave), **options)
    while select.select([master], [], [], 0.0)[0]:
        os.read(master, 4096)
    yield transport_of(bus, "slcan"), master
    bus.shutdown()
    os.close(master)
    os.close(slave)


@pytest.fixture
def multicast():
    """A transport, and another bus of python-can's on the same group."""
    MULTICAST.require()
    port = free_port()
    ours, theirs = bus_on(port), bus_on(port)
    yield transport_of(ours, "udp_multicast"), theirs
    ours.shutdown()
    theirs.shutdown()


def test_socketcan_frames_are_those_of_the_kernel(socketcan):
    build = pytest.importorskip("can.interfaces.socketcan.socketcan").build_can_frame
    transport, kernel = socketcan
    transport.send(FRAMES, 0.1)
    for identifier, data in FRAMES:
        message = can.Message(arbitration_id=identifier, data=data, is_extended_id=False)
        assert kernel.recv(100) == build(message)


@pytest.mark.parametrize(
    ("kind", "flags"),
    [
        ({}, 0),
        ({"is_extended_id": True}, OTHER),
        ({"is_remote_frame": True}, OTHER),
        ({"is_error_frame": True}, ERROR),
        ({"is_fd": True}, OTHER),
    ],
)
def test_socketcan_frames_of_each_kind_are_known_by_their_flags(socketcan, kind, flags):
    build = pytest.importorskip("can.interfaces.socketcan.socketcan").build_can_frame
    transport, kernel = socketcan
    data = b"" if "is_remote_frame" in kind else b"123"
    kernel.send(build(can.Message(arbitration_id=0x123, data=data, **{"is_extended_id": False, **kind})))
    assert transport.receive(1.0) == (0x123 | flags, data)
    assert transport.receive(0.0) is None


def test_socketcan_frames_of_other_programs_on_this_computer_are_received():
    class Bus:
        def recv(self, timeout):
            return can.Message(arbitration_id=0x201, data=b"1", is_extended_id=False, is_rx=False)

    assert transport_of(Bus(), "socketcan").receive(0.0) == (0x201, b"1")


def test_a_full_socket_is_an_error_after_the_time_out_and_the_other_frames_are_tried(socketcan):
    transport, kernel = socketcan
    with pytest.raises(can.CanOperationError, match="full"):
        _fill(transport)
    tried = []
    transport._bus.send = lambda message, timeout: tried.append(message.arbitration_id) or 1 / 0
    with pytest.raises(ZeroDivisionError):
        transport.send(FRAMES, 0.001)
    assert tried == [identifier for identifier, _ in FRAMES]


def test_slcan_lines_are_those_of_python_can(serial):
    transport, adapter = serial
    transport.send(FRAMES, 0.1)
    assert os.read(adapter, 4096) == b"t18183132333435363738\rt00020105\rt0800\rt7FF7FFA464617461C4\r"


def test_many_lines_in_one_reading_and_lines_in_pieces(serial):
    transport, adapter = serial
    os.write(adapter, b"z\rt1812A1B2\rT00000123100\rr1230\r\at2")
    assert transport.receive(1.0) == (0x181, b"\xa1\xb2")
    assert transport.receive(1.0) == (0x123 | OTHER, b"\x00")
    assert transport.receive(1.0) == (0x123 | OTHER, b"")
    assert transport.receive(0.0) is None
    os.write(adapter, b"81111ABCD\r")  # the last four digits are a time stamp
    assert transport.receive(1.0) == (0x281, b"\x11")


@pytest.mark.parametrize("line", [b"t18", b"t1819", b"t1812A1", b"tXYZ0", b"t8000", b"t1812\xff\xff"])
def test_a_broken_line_is_an_error_and_the_next_is_read(serial, line):
    transport, adapter = serial
    os.write(adapter, line + b"\rt1810\r")
    with pytest.raises(ValueError):  # noqa: PT011 - of several kinds
        transport.receive(1.0)
    assert transport.receive(1.0) == (0x181, b"")


def test_an_adapter_that_is_gone_is_an_error(serial, monkeypatch):
    transport, adapter = serial
    os.write(adapter, b"t1810\r")
    monkeypatch.setattr(os, "read", lambda *_: b"")
    with pytest.raises(OSError, match="gone"):
        transport.receive(1.0)


def test_multicast_frames_are_those_of_python_can_both_ways(multicast):
    transport, other = multicast
    transport.send(FRAMES, 0.1)
    for identifier, data in FRAMES:
        message = other.recv(1.0)
        seen = (message.arbitration_id, bytes(message.data), message.is_extended_id)
        assert seen == (identifier, data, False)
    assert transport.receive(0.05) is None  # what it has sent itself
    for extended in (False, True) * 2:
        for data in (FRAMES[0][1], b"\xa4data\xc4\x01x", b""):  # the first is also one that it has sent
            other.send(can.Message(arbitration_id=0x181, data=data, is_extended_id=extended))
            assert transport.receive(1.0) == (0x181 | OTHER * extended, data)


WHOLE = pack_message(can.Message(arbitration_id=0x181, data=b"12345678", is_extended_id=False))


@pytest.mark.parametrize(
    "datagram",
    [
        b"", b"\xff", b"\x93\x01\x02\x03", b"\xc1", WHOLE[:-1], WHOLE + b"\x00", WHOLE.replace(b"345", b"")
    ],
)  # fmt: skip
def test_multicast_that_is_no_frame_is_an_error_and_the_next_is_read(multicast, datagram):
    transport, other = multicast
    other._multicast.send(datagram)
    other.send(can.Message(arbitration_id=1, data=b"", is_extended_id=False))
    with pytest.raises(Exception):  # noqa: B017, PT011 - of several kinds
        transport.receive(1.0)
    assert transport.receive(1.0) == (1, b"")


def test_any_other_interface_goes_through_python_can():
    with can.Bus("exidyn", interface="virtual") as ours, can.Bus("exidyn", interface="virtual") as other:
        transport = transport_of(ours, "virtual")
        assert isinstance(transport, PythonCanTransport)
        transport.send(FRAMES, 0.1)
        assert [(m.arbitration_id, bytes(m.data)) for m in iter(lambda: other.recv(0.0), None)] == FRAMES
        other.send(can.Message(arbitration_id=5, data=b"1", is_extended_id=False))
        assert transport.receive(1.0) == (5, b"1")
        assert transport.receive(0.0) is None


def test_only_an_slcan_port_with_a_descriptor_is_read_directly(serial):
    class Bus:
        serialPortOrig = object()

    assert isinstance(transport_of(Bus(), "slcan"), PythonCanTransport)
    assert isinstance(serial[0], SlcanTransport)


def test_a_serial_adapter_that_takes_nothing_is_an_error_and_no_line_is_sent_in_pieces(serial):
    transport, adapter = serial
    with pytest.raises(OSError, match="does not take the frames"):
        _fill(transport)
    os.set_blocking(adapter, False)
    text = b""
    while data := _read(adapter):
        text += data
    transport.send([(0x123, b"")], 0.1)
    text += _read(adapter)
    *lines, rest = text.split(b"\r")
    assert rest == b""
    assert lines.pop() == b"t1230"
    assert set(lines) == {b"t2018" + b"12345678".hex().upper().encode()}


def _fill(transport):
    while True:
        transport.send([(0x201, b"12345678")] * 6, 0.001)


def _read(descriptor):
    try:
        return os.read(descriptor, 4096)
    except BlockingIOError:
        return b""


def test_what_an_interface_returns_of_what_was_sent_is_passed_over():
    given = {"channel": "echo", "interface": "virtual", "ignore_config": True}
    with can.Bus(**given, receive_own_messages=True) as ours, can.Bus(**given) as theirs:
        transport = PythonCanTransport(ours, "virtual")
        transport.send([(0x201, b"own")], 0.1)
        theirs.send(can.Message(arbitration_id=0x181, data=b"answer", is_extended_id=False))
        assert transport.receive(1.0) == (0x181, b"answer")
        assert transport.receive(0.0) is None


def test_after_a_pause_of_this_computer_frames_are_held_back_once(socketcan, clock):
    transport, kernel = socketcan
    kernel.setblocking(False)
    transport.pause = Pause(0.01, clock)
    transport.pause.begin()
    clock.sleep(0.05)
    transport.send(FRAMES, 0.1)
    with pytest.raises(BlockingIOError):
        kernel.recv(100)
    assert transport.pause.seconds > 0.01
    transport.pause.patience = transport.pause._limit = float("inf")
    transport.send(FRAMES, 0.1)
    assert len([kernel.recv(100) for _ in FRAMES]) == len(FRAMES)
