"""Packets, registers and peers against the libraries of the servos' makers, as independent references."""

import random
from contextlib import contextmanager

import dynamixel_sdk
import pytest
import scservo_sdk
from dynamixel_easy_sdk.control_table import ControlTable

from exidyn.drivers.dynamixel import packet as dynamixel_packet
from exidyn.drivers.dynamixel import registers as dynamixel_registers
from exidyn.drivers.dynamixel.registers import MODELS
from exidyn.drivers.feetech import driver as feetech
from exidyn.drivers.feetech import packet as feetech_packet
from exidyn.drivers.servo.servo_bus import LENGTHS

from ...parts.controllers.servo_parts import JOINTS, peer, servo

SERVOS = [servo(number) for number in range(JOINTS)]
GOALS = [2048, 0x00FD, 1, 4095, 3000, 7]
REGISTERS = {
    register.name: register
    for register in vars(dynamixel_registers).values()
    if isinstance(register, dynamixel_registers.Register)
}
OTHERWISE = {
    "maximum position limit": "max position limit",
    "minimum position limit": "min position limit",
    "return delay": "return delay time",
}


class Written:
    """A port of either library that keeps what is written, or has something to be read."""

    is_using, data = False, b""

    def clearPort(self):  # noqa: N802 - theirs
        self.data = b""

    def writePort(self, packet):  # noqa: N802
        self.data = bytes(packet)
        return len(packet)

    def readPort(self, count):  # noqa: N802
        data, self.data = self.data[:count], self.data[count:]
        return data

    def isPacketTimeout(self):  # noqa: N802
        return not self.data

    def setPacketTimeout(self, length):  # noqa: N802
        pass


@pytest.fixture
def chance():
    return random.Random(0)


def without_header(chance, length):
    """Bytes of which none is of a Dynamixel's header."""
    return bytes(chance.randrange(0xFD) for _ in range(length))


def test_dynamixel_packets_are_those_of_its_maker(chance):
    port, maker = Written(), dynamixel_sdk.PacketHandler(2.0)
    for _ in range(200):
        servos = chance.sample(range(253), chance.randrange(1, 8))
        address, length = chance.randrange(700), chance.randrange(1, 30)
        read = dynamixel_sdk.GroupSyncRead(port, maker, address, length)
        write = dynamixel_sdk.GroupSyncWrite(port, maker, address, length)
        values = {one: without_header(chance, length) for one in servos}
        for one in servos:
            read.addParam(one)
            write.addParam(one, values[one])
        read.txPacket()
        assert port.data == dynamixel_packet.sync_read(address, length, servos).packet
        port.is_using = False
        read.fastSyncReadTxPacket()
        assert port.data == dynamixel_packet.fast_sync_read(address, length, servos).packet
        port.is_using = False
        write.txPacket()
        assert port.data == dynamixel_packet.sync_write(address, values)


def test_its_maker_understands_dynamixel_packets_with_headers_in_the_data(chance):
    """One header each: behind the first this library goes astray, and what it sends it forgets to stuff."""
    port, maker = Written(), dynamixel_sdk.PacketHandler(2.0)
    for _ in range(500):
        place = chance.randrange(8)
        data = without_header(chance, place) + b"\xff\xff\xfd" + without_header(chance, 7 - place)
        port.data = dynamixel_packet.packet(5, dynamixel_packet.STATUS, b"\0" + data)
        found, result, error = maker.readRx(port, 5, len(data))
        assert (bytes(found), result, error) == (data, 0, 0)


def test_feetech_packets_are_those_of_its_maker(chance):
    port = Written()
    maker = scservo_sdk.sms_sts(port)
    for _ in range(200):
        servos = chance.sample(range(253), chance.randrange(1, 8))
        address, length = chance.randrange(87), chance.randrange(1, 20)
        read = scservo_sdk.GroupSyncRead(maker, address, length)
        write = scservo_sdk.GroupSyncWrite(maker, address, length)
        values = {one: chance.randbytes(length) for one in servos}
        for one in servos:
            read.addParam(one)
            write.addParam(one, list(values[one]))
        read.txPacket()
        assert port.data == feetech_packet.sync_read(address, length, servos).packet
        port.is_using = False
        write.txPacket()
        assert port.data == feetech_packet.sync_write(address, values)


def its_table(model):
    return {name.lower(): item for name, item in ControlTable.getControlTable(model).items()}


