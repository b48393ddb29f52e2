import os
import subprocess
import sys
import threading
import time
import tty

import pytest

from exidyn.drivers.errors import BadSettings, LinkLost, NotReady
from exidyn.drivers.host_clock import HOST, Clock
from exidyn.drivers.servo import serial_port
from exidyn.drivers.servo.serial_port import SerialPort, adapter_latency

from ...parts.system_needs import TERMINALS


@pytest.fixture
def line():
    """Our end of a line, and the name of the other."""
    TERMINALS.require()
    master, slave = os.openpty()
    for end in (master, slave):
        tty.setraw(end)
    yield master, os.ttyname(slave)
    for end in (master, slave):
        try:
            os.close(end)
        except OSError:
            pass


@pytest.fixture
def opened(line):
    """Our end of a line, and a port at the other."""
    port = SerialPort(line[1], 1_000_000, 5.0)
    yield line[0], port
    port.close()


def test_bytes_go_both_ways(opened):
    master, port = opened
    port.write(b"question")
    assert os.read(master, 100) == b"question"
    os.write(master, b"answer")
    assert port.read(6) == b"answer"


def test_a_read_takes_no_more_than_it_should_and_waits_for_bytes_that_come_in_pieces(opened):
    master, port = opened
    os.write(master, b"abc")
    later = threading.Timer(0.02, os.write, (master, b"defgh"))
    later.start()
    assert port.read(6) == b"abcdef"
    later.join()
    assert port.waiting == 2


def test_a_read_that_meets_its_deadline_is_short_and_what_nobody_wants_is_thrown_away(opened):
    master, port = opened
    port.set_patience(0.01)
    os.write(master, b"abc")
    assert port.read(6) == b"abc"
    os.write(master, b"abc")
    assert port.read(1) == b"a"
    assert port.drain() == 2
    assert port.drain() == 0


def test_a_port_that_is_not_there_is_reported_with_those_that_are():
    with pytest.raises(BadSettings, match="/dev/nothing does not open at 1000000 bit/s.*Ports found:"):
        SerialPort("/dev/nothing", 1_000_000, 0.1)


def test_a_port_that_another_program_has_is_not_taken(line):
    _, name = line
    hold = (
        "import sys, exidyn.drivers.servo.serial_port as s\n"
        f"port = s.SerialPort({name!r}, 1_000_000, 0.1)\nprint('held', flush=True)\nsys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", hold], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout.readline() == b"held\n"
        with pytest.raises(NotReady, match="in use by another program"):
            SerialPort(name, 1_000_000, 0.1)
        other.stdin.close()


def test_a_port_that_goes_away_is_a_lost_link(line):
    master, name = line
    port = SerialPort(name, 1_000_000, 0.1)
    os.close(master)
    with pytest.raises(LinkLost, match="is gone"):
        port.read(1)
    port.close()
    port.close()
    with pytest.raises(LinkLost, match="is gone"):
        port.write(b"x")


def test_the_latency_of_an_adapter_is_found(tmp_path):
    (tmp_path / "ttyUSB7").mkdir()
    (tmp_path / "ttyUSB7" / "latency_timer").write_text("16\n")
    assert adapter_latency("/dev/ttyUSB7", tmp_path) == pytest.approx(0.016)
    assert adapter_latency("/dev/ttyACM0", tmp_path) == 0.0


def come(master, port, data):
    """Send to a port, and wait until it has all."""
    os.write(master, data)
    while port.waiting < len(data):
        time.sleep(0.001)


@pytest.mark.parametrize("direct", [True, False])
def test_a_port_reports_whether_a_read_had_to_wait(opened, direct):
    master, port = opened
    port._direct = direct  # not so on Windows
    come(master, port, b"abcdef")
    assert port.read(3) == b"abc"
    assert not port.waited

    def written_first(wait):
        return lambda *arguments: os.write(master, b"gh") and wait(*arguments)

    port.clock = Clock()
    port.clock.readable = written_first(HOST.readable)
    read, port._port.read = port._port.read, written_first(port._port.read)
    assert port.read(5) == b"defgh"
    assert port.waited
    port.clock, port._port.read = HOST, read
    port.set_patience(0.01)
    assert port.read(1) == b""
    come(master, port, b"ijk")
    assert port.drain() == 3
    port.write(b"question")
    assert os.read(master, 100) == b"question"


@pytest.mark.parametrize("direct", [True, False])
def test_all_bytes_of_a_long_packet_are_sent(opened, direct, monkeypatch):
    master, port = opened
    monkeypatch.setattr(serial_port, "WRITE_WITHIN", 60.0)
    port._direct = direct
    packet = bytes(range(256)) * 256  # more than a terminal takes at once
    sender = threading.Thread(target=port.write, args=(packet,))
    sender.start()
    came = b""
    while len(came) < len(packet):
        came += os.read(master, 65536)
    sender.join()
    assert came == packet


def test_a_port_that_takes_nothing_is_not_waited_for(opened):
    _, port = opened
    port.set_patience(0.1)
    for _ in range(50):  # far more than a pseudo-terminal keeps
        port.write(bytes(1000))
