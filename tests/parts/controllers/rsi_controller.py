"""A KUKA controller whose every telegram a test sends by hand, and one that runs as a process."""

import json
import re
import socket
import threading
from contextlib import contextmanager

import numpy as np

from exidyn.drivers import Arm, Command, Driver, create
from exidyn.drivers.kuka_rsi.config import config_text, standard_config

from ...peers.peer_process import Peer

START = (10.0, -90.0, 90.0, 5.0, 45.0, -20.0)


def arm(joints=6):
    limit = np.full(joints, 3.0)
    return Arm(tuple(f"axis{k + 1}" for k in range(joints)), -limit, limit, limit)


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def config_file(folder, **changes):
    """A configuration on a free port."""
    path = folder / "RSI_EthernetConfig.xml"
    path.write_text(config_text(standard_config("127.0.0.1", free_port(), **changes)))
    return path


def driver(path, joints=6, **settings):
    """A driver; without a probe, so that every answer is a test's own."""
    given = {"controller": "127.0.0.1", "config": str(path), "wait": 20.0, "timeout": 500, "probe": False}
    given |= settings
    return create("kuka_rsi", given, arm(joints))


def element(name, values):
    return f"<{name} " + " ".join(f'A{k + 1}="{v:.4f}"' for k, v in enumerate(values)) + "/>"


def telegram(stamp, position=START, programmed=START, current=(0.0,) * 6, delay=0, more=""):
    body = element("AIPos", position) + element("ASPos", programmed) + element("MACur", current)
    return f'<Rob Type="KUKA">{body}{more}<Delay D="{delay}"/><IPOC>{stamp}</IPOC></Rob>'.encode()


def command(degrees):
    return Command(np.radians(degrees), np.zeros(len(degrees)))


def correction(text):
    """What an answer corrects [deg]."""
    inside = text.split("<AK ")[1].split("/>")[0]
    return np.array([float(part.split('"')[1]) for part in inside.split()])


class ByHand:
    """Sends what a test gives, and reads what is answered."""

    def __init__(self, path, stamp=4208163634, cycle=4):
        self.to = ("127.0.0.1", int(re.search(r"<PORT>(\d+)", path.read_text())[1]))
        self.stamp, self.cycle = stamp, cycle
        self.socket = self.another()

    def another(self, address="127.0.0.1"):
        """A socket on another port, or another address of the loopback."""
        one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        one.bind((address, 0))
        one.settimeout(5.0)
        return one

    def send(self, cycles=1, **content):
        """The next telegram, or one some cycles on; its stamp."""
        self.stamp += cycles * self.cycle
        self.raw(telegram(self.stamp, **content))
        return self.stamp

    def raw(self, data):
        self.socket.sendto(data, self.to)

    def answer(self):
        Driver.clock.readable([self.socket], 5.0)
        return self.socket.recv(65535).decode()

    def nothing(self):
        """Whether no answer is waiting."""
        self.socket.setblocking(False)
        try:
            self.socket.recv(65535)
        except BlockingIOError:
            return True
        finally:
            self.socket.settimeout(5.0)
        return False

    def opened(self, one, **content):
        """Open a driver, sending until it is; its text, with all answers read and no exchange made."""
        done, clock = [], Driver.clock

        def go_on():
            while not done:
                clock.sleep(0.004)
                self.send(**content)

        sender = threading.Thread(target=go_on)
        clock.start(sender)
        try:
            return one.open()
        finally:
            done.append(True)
            clock.join(sender)

    def begun(self, one, **content):
        """Open a driver and make the first exchange, so that answers come from exchanges only."""
        info = self.opened(one, **content)
        self.send(**content)
        taken = one._taken_over()  # whatever the keeper has not taken is waiting now
        while not self.nothing():
            pass
        self.send(**content)
        sample = one.exchange(None)
        while f"<IPOC>{self.stamp}<" not in self.answer():
            pass
        assert taken.silent or not taken.quiet > 10.0
        return info, sample

    def close(self):
        self.socket.close()


@contextmanager
def by_hand(path, **given):
    one = ByHand(path, **given)
    try:
        yield one
    finally:
        one.close()


def running(path, *options):
    """The controller of `peers/krc.py`, as a process; a context manager that ends it."""
    return Peer("krc.py", "--config", path, *options)


def counted(peer):
    """End a running one; what it counted."""
    peer.close()
    return json.loads(peer.lines[-1])
