"""What must hold of every driver, against its own peer."""

from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
import pytest

from exidyn.drivers import DRIVERS, Arm, Command, DriverError, Sample, StopLevel, create
from exidyn.identify.simulation.plant import typical_plant

from ..parts.controllers import franka_controller, rsi_controller, servo_parts
from ..parts.controllers.can_peers import peer as can_peer
from ..parts.runs.run_parts import MODEL, START
from ..peers.can_arm import canopen_settings, mit_settings
from ..peers.peer_process import Peer
from ..peers.ur_settings import ur_settings

AMPLITUDE = 0.04
"""Of the motion that every arm is commanded [rad]: within the usual window of KUKA's, five degrees."""
COUNT = 300
"""Cycles of it."""
ARM = Arm(
    MODEL.robot.joints,
    np.full(6, -7.0),
    np.full(6, 7.0),
    np.full(6, 3.0),
    lambda: typical_plant(MODEL, START),
)
SEVEN = Arm(tuple(f"joint{k}" for k in range(1, 8)), np.full(7, -7.0), np.full(7, 7.0), np.full(7, 3.0))


def arm(name):
    """Of a driver: as many joints as its controller has."""
    return SEVEN if name == "franka" else ARM


@contextmanager
def mock(folder):
    yield None, {"clock": "real", "cycle": 0.01, "dead_man": 2.0}


@contextmanager
def kuka_rsi(folder):
    path = rsi_controller.config_file(folder)
    settings = {"controller": "127.0.0.1", "config": str(path), "wait": 20.0, "timeout": 500}
    with rsi_controller.running(path, "--timeout", 500) as process:
        yield process, settings


@contextmanager
def ur_rtde(folder):
    with Peer("ur_controller.py", "--robot", "obedient", "--series", "cb3") as process:
        yield process, ur_settings(process.address) | {"cycle": 0.008, "dead_man": 2.0}


@contextmanager
def franka(folder):
    with franka_controller.running() as (process, settings):
        yield process, settings


@contextmanager
def canopen_402(folder):
    with can_peer("can_nodes.py") as process:
        yield process, canopen_settings(process.address) | {"cycle": 0.01}


@contextmanager
def can_mit(folder):
    with can_peer("mit_motors.py", "--cycle", 0.01) as process:
        yield process, mit_settings(process.address) | {"cycle": 0.01}


@contextmanager
def dynamixel(folder):
    with servo_parts.peer("dynamixel") as process:
        yield process, servo_parts.SETTINGS["dynamixel"](process.address) | {"watchdog": 2.0, "cycle": 0.01}


@contextmanager
def feetech(folder):
    with servo_parts.peer("feetech") as process:
        yield process, servo_parts.SETTINGS["feetech"](process.address) | {"cycle": 0.01}


PEERS = {f.__name__: f for f in (mock, kuka_rsi, ur_rtde, franka, canopen_402, can_mit, dynamixel, feetech)}


@dataclass
class Session:
    """One driver from opening to closing.

    Attributes:
        info: Its metadata.
        before: Samples with nothing commanded.
        during: Samples while it was commanded to move, and its commanded positions.
        after: Samples after a quick stop.
    """

    info: object = None
    before: list[Sample] = field(default_factory=list)
    during: list[tuple[Sample, np.ndarray]] = field(default_factory=list)
    after: list[Sample] = field(default_factory=list)

    @property
    def samples(self):
        return [*self.before, *(sample for sample, _ in self.during), *self.after]


def play(driver):
    session = Session(info=driver.open())
    driver.arm_drives()
    while not driver.ready:
        session.before.append(driver.exchange(None))
    session.before += [driver.exchange(None) for _ in range(20)]
    where = np.nanmedian([sample.position for sample in session.before], axis=0)
    count = cycles(session.info)
    for number in range(count):
        phase = 2 * np.pi * number / count
        target = where + 0.5 * AMPLITUDE * (1 - np.cos(phase))
        speed = 0.5 * AMPLITUDE * np.sin(phase) * 2 * np.pi / (count * session.info.cycle)
        session.during += sent(driver, Command(target, np.full(len(where), speed)))
    driver.stop(StopLevel.QUICK)
    session.after = listen(driver, 10)
    return session


def cycles(info):
    """Of the motion: at 1 kHz more, so that it is slow enough for an arm that follows by 0.2 s later."""
    return COUNT if info.cycle > 0.001 else 2000


