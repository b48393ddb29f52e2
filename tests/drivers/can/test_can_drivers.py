"""What the drivers on CAN have in common, against drives and motors in another process on a real bus."""

import can
import numpy as np
import pytest

from exidyn.drivers import create
from exidyn.drivers.errors import BadSettings, LinkLost

from ...parts.controllers.can_peers import ARM, armed, drives, follow, motors, until_fault
from ...peers.can_arm import canopen_settings, mit_settings, multicast


@pytest.mark.parametrize(
    ("arm", "fault", "words"),
    [
        (drives, "silent:3", "joint3 (node 3): its heartbeat is lost"),
        (drives, "quiet:3", "joint3 (node 3): its heartbeat is lost"),
        (
            drives,
            "emergency:2",
            "joint2 (node 2): emergency 0x4310 (motor too hot), error register 0x11, 0x0102030405",
        ),
        (drives, "fault:4", "joint4 (node 4): emergency 0x3210 (DC link over-voltage)"),
        (drives, "restart:5", "joint5 (node 5): is starting up on the network"),
        (motors, "error:4", "joint4 (motor 4): error 10 (over-current)"),
    ],
)
def test_what_goes_wrong_in_a_drive_is_a_fault_that_names_it(arm, fault, words):
    more = {"heartbeat": 0.2} if arm is drives else {}
    with arm("--fault", f"{fault}@10", hasty=True, **more) as (_, driver):
        sample = until_fault(driver, armed(driver))
        assert sample.fault.startswith(words)
        assert any(words in text for text in sample.events)
        assert driver.exchange(None).fault == sample.fault


@pytest.mark.parametrize(("arm", "fault"), [(drives, "mute"), (motors, "silent")])
def test_a_silent_joint_is_stale_and_not_a_number(arm, fault):
    with arm("--fault", f"{fault}:3@10", hasty=True) as (peer, driver):
        samples = follow(driver, armed(driver), 60)
        peer.wait_for(f"now {fault}")
        samples += [driver.exchange(None) for _ in range(5)]
        last = samples[-1]
        assert last.stale[2]
        assert np.isnan([last.position[2], last.current[2], last.torque[2], last.temperature[2]]).all()
        assert not last.fault
        assert any(np.isfinite(np.delete(sample.position, 2)).any() for sample in samples[-5:])


@pytest.mark.parametrize(
    ("arm", "number", "data", "content"),
    [(drives, 0x080, b"", "SYNC"), (motors, 3, b"\xff" * 7 + b"\xfd", "commands to joint3 (motor 3)")],
)
def test_another_program_that_commands_is_recognized(arm, number, data, content):
    with arm() as (peer, driver):
        where = armed(driver)
        with multicast(int(peer.address)) as other:
            other.send(can.Message(arbitration_id=number, data=data, is_extended_id=False))
            sample = until_fault(driver, where)
        assert f"another program sends {content}" in sample.fault


@pytest.mark.parametrize(
    ("arm", "settings", "message"),
    [
        (drives, {"nodes": [1, 2, 3, 4, 5, 77]}, r"joint6 \(node 77\) does not answer"),
        (
            motors,
            {"ids": [1, 2, 3, 4, 5, 15], "masters": [17, 18, 19, 20, 21, 31]},
            r"joint6 \(motor 15\) does not answer on identifier 0x01F",
        ),
    ],
)
def test_a_drive_that_is_not_there_is_named(arm, settings, message):
    with arm(**settings) as (_, driver), pytest.raises(LinkLost, match=message):
        driver.open()


CANOPEN, MIT = ("canopen_402", canopen_settings("43113")), ("can_mit", mit_settings("43113"))
SLOWER = ("canopen_402", canopen_settings("43113") | {"bitrate": 800_000})


@pytest.mark.parametrize(
    ("valid", "change", "words"),
    [
        (CANOPEN, {"interface": "carrier-pigeon"}, ["carrier-pigeon", "socketcan", "slcan"]),
        (CANOPEN, {"nodes": [1, 2, 3, 3, 5, 6]}, ["node number 3", "twice"]),
        (CANOPEN, {"nodes": [1, 2, 3, 4, 5, 127]}, ["nodes[5]", "127", "1 to 126"]),
        (CANOPEN, {"sign": [1, 1, 0, 1, 1, 1]}, ["sign[2] is 0", "Valid: 1, -1"]),
        (CANOPEN, {"cycle": 0.00215789}, ["0.00215789", "0x60C2"]),
        (CANOPEN, {"gear": 1e5}, ["joint1", "counts", "gear"]),
        (CANOPEN, {"options": "port 1"}, ["'port 1'", "name=value"]),
        (CANOPEN, {"bitrate": 500_000}, ["13 frames", "500 kbit/s", "cycle = 0.004"]),
        (CANOPEN, {"quick": 1}, ["unknown setting 'quick'", "quick_stop"]),
        (SLOWER, {"current_object": "0x6078"}, ["'0x6078'", "index:sub type", "int16", "float32"]),
        (SLOWER, {"current_object": "0x6078:0 word"}, ["'0x6078:0 word'", "int16"]),
        (SLOWER, {"current_object": "0x1018:1 uint32"}, ["0x2000", "0x9FFF"]),
        (SLOWER, {"current_object": ["0x6078:0 int16"] * 5}, ["current_object", "5 entries", "6 joints"]),
        (
            SLOWER,
            {"current_scale": 0.001, "rated_current": 4.0},
            ["joint1", "current_scale", "rated_current"],
        ),
        (SLOWER, {"current_object": "0x30D1:2 int32", "cycle": 0.002}, ["19 frames", "cycle"]),
        (MIT, {"ids": [1, 2, 3, 3, 5, 6]}, ["3 and 3", "distinguished"]),
        (MIT, {"ids": [1, 2, 3, 17, 5, 6], "masters": 0}, ["1 and 17", "last hexadecimal digit"]),
        (MIT, {"model": "DM9999"}, ["DM9999", "DM4310", "AK80-9"]),
        (MIT, {"model": "T-Motor", "position_range": 0.0}, ["position_range", "AK80-9"]),
        (MIT, {"current_range": 10.0}, ["current_range", "T-Motor"]),
        (MIT, {"kp": 600.0}, ["kp", "600", "500"]),
        (MIT, {"sign": [1, 1, 0, 1, 1, 1]}, ["sign[2] is 0", "Valid: 1, -1"]),
        (MIT, {"velocity_range": 2.0}, ["joint1", "velocity limit is 3", "2"]),
        (MIT, {"zero": 10.0}, ["joint1", "position limits are up to 13 rad", "12.5"]),
        (MIT, {"cycle": 0.001}, ["12 frames", "1000 Hz", "cycle = 0.002"]),
    ],
)
def test_settings_that_cannot_be_are_refused(valid, change, words):
    name, settings = valid
    with pytest.raises(BadSettings) as caught:
        create(name, settings | change, ARM)
    assert all(word in str(caught.value) for word in words), caught.value
