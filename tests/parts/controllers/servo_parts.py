"""Servo drivers against their peers, which run as processes."""

import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from exidyn.drivers import Arm, Command, create

from ...peers.peer_process import Peer
from ..system_needs import TERMINALS

sys.path.append(str(Path(__file__).parents[2] / "peers"))
import servo_units  # noqa: E402 - the peers' own, which are programs

SETTINGS = {"dynamixel": servo_units.dynamixel_settings, "feetech": servo_units.feetech_settings}
HELD = {"dynamixel": (("--torque", 1), ("set 9 1 0",)), "feetech": ((), ())}
"""Command line with which each peer holds its arm, and what makes its registers as from the factory."""
JOINTS = 6
TURN = 2.0 * np.pi / 4096


def arm(joints=JOINTS):
    limit = np.full(joints, 7.0)
    return Arm(tuple(f"joint{k + 1}" for k in range(joints)), -limit, limit, limit)


def peer(kind, *arguments, **options):
    TERMINALS.require()
    return Peer(f"{kind}_bus.py", *arguments, **options)


@contextmanager
def running(kind, folder, *arguments, **settings):
    """The peer, and settings that reach it."""
    with peer(kind, *arguments) as process:
        yield process, SETTINGS[kind](process.address) | {"cycle": 0.01} | settings


def is_off(process, samples, torque, goal):
    """Whether registers of torque and of goals are zero, by the servos' own account."""

    def shown(address, size):
        send_only(process, f"show {address} {size}")
        return next(line for line in reversed(process.lines) if line.startswith("shows"))[6:].strip()

    return shown(torque, 1) == str([0] * JOINTS) and str([0] * JOINTS) in shown(goal, 2)


def driver(kind, peer, **settings):
    """Not open yet; a bus watchdog is so slow that a busy machine does not trip it."""
    patient = {"watchdog": 2.0} if kind == "dynamixel" else {}
    return create(kind, SETTINGS[kind](peer.address) | patient | settings, arm())


def counting(kind, peer, **settings):
    """A driver whose positions are counts of the servos."""
    return driver(kind, peer, **{"gear": 1.0, "sign": 1, "zero": 0, "cycle": 0.004} | settings)


def armed(driver):
    """The driver, opened and armed."""
    driver.open()
    driver.arm_drives()
    return driver


def send_only(peer, line):
    """Have something happen, and wait until it has."""
    count = peer.lines.count(f"did {line}\n")
    peer.tell(line)
    assert peer.wait_until(lambda: peer.lines.count(f"did {line}\n") > count)


def still(driver):
    """Where the arm is once it has stopped moving."""
    last = fresh(driver)
    for _ in range(100):
        for _ in range(20):
            now = fresh(driver)
        if np.all(np.abs(now.position - last.position) < 5e-4):
            return now.position
        last = now
    raise AssertionError("the arm does not stop")


def servo(number):
    """Id of the servo of a joint."""
    return servo_units.ids(JOINTS)[number]


def hold(position):
    return Command(np.asarray(position), np.zeros(len(position)))


def fresh(driver, command=None, cycles=200):
    """The next sample of which no joint is stale."""
    for _ in range(cycles):
        sample = driver.exchange(command)
        if not sample.stale.any():
            return sample
    raise AssertionError("the joints stay silent")


def until(driver, condition, command=None, cycles=1000):
    """The next sample of which something is true, and all events on the way."""
    events = []
    for _ in range(cycles):
        sample = driver.exchange(command)
        events += sample.events
        if condition(sample):
            return sample, events
    raise AssertionError(f"it never happened; events: {events}")