def sent(driver, command):
    """Samples until a command has gone out, each with its target."""
    samples = []
    while not samples or not (samples[-1].sent or samples[-1].fault or len(samples) > 20):
        samples.append(driver.exchange(command))
    return [(sample, command.position) for sample in samples]


def listen(driver, count):
    """Samples as long as somebody answers."""
    samples = []
    try:
        for _ in range(count):
            samples.append(driver.exchange(None))
    except DriverError:
        pass
    return samples


@pytest.fixture(scope="module", params=DRIVERS)
def session(request, tmp_path_factory):
    with PEERS[request.param](tmp_path_factory.mktemp(request.param)) as (_, settings):
        with create(request.param, settings, arm(request.param)) as driver:
            found = play(driver)
        driver.close()
    return found


def test_every_driver_has_its_peer_here():
    assert set(PEERS) == set(DRIVERS)


def test_it_reports_what_the_recording_needs_to_know(session):
    info = session.info
    assert 0.0005 < info.cycle < 0.1
    assert info.clock in ("host", "controller")
    assert "position" in info.signals
    assert {"current", "torque"} & set(info.signals)
    assert all(isinstance(text, str) for pair in info.settings.items() for text in pair)


def test_what_it_claims_to_measure_it_measures_and_nothing_else(session):
    for name in ("position", "velocity", "current", "torque", "temperature"):
        values = np.array([getattr(sample, name) for sample in session.samples])
        assert values.shape[1:] == session.samples[0].stale.shape
        assert np.isfinite(values).any() == (name in session.info.signals), name


def test_nothing_moves_before_a_command(session):
    positions = np.array([sample.position for sample in session.before])
    assert np.nanmax(np.abs(positions - np.nanmedian(positions, axis=0))) < 0.005


def test_the_arm_goes_where_it_is_commanded(session):
    fresh = [(sample.position, target) for sample, target in session.during if not sample.stale.any()]
    reached, commanded = (np.array(column) for column in zip(*fresh, strict=True))
    assert len(fresh) > 0.8 * cycles(session.info)
    assert np.all(np.ptp(reached, axis=0) > 0.8 * AMPLITUDE)
    assert np.all(np.abs(reached[-1] - commanded[-1]) < 0.01)


def test_times_never_go_back(session):
    received = [sample for sample in session.samples if not sample.stale.all()]
    assert all(np.diff([sample.host_time for sample in session.samples]) > 0)
    assert all(np.diff([sample.controller_time for sample in session.samples]) >= 0)
    assert all(np.diff([sample.controller_time for sample in received]) > 0)


def test_controller_time_goes_by_in_cycles(session):
    samples = session.samples[: len(session.before) + len(session.during)]
    gone = (samples[-1].controller_time - samples[0].controller_time) * 1e-9
    cycles = len(samples) - 1 + sum(sample.skipped for sample in samples[1:])
    assert cycles * session.info.cycle > 0.9 * gone
    # What is silent may stand still: then host's cycles go by, and no controller's.
    silent = sum(1 + sample.skipped for sample in samples if np.all(sample.stale))
    assert (cycles - silent) * session.info.cycle < 1.1 * gone


def test_a_silent_joint_gives_no_number(session):
    for sample in session.samples:
        assert sample.stale.shape == session.during[0][1].shape
        assert np.array_equal(np.isnan(sample.position), sample.stale)


@pytest.mark.parametrize("name", [name for name in DRIVERS if name != "mock"])
def test_a_peer_that_dies_raises_nothing_but_our_errors(name, tmp_path):
    with PEERS[name](tmp_path) as (process, settings), create(name, settings, arm(name)) as driver:
        driver.open()
        driver.arm_drives()
        where = listen(driver, 20)[-1].position
        process.process.kill()
        process.process.wait()
        last = None
        try:
            for _ in range(1500):
                last = driver.exchange(Command(where, np.zeros(len(where))))
                if last.fault or last.stale.all():
                    break
        except DriverError:
            last = None
        assert last is None or last.fault or last.stale.all()
        driver.stop(StopLevel.QUICK)
        driver.stop(StopLevel.OFF)


@pytest.mark.parametrize("name", [name for name in DRIVERS if name != "mock"])
def test_without_its_peer_it_reports_it_and_lets_go(name, tmp_path):
    with PEERS[name](tmp_path) as (process, settings):
        process.process.kill()
        process.process.wait()
        patient = {"wait": 0.2} if name in ("kuka_rsi", "ur_rtde") else {}
        driver = create(name, settings | patient, arm(name))
        with pytest.raises(DriverError):
            driver.open()
        driver.close()
