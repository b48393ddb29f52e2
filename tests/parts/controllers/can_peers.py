"""A driver on CAN and its peer in another process, for tests."""

from contextlib import contextmanager, nullcontext
from unittest.mock import patch

import numpy as np

from exidyn.drivers import Arm, Command, create
from exidyn.drivers.can import can_driver

from ...peers.can_arm import ObedientArm, canopen_settings, mit_settings
from ...peers.peer_process import Peer
from ..system_needs import MULTICAST, TERMINALS

SLOW = 0.01
"""Cycle of these tests [s]: busy machines keep to it."""

ARM = Arm(ObedientArm.joints, np.full(6, -3.0), np.full(6, 3.0), np.full(6, 3.0))


ANSWERING = 50.0
"""Cycles for which drivers of these tests wait for answers: 0.5 s, as long as busy machines stall [-]."""
SILENCE = 10.0
"""Silence on the bus after which a link counts as lost in these tests [s]."""


@contextmanager
def late_answers_count():
    """Makes drivers wait for every answer, so that no joint is stale because the peer's process had to wait.

    Answers of an idle machine come as fast as ever; then nothing changes.
    """
    with patch.object(can_driver, "PATIENCE", ANSWERING), patch.object(can_driver, "SILENCE", SILENCE):
        yield


@contextmanager
def peer(script, *arguments):
    """A peer's process, at a serial adapter or on a multicast group.

    A cycle of its arm passes with each question, however late that comes: by the clock, an arm whose host had
    to wait ran ahead of its targets, and its drives reported a following error.
    """
    (TERMINALS if "--adapter" in arguments else MULTICAST).require()
    with Peer(script, "--robot", "obedient", "--lockstep", *arguments) as process:
        yield process


@contextmanager
def drives(*arguments, hasty=False, **settings):
    """CiA 402 drives, and their driver, not open yet; a hasty driver does not wait for silent drives."""
    waiting = nullcontext() if hasty else late_answers_count()
    with waiting, peer("can_nodes.py", *arguments) as process:
        table = {**canopen_settings(process.address), "cycle": SLOW, **settings}
        with create("canopen_402", table, ARM) as driver:
            yield process, driver


@contextmanager
def motors(*arguments, maker="damiao", hasty=False, **settings):
    """Motors with the MIT frame, and their driver, not open yet."""
    waiting = nullcontext() if hasty else late_answers_count()
    with waiting, peer("mit_motors.py", "--maker", maker, "--cycle", SLOW, *arguments) as process:
        table = {**mit_settings(process.address, maker=maker), "cycle": SLOW, **settings}
        with create("can_mit", table, ARM) as driver:
            yield process, driver


def standing(driver):
    """Where the joints stand: what a few samples agree on; more where a busy machine is late for those."""
    seen = [driver.exchange(None).position for _ in range(5)]
    while np.isnan(seen).all(axis=0).any() and len(seen) < 200:
        seen.append(driver.exchange(None).position)
    return np.nanmedian(seen, axis=0)


def armed(driver):
    """Open and arm, and wait for the position at which the arm stands."""
    driver.open()
    driver.arm_drives()
    return standing(driver)


def command(position, velocity=0.0):
    return Command(np.array(position, float), np.full(len(position), float(velocity)))


def follow(driver, where, cycles=100):
    """Samples of a calm motion away from a position and back; ends early with a fault."""
    samples = []
    for k in range(cycles):
        phase = 2.0 * np.pi * k / cycles
        samples.append(driver.exchange(command(where + 0.05 * (1.0 - np.cos(phase)))))
        if samples[-1].fault:
            break
    return samples


def until_fault(driver, where, cycles=2000):
    """The first sample with a fault, while commanded to stay."""
    for _ in range(cycles):
        sample = driver.exchange(command(where))
        if sample.fault:
            return sample
    raise AssertionError("no fault")
