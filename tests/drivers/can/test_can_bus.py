"""The CAN bus in use: its load, its options, and that nothing on it raises."""

import re
import tomllib
from pathlib import Path

import can
import numpy as np
import pytest

from exidyn.drivers import create
from exidyn.drivers.can import can_bus
from exidyn.drivers.can.can_bus import CanBus, bus_load, frame_bits, read_options, require_room
from exidyn.drivers.can_mit.mit_motors import MotorRound, Request
from exidyn.drivers.can_mit.settings import MitSettings
from exidyn.drivers.canopen_402.cia402 import Entry
from exidyn.drivers.canopen_402.frames import Frames
from exidyn.drivers.errors import BadSettings, LinkLost
from exidyn.drivers.settings import read_settings

from ...parts.controllers.can_peers import ARM
from ...peers.can_arm import MASTER, mit_settings

CURRENT = Entry(0x6078, 0, "<h", "current")


class Script(can.BusABC):
    """A bus that gives what it is set to: frames, errors, or nothing."""

    def __init__(self, answers):
        self.channel_info = "script"
        super().__init__("script")
        self.answers, self.sent = list(answers), []

    def send(self, msg, timeout=None):
        self.sent.append((msg.arbitration_id, bytes(msg.data)))

    def _recv_internal(self, timeout):
        answer = self.answers.pop(0) if self.answers else None
        if isinstance(answer, Exception):
            raise answer
        return answer, False


@pytest.fixture
def scripted(monkeypatch):
    """Makes a CanBus of a script; closes them all."""
    opened = []

    def make(answers=()):
        bus = Script(answers)
        monkeypatch.setattr(can, "Bus", lambda **_: bus)
        opened.append(CanBus("virtual", "0", 1_000_000))
        return opened[-1], bus

    yield make
    for bus in opened:
        bus.shutdown()


def frame(identifier, data):
    return can.Message(arbitration_id=identifier, data=data, is_extended_id=False)


def stuffed(bits):
    """Bits of a frame with its stuffing, as a controller adds it."""
    sent, run = [], 0
    for bit in bits:
        run = run + 1 if sent and bit == sent[-1] else 1
        sent.append(bit)
        if run == 5:
            sent.append(1 - bit)
            run = 1
    return sent


@pytest.mark.parametrize("data", range(9))
def test_no_frame_is_longer_than_its_worst_case(data):
    random = np.random.default_rng(data)
    region = 34 + 8 * data
    worst = ([0] * 5 + [1] * 4 + [0] * 4) + [1, 1, 1, 1, 0, 0, 0, 0] * region
    tries = [worst[:region]] + [list(random.integers(2, size=region)) for _ in range(50)]
    longest = max(len(stuffed(bits)) for bits in tries) + 13  # delimiters, acknowledgement, end and silence
    assert longest <= frame_bits(data)
    assert frame_bits(data) - len(stuffed(worst[:region])) - 13 <= 1


def test_load_of_six_drives_at_500_hz():
    frames = [6] * 6 + [0] + [8] * 6
    assert sum(map(frame_bits, frames)) == 1555
    assert bus_load(frames, 0.002, 1_000_000) == pytest.approx(0.7775)


def test_a_bus_without_room_is_refused_with_what_to_try():
    assert require_room([8] * 12, 0.002, 1_000_000) == pytest.approx(0.81)
    with pytest.raises(BadSettings, match="162 % of 500 kbit/s, limit 95 %. Try cycle = 0.004"):
        require_room([8] * 12, 0.002, 500_000)


def test_examples_in_the_handbook_are_valid():
    text = (Path(__file__).parents[3] / "docs" / "how-to-can.md").read_text(encoding="utf-8")
    examples = [tomllib.loads(example) for example in re.findall(r"```toml\n(.*?)```", text, re.DOTALL)]
    assert [example["driver"] for example in examples] == ["canopen_402", "can_mit"]
    for example in examples:
        create(example["driver"], example["settings"], ARM)


def test_options_are_read_for_what_they_are():
    assert read_options("port=43113, fd=false,rtscts=True , name=x, wait=0.5") == {
        "port": 43113, "fd": False, "rtscts": True, "name": "x", "wait": 0.5,
    }  # fmt: skip
    assert read_options("") == {}