@pytest.mark.parametrize("model", sorted(set(MODELS) & set(ControlTable.parsingModelList())))
def test_dynamixel_registers_are_where_its_maker_has_them(model):
    table = its_table(model)
    for name, register in REGISTERS.items():
        item = table[OTHERWISE.get(name, name)]
        assert (item.address, item.size) == (register.address, register.size), name
    measures_current = bool(MODELS[model].current_unit)
    assert (
        table["present current" if measures_current else "present load"].address == dynamixel_registers.FIRST
    )


@pytest.mark.parametrize("model", sorted(set(MODELS) & set(ControlTable.parsingModelList())))
def test_what_is_asked_of_a_dynamixel_in_a_run_its_maker_has_all(model):
    kept = {item.address + byte for item in its_table(model).values() for byte in range(item.size)}
    first, last = dynamixel_registers.FIRST - LENGTHS + 1, dynamixel_registers.FIRST
    assert kept >= set(range(first, last + dynamixel_registers.WARM.itemsize))


def test_feetech_registers_are_where_its_maker_has_them():
    names = {
        "MODEL": feetech.MODEL,
        "MIN_ANGLE_LIMIT": feetech.LOWEST,
        "MAX_ANGLE_LIMIT": feetech.HIGHEST,
        "MODE": feetech.MODE,
        "TORQUE_ENABLE": feetech.TORQUE,
        "ACC": feetech.ACCELERATION,
        "GOAL_POSITION": feetech.GOAL,
        "GOAL_TIME": feetech.GOAL_TIME,
        "GOAL_SPEED": feetech.GOAL_VELOCITY,
        "LOCK": feetech.LOCK,
        "PRESENT_POSITION": feetech.PRESENT,
    }
    for name, register in names.items():
        low = f"SMS_STS_{name}_L" if register.size == 2 else f"SMS_STS_{name}"
        assert getattr(scservo_sdk, low) == register.address, name
    places = {
        "position": "POSITION_L",
        "velocity": "SPEED_L",
        "temperature": "TEMPERATURE",
        "current": "CURRENT_L",
    }
    for field, name in places.items():
        offset = feetech.MEASURED.fields[field][1]
        assert getattr(scservo_sdk, f"SMS_STS_PRESENT_{name}") == feetech.PRESENT.address + offset


@contextmanager
def by_real_time(kind, sdk):
    """A port at the peer, which shares the clock of the maker's library."""
    with peer(kind, "--mirror", shared=False) as servos:
        port = sdk.PortHandler(servos.address)
        assert port.openPort()
        try:
            yield port
        finally:
            port.closePort()


def asked(ask, tries=20):
    """True as soon as a question is answered: the makers' libraries do not wait long on a busy machine."""
    return any(ask() == 0 for _ in range(tries))


@pytest.mark.clocked
def test_its_makers_library_talks_to_the_dynamixel_peer():
    with by_real_time("dynamixel", dynamixel_sdk) as port:
        maker = dynamixel_sdk.PacketHandler(2.0)
        assert asked(lambda: maker.write1ByteTxRx(port, SERVOS[0], dynamixel_registers.TORQUE.address, 1)[0])
        write = dynamixel_sdk.GroupSyncWrite(port, maker, dynamixel_registers.GOAL.address, 4)
        for one, goal in zip(SERVOS, GOALS, strict=True):
            write.addParam(one, goal.to_bytes(4, "little"))
        assert write.txPacket() == 0
        read = dynamixel_sdk.GroupSyncRead(port, maker, dynamixel_registers.PRESENT.address, 4)
        for one in SERVOS:
            read.addParam(one)
        for ask in (read.txRxPacket, read.fastSyncRead):
            assert asked(ask)
            assert [read.getData(one, dynamixel_registers.PRESENT.address, 4) for one in SERVOS] == GOALS


@pytest.mark.clocked
def test_its_makers_library_talks_to_the_feetech_peer():
    with by_real_time("feetech", scservo_sdk) as port:
        maker = scservo_sdk.sms_sts(port)
        goals = [*GOALS[:-1], -7]
        for one, goal in zip(SERVOS, goals, strict=True):
            assert maker.SyncWritePosEx(one, maker.scs_toscs(goal, 15), 0, 0)
        assert maker.groupSyncWrite.txPacket() == 0
        read = scservo_sdk.GroupSyncRead(maker, feetech.PRESENT.address, feetech.MEASURED.itemsize)
        for one in SERVOS:
            read.addParam(one)
        assert asked(read.txRxPacket)
        found = [maker.scs_tohost(read.getData(one, feetech.PRESENT.address, 2), 15) for one in SERVOS]
        assert found == goals
        assert maker.ReadPos(SERVOS[-1])[0] == -7
