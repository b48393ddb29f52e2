"""The dashboard server may be silent, flood, or never end a line: nothing of a run waits for it."""

import socket
import threading

import pytest

from exidyn.drivers import StopLevel, create
from exidyn.drivers.ur_rtde import dashboard
from exidyn.drivers.ur_rtde.dashboard import LONGEST, Dashboard

from ...parts.controllers.can_peers import ARM
from ...peers.peer_process import Peer
from ...peers.ur_settings import ur_settings

GREETING = b"Connected: Universal Robots Dashboard Server\n"


class Server:
    """Greets, and then sends what it is told to; reads nothing."""

    def __init__(self):
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = self._server.getsockname()[1]
        self._accepting = threading.Thread(target=self._accept, daemon=True)
        self._accepting.start()

    def _accept(self):
        self.link = self._server.accept()[0]
        self.link.sendall(GREETING)

    def send(self, data):
        self._accepting.join()
        self.link.sendall(data)

    def close(self):
        self._accepting.join()
        self.link.close()
        self._server.close()


@pytest.fixture
def server():
    made = Server()
    yield made
    made.close()


def until(call):
    """What a call gives once that is something; TCP takes its time."""
    while not (found := call()):
        pass
    return found


def test_an_answer_to_a_question_is_waited_for(server):
    link = Dashboard("127.0.0.1", server.port, 5.0)
    server.send(b"true\n")
    assert link.ask("is in remote control") == "true"
    link.close()


def test_a_silent_server_is_waited_for_no_longer_than_patience(server):
    link = Dashboard("127.0.0.1", server.port, 0.05)
    assert link.there
    assert link.ask("is in remote control") == ""
    link.close()


def test_a_request_is_answered_later_and_meanwhile_nothing_waits(server):
    link = Dashboard("127.0.0.1", server.port, 5.0)
    assert link.request("power off") == ""
    assert link.answers() == []
    server.send(b"Powering off\n")
    assert until(link.answers) == ["the controller's dashboard to 'power off': Powering off"]
    assert link.answers() == []
    link.close()


def test_a_request_without_an_answer_is_reported_once(server, monkeypatch):
    monkeypatch.setattr(dashboard, "ANSWERED", 0.0)
    link = Dashboard("127.0.0.1", server.port, 5.0)
    link.request("power off")
    assert link.answers() == ["the controller's dashboard to 'power off': no answer in 0 s"]
    assert link.answers() == []
    link.close()


def test_bytes_without_a_line_end_the_connection_and_nothing_else(server):
    link = Dashboard("127.0.0.1", server.port, 5.0)
    link.request("power off")
    server.send(b"x" * 3 * LONGEST)
    while link.there:
        assert link.answers() == []
    assert link.request("power off") == "the controller's dashboard does not take 'power off'"


def test_without_a_server_there_is_none():
    with socket.create_server(("127.0.0.1", 0)) as closed:
        port = closed.getsockname()[1]
    link = Dashboard("127.0.0.1", port, 0.5)
    assert not link.there
    assert link.ask("anything") == ""
    assert link.answers() == []


@pytest.mark.parametrize("behaviour", ["silent", "flood", "babble"])
def test_a_run_goes_on_while_the_dashboard_misbehaves(behaviour):
    with Peer("ur_controller.py", "--robot", "obedient", "--series", "cb3") as peer:
        settings = ur_settings(peer.address) | {"cycle": 0.008}
        with create("ur_rtde", settings, ARM) as driver:
            driver.open()
            driver.arm_drives()
            driver.exchange(None)
            peer.tell(f"dashboard {behaviour}")
            driver.exchange(None)
            driver.stop(StopLevel.OFF)
            samples = [driver.exchange(None) for _ in range(20)]
    assert sum(sample.skipped for sample in samples) < 20  # an answer that was waited for would take hundreds
    assert not all(sample.stale.all() for sample in samples)