@pytest.mark.parametrize(
    ("interface", "error", "words"),
    [
        (
            "udp_multicast",
            can.CanInterfaceNotImplementedError("msgpack not installed"),
            "'pip install msgpack'",
        ),
        ("gs_usb", can.CanInterfaceNotImplementedError("No module named 'usb'"), "'pip install gs-usb'"),
        ("neovi", ImportError("Please install python-ics"), "'pip install python-ics filelock'"),
        ("vector", can.CanInterfaceNotImplementedError("no vxlapi64"), "see its page on 'vector'"),
    ],
)
def test_what_an_interface_needs_and_is_not_installed_is_named(monkeypatch, interface, error, words):
    def no_bus(**_):
        raise error

    monkeypatch.setattr(can, "Bus", no_bus)
    with pytest.raises(LinkLost) as caught:
        CanBus(interface, "0", 1_000_000)
    assert str(error) in str(caught.value)
    assert words in str(caught.value)
    assert "plugged in" not in str(caught.value)


def test_python_can_states_that_msgpack_is_missing(monkeypatch):
    """As it does of itself, not as this project imagines it."""
    utils = pytest.importorskip("can.interfaces.udp_multicast.utils")
    monkeypatch.setattr(utils, "msgpack", None)
    with pytest.raises(LinkLost, match=r"python-can needs msgpack for this interface: 'pip install msgpack'"):
        CanBus("udp_multicast", "ff11:7079:7468:6f6e:6465:6d6f:6d63:6173", 1_000_000, "fd=false")


def test_the_extra_can_brings_what_the_how_to_needs():
    root = Path(__file__).parents[3]
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    names = {re.split(r"[^\w-]", text)[0] for text in project["optional-dependencies"]["can"]}
    how_to = (root / "docs" / "how-to-can.md").read_text(encoding="utf-8")
    used = re.findall(r'interface = "(\w+)"', how_to)
    assert used
    assert all(can_bus.PACKAGES.get(interface, "python-can") in names for interface in used)


def test_a_frame_that_cannot_be_read_is_reported_once_and_survived(scripted):
    bad = ValueError("noise")
    bus, _ = scripted([bad, bad, frame(0x181, b"12345678")])
    assert bus.receive(0.0) is None
    assert bus.receive(0.0) is None
    assert bus.receive(0.0)[0] == 0x181
    assert bus.unreadable == 2
    assert bus.events() == ["a CAN frame could not be read: ValueError: noise"]
    assert bus.events() == []
    assert not bus.trouble


@pytest.mark.parametrize("operation", ["read", "sent"])
def test_a_bus_that_only_fails_is_given_up(scripted, monkeypatch, operation):
    error = can.CanOperationError("unplugged")
    bus, script = scripted([error, error])
    monkeypatch.setattr(script, "send", lambda *_: (_ for _ in ()).throw(error))

    def fail():
        return bus.receive(0.0) if operation == "read" else bus.send(frame(1, b""))

    assert fail() is None
    assert not bus.trouble
    monkeypatch.setattr(can_bus, "PATIENCE", -1.0)
    assert fail() is None
    assert f"nothing can be {operation} any more: CanOperationError: unplugged" in bus.trouble


def test_error_frames_of_the_controller_are_understood(scripted):
    passive = can.Message(is_error_frame=True, arbitration_id=0x04, data=bytes([0, 0x20] + 6 * [0]))
    off = can.Message(is_error_frame=True, arbitration_id=0x40, data=bytes(8))
    bus, _ = scripted([passive, off])
    assert bus.receive(0.0) is None
    assert "is there no acknowledge" in bus.events()[0]
    assert bus.receive(0.0) is None
    assert "bus-off" in bus.trouble


def rounds(bus):
    """Both cyclic parts, of six joints."""
    settings = read_settings(MitSettings, mit_settings("43113"), 6, "test")
    yield Frames(bus, range(1, 7), list(ARM.joints), 127, 0.05, 10.0, [CURRENT] * 6, [True] * 6)
    yield MotorRound(bus, settings.motors(ARM.joints))


