"""The peer of driver ur_rtde and a client that is not ours: Universal Robots' own, which is not on PyPI."""

import numpy as np
import pytest

from exidyn.drivers.ur_rtde.program import Registers, UrSettings, program_sent, program_text

from ...peers.peer_process import Peer
from ...peers.ur_settings import ur_settings

pytestmark = pytest.mark.clocked

CLIENT = "https://github.com/UniversalRobots/RTDE_Python_Client_Library"
CB3 = ("--robot", "obedient", "--series", "cb3")
STOOD = [0.0, -1.0, 1.0, 0.0, 0.5, 0.0]
NAMES = ["timestamp", "actual_q", "actual_current", "joint_temperatures", "robot_mode", "safety_mode"]
TYPES = ["DOUBLE", "VECTOR6D", "VECTOR6D", "VECTOR6D", "INT32", "INT32"]


@pytest.fixture(scope="module")
def peer():
    with Peer("ur_controller.py", *CB3, shared=False) as process:
        yield process


@pytest.fixture
def maker(peer):
    """Universal Robots' own client, connected."""
    rtde = pytest.importorskip("rtde.rtde", reason=f"not installed; pip install git+{CLIENT}")
    given = ur_settings(peer.address)
    client = rtde.RTDE(given["address"], given["rtde_port"])
    client.connect()
    yield client
    client.disconnect()


def test_the_makers_client_reads_the_peer(maker):
    assert maker.get_controller_version() == (3, 15, 8, 106339)
    assert maker.send_output_setup(NAMES, TYPES, frequency=125)
    assert maker.send_start()
    states = [maker.receive() for _ in range(20)]
    assert np.allclose([state.actual_q for state in states], STOOD, atol=2e-3)
    assert all(np.diff([state.timestamp for state in states]) > 0.0)
    assert (states[-1].robot_mode, states[-1].safety_mode) == (7, 1)
    assert maker.send_pause()
    with pytest.raises(ValueError, match="NOT_FOUND"):
        maker.send_output_setup(["no_such_name"])


def test_the_makers_client_moves_the_peer_by_the_drivers_program(maker, peer):
    """What the driver writes and the program reads are the registers that the maker's client means too."""
    registers, settings = Registers(24), UrSettings(address="", cycle=0.008, dead_man=2.0)
    assert maker.send_output_setup(["actual_q", registers.session, registers.ended], frequency=125)
    inputs = maker.send_input_setup(registers.inputs, ["DOUBLE"] * 6 + ["INT32"] * 2)
    assert maker.send_start()
    given = ur_settings(peer.address)
    state = maker.receive()

    def send(target, count, demand):
        for name, value in zip(registers.inputs, [*target, count, demand], strict=True):
            setattr(inputs, name, value)
        assert maker.send(inputs)

    send(state.actual_q, 1, 1)
    with program_sent(given["address"], given["program_port"], program_text(settings, 77), 5.0):
        peer.wait_for("program started")
    for count in range(2, 150):
        state = maker.receive()
        send([0.02 * min(count / 100, 1.0), *STOOD[1:]], count, 1)
    assert vars(state)[registers.session] == 77
    assert state.actual_q[0] == pytest.approx(0.02, abs=2e-3)
    send(state.actual_q, 150, 2)
    peer.wait_for("program ended: to its end")
    assert vars(maker.receive())[registers.ended] == 1
