"""What must hold of every driver, against its own peer."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from exidyn.drivers import DRIVERS, Arm, Command, DriverError, Sample, StopLevel, create
from exidyn.identification.simulation.plant import typical_plant

from ..parts.runs.run_parts import MODEL, START
from ..peers.driver_peers import REAL, peer_of

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
    return SEVEN if peer_of(name).joints == 7 else ARM


@dataclass
class Session:
    """One driver from opening to closing."""

    info: object = None  # its metadata
    before: list[Sample] = field(default_factory=list)  # samples with nothing commanded
    # samples while it was commanded to move, and its commanded positions
    during: list[tuple[Sample, np.ndarray]] = field(default_factory=list)
    after: list[Sample] = field(default_factory=list)  # samples after a quick stop

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
    with peer_of(request.param).running(tmp_path_factory.mktemp(request.param)) as (_, settings):
        with create(request.param, settings, arm(request.param)) as driver:
            found = play(driver)
        driver.close()
    return found


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
    assert np.any(np.all(np.abs(commanded[-len(fresh) // 5 :] - reached[-1]) < 0.01, axis=1))  # late if busy


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


@pytest.mark.parametrize("name", REAL)
def test_a_peer_that_dies_raises_nothing_but_our_errors(name, tmp_path):
    with peer_of(name).running(tmp_path) as (process, settings), create(name, settings, arm(name)) as driver:
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


@pytest.mark.parametrize("name", REAL)
def test_without_its_peer_it_reports_it_and_lets_go(name, tmp_path):
    with peer_of(name).running(tmp_path) as (process, settings):
        process.process.kill()
        process.process.wait()
        driver = create(name, settings | peer_of(name).hasty, arm(name))
        with pytest.raises(DriverError):
            driver.open()
        driver.close()
