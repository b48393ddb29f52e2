import numpy as np
import pytest

from exidyn.drivers import DriverError, StopLevel
from exidyn.drivers.errors import LinkLost
from exidyn.drivers.mock.faults import FAULTS, read_faults

from ...parts.controllers.mock_parts import moving, opened, play

FAULTY = moving(300)


def spoiled(faults):
    return play(opened(faults=faults)[0], FAULTY)


def stale(samples):
    return np.array([sample.stale for sample in samples])


@pytest.mark.parametrize("name", ["drop", "duplicate", "reorder"])
def test_a_reply_that_is_lost_or_late_is_not_taken_for_a_fresh_one(name):
    samples = spoiled(f"{name} at 0.2 for 0.1")
    silent = stale(samples)
    assert np.flatnonzero(silent.all(axis=1)).tolist() == list(range(100, 150))
    assert np.isnan(samples[120].position).all()
    assert bool(samples[120].events) == (name != "drop")
    assert np.isfinite(samples[150].position).all()


def test_a_fault_of_a_moment_comes_once():
    assert np.flatnonzero(stale(spoiled("drop at 0.3"))[:, 0]).tolist() == [150]


def test_a_delay_makes_replies_late():
    samples = spoiled("delay 0.0005 s at 0.1 for 0.1")
    late = np.array([sample.lateness for sample in samples])
    np.testing.assert_allclose(late[50:100], 5e-4)
    assert not late[:50].any()
    assert not any(sample.skipped for sample in samples)


def test_one_joint_can_be_silent_from_the_start():
    samples = spoiled("stale elbow at start")
    assert stale(samples).all(axis=0).tolist() == [False, True]
    assert np.isfinite(samples[5].position[0])
    assert np.isnan(samples[5].position[1])


def test_a_drive_that_trips_brakes_and_reports_it_from_then_on():
    samples = spoiled("fault elbow at 0.3")
    assert [bool(sample.fault) for sample in samples] == [k >= 150 for k in range(300)]
    assert "joint 2" in samples[-1].fault
    assert np.abs(samples[-1].velocity).max() < 0.01


def test_an_arm_that_stands_elsewhere_really_does():
    near, far = (play(opened(faults=faults)[0], [None] * 50) for faults in ("", "far start elbow 0.2"))
    away = far[-1].position - near[-1].position
    np.testing.assert_allclose(away, [0.0, 0.2], atol=2e-3)
    assert np.abs(far[-1].current - near[-1].current).max() > 0.05


def test_what_is_measured_wrongly():
    clean = spoiled("")
    spike = spoiled("current spike elbow 55 A at 0.2")
    assert spike[100].current[1] == 55.0
    assert spike[101].current[1] == clean[101].current[1]
    jump = spoiled("jump 0.3 rad elbow at 0.2")
    np.testing.assert_allclose(
        [s.position[1] - c.position[1] for s, c in zip(jump, clean, strict=True)][100:], 0.3
    )
    broken = spoiled("nan at 0.2")[100]
    assert np.isnan(broken.position).all()
    assert not broken.stale.any()
    assert spoiled("hot elbow 99 at 0.1")[-1].temperature.tolist() == pytest.approx([25.0, 99.0], abs=1.0)


def test_a_stuck_joint_stays_behind():
    samples = spoiled("stuck elbow at 0.3")
    way = samples[-1].position - samples[160].position
    assert way[0] > 0.04
    assert abs(way[1]) < 0.005


def test_a_controller_that_falls_silent_is_a_lost_link():
    driver, _ = opened(faults="silent at 0.1")
    play(driver, FAULTY[:50])
    with pytest.raises(LinkLost, match="does not answer"):
        driver.exchange(FAULTY[50])
    driver.stop(StopLevel.QUICK)


def test_several_faults_at_once():
    samples = spoiled("drop at 0.1; current spike elbow 9 at 0.2;")
    assert np.isnan(samples[50].position).all()
    assert samples[100].current[1] == 9.0


@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_can_be_asked_for(name):
    fault = read_faults(f"{name} elbow 0.05 at 0.1 for 0.2", ("shoulder", "elbow"))[0]
    assert (fault.joint, fault.amount, fault.begin, fault.length) == (1, 0.05, 0.1, 0.2)
    driver, info = opened(faults=f"{name} elbow 0.05 at 0.1 for 0.02")
    assert name in info.warnings[0]
    try:
        samples = play(driver, FAULTY[:80])
        assert all(sample.position.shape == (2,) for sample in samples)
    except DriverError:
        assert name == "silent"