def test_whatever_comes_from_outside_raises_nothing(scripted):
    random = np.random.default_rng(0)

    def anything():
        kind = random.integers(8)
        data = random.bytes(int(random.integers(9)))
        known = int(
            random.choice([0x80, 0x181, 0x182, 0x081, 0x701, 0x581, 0x7FF, MASTER + 1, MASTER + 2, 0])
        )
        if kind == 0:
            return ValueError("noise")
        if kind == 1:
            return can.Message(arbitration_id=int(random.integers(2**29)), data=data)
        if kind == 2:
            return can.Message(arbitration_id=known, is_remote_frame=True, is_extended_id=False)
        if kind == 3:
            return can.Message(arbitration_id=int(random.integers(256)), is_error_frame=True, data=data)
        return frame(known if kind < 7 else int(random.integers(2048)), data)

    for which in (0, 1):
        bus, script = scripted(anything() for _ in range(5000))
        talk = list(rounds(bus))[which]
        while script.answers:
            talk.cycle(0.0)
            assert len(talk.events()) <= 50


def test_a_late_answer_does_not_count_for_the_next_question(scripted):
    measured = frame(0x181, bytes.fromhex("3712E80300000500"))
    bus, script = scripted([measured, ValueError("noise"), measured, None])
    talk = next(rounds(bus))
    talk.cycle(0.0)
    assert talk.fresh == [False] * 6
    assert (talk.status[0], talk.position[0], talk.effort[0]) == (0x1237, 1000, 5)
    script.answers = [None, measured, None]
    talk.cycle(0.0)
    assert talk.fresh == [False] * 6  # it may be the answer to the first question
    script.answers = [None, measured, None]
    talk.cycle(0.0)
    assert talk.fresh == [True] + [False] * 5


def test_a_long_effort_comes_alone_and_an_answer_is_both_frames(scripted):
    alone = Entry(0x606C, 0, "<i", "current")
    stood, following = frame(0x181, bytes.fromhex("3712E8030000")), frame(0x281, bytes.fromhex("FEFFFFFF"))
    bus, script = scripted([None, stood, None])
    talk = Frames(bus, [1], ["joint1"], 127, 0.05, 10.0, [alone], [True])
    talk.cycle(0.0)
    assert talk.fresh == [False]
    for answers in ([following, stood], [stood, following]):
        script.answers = [None, *answers, None]
        talk.begin()
        script.answers = [None, *answers, None]
        talk.cycle(0.0)
        assert talk.fresh == [True]
        assert (talk.position[0], talk.effort[0]) == (1000, -2)
    script.answers = [None, following, following, None]
    talk.cycle(0.0)
    assert talk.fresh == [False]


def test_a_drive_without_heartbeat_is_not_missed_for_it(scripted):
    bus, _ = scripted()
    beating = Frames(bus, [1, 2], ["joint1", "joint2"], 127, 0.05, 1e-9, [CURRENT] * 2, [False, True])
    beating.cycle(0.0)
    assert beating.fault.startswith("joint2: its heartbeat is lost")
    silent = Frames(bus, [1], ["joint1"], 127, 0.05, 1e-9, [CURRENT], [False])
    silent.begin()
    silent.cycle(0.0)
    assert not silent.fault


def test_targets_are_sent_before_sync_and_nothing_before_they_are_to_be(scripted):
    bus, script = scripted()
    talk = next(rounds(bus))
    talk.cycle(0.0)
    assert script.sent == [(0x080, b"")]
    script.sent.clear()
    talk.commanding, talk.control, talk.target = True, [0x0F] * 6, [-1, 2, 3, 4, 5, 6]
    talk.cycle(0.0)
    identifiers = [identifier for identifier, _ in script.sent]
    assert identifiers == [0x201, 0x202, 0x203, 0x204, 0x205, 0x206, 0x77F, 0x080]
    assert script.sent[0][1] == bytes.fromhex("0F00FFFFFFFF")
    assert script.sent[6][1] == b"\x05"


def test_listening_to_a_motor_does_not_command_it(scripted):
    bus, script = scripted()
    *_, talk = rounds(bus)
    talk.cycle(0.0)
    assert {identifier for identifier, _ in script.sent} == {0x7FF}
    assert script.sent[2][1] == bytes([3, 0, 0xCC, 0, 0, 0, 0, 0])
    script.sent.clear()
    talk.request[2] = Request.ENABLE
    talk.cycle(0.0)  # none has answered: none is asked, so that what comes now is known to be late
    assert script.sent == []
    talk.cycle(0.0)
    assert script.sent[2] == (3, b"\xff" * 7 + b"\xfc")
