"""The observer: known forces in MuJoCo, inverse dynamics, gaps, and pieces instead of whole runs."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import signal

from exidyn.identification.contact.contact import contact, observed
from exidyn.identification.contact.observer import AHEAD, Observer
from exidyn.identification.effects import TemperatureDependentFriction
from exidyn.identification.errors import DifferentRobot, FitError, NotRecorded, RecordingError, WrongShape
from exidyn.identification.fit.identification import identify
from exidyn.identification.payload.weigh import weigh
from exidyn.identification.recordings.recording import KnownPayload

from ...parts.small import small_fit
from ...parts.small.two_joint_files import of_another_arm, run

arm = pytest.importorskip("parts.contact.touched_arm")

FORCE = (6.0, -4.0, 10.0)
TOUCH = arm.Touch(FORCE, 8.0, 11.0)


@cache
def fit():
    return identify([arm.run("train", 1)])


@cache
def free():
    return [arm.run("free 1", 2), arm.run("free 2", 3)]


@cache
def touched():
    return contact(fit(), arm.run("touched", 4, 14.0, [TOUCH]), free())


def samples(run, count):
    """Time, positions and torques of the first samples of a run."""
    signals = run.signals
    parts = signals["position"].time, signals["position"].values, signals["torque"].values
    return tuple(part[:count].copy() for part in parts)


def settled(time, start, end):
    """Samples between 0.3 s (ten time constants) after the start of a touch and its end."""
    return (time > start + 0.3) & (time < end)


def test_a_known_force_is_estimated_in_motion():
    result = touched()
    inside = settled(result.estimates.time, TOUCH.start, TOUCH.end)
    expected = arm.push_torque(result.estimates.position[inside], FORCE)
    error = result.estimates.torque[inside] - expected
    size = np.sqrt(np.mean(expected**2, axis=0))
    assert np.all(np.abs(error.mean(axis=0)) < 0.03 * size.max())
    assert np.all(error.std(axis=0) < 0.2)
    np.testing.assert_allclose(result.wrench[inside, :3].mean(axis=0), FORCE, atol=0.3)
    outside = result.estimates.time < TOUCH.start
    assert np.nanstd(result.wrench[outside, :3]) < 0.3


def test_one_contact_is_found_at_its_time_and_none_without():
    [alarm] = touched().alarms
    assert TOUCH.start < alarm.start < TOUCH.start + 0.1
    assert TOUCH.end <= alarm.end < TOUCH.end + 0.3
    np.testing.assert_allclose(alarm.wrench(fit().model.robot)[:3], FORCE, atol=1.5)
    assert contact(fit(), arm.run("other", 5, 14.0), free()).alarms == ()


def test_at_rest_the_residual_is_that_of_inverse_dynamics():
    """In the quasi-static limit the external torque is what the motors make less than gravity needs."""
    held = arm.run("held", 6, 6.0, [arm.Touch(FORCE, 0.0, 6.0)], speed=0.0)
    estimates = observed(fit(), held)
    last = slice(-1000, None)
    q = held.signals["position"].values[last]
    direct = fit().torque(q, 0.0 * q, 0.0 * q) - held.signals["torque"].values[last]
    np.testing.assert_allclose(estimates.torque[last].mean(axis=0), direct.mean(axis=0), atol=0.01)
    np.testing.assert_allclose(direct.mean(axis=0), arm.push_torque(q[:1], FORCE)[0], atol=0.05)


def test_in_motion_it_is_the_residual_of_inverse_dynamics_behind_the_same_poles():
    run = arm.run("touched", 4, 14.0, [TOUCH])
    time, q, tau = run.signals["position"].time, run.signals["position"].values, run.signals["torque"].values
    poles = [AHEAD * 5.0, AHEAD * 5.0]
    smooth = q.copy()
    for pole in poles:
        smooth, tau = (_first_order(values, pole) for values in (smooth, tau))
    dq = np.gradient(smooth, arm.STEP, axis=0)
    ddq = np.gradient(dq, arm.STEP, axis=0)
    direct = _first_order(fit().torque(smooth, dq, ddq) - tau, 5.0)
    torque = observed(fit(), run).torque
    inside = (time > 1.0) & (time < 13.9)
    assert np.abs((torque - direct)[inside]).max() < 0.05 * np.abs(direct[inside]).max()


def _first_order(values, pole):
    """Low-pass of one pole [Hz], started at the first row."""
    share = 1.0 - np.exp(-2 * np.pi * pole * arm.STEP)
    start = (1.0 - share) * values[:1]
    return signal.lfilter([share], [1.0, share - 1.0], values, axis=0, zi=start)[0]


def test_pieces_and_single_samples_give_what_the_whole_run_gives():
    run = free()[0]
    rows = samples(run, 400)
    whole = Observer(fit()).add(*rows)
    pieces, steps = Observer(fit()), Observer(fit())
    parts = [
        pieces.add(*(row[a:b] for row in rows)).torque for a, b in ((0, 7), (7, 7), (7, 390), (390, 400))
    ]
    np.testing.assert_array_equal(np.concatenate(parts), whole.torque)
    single = [steps.step(*row) for row in zip(*rows, strict=True)]
    np.testing.assert_array_equal(single, whole.torque)
    assert np.isfinite(whole.torque).all(axis=1).sum() > 200


def test_missing_samples_are_skipped_and_gaps_start_again():
    time, q, tau = samples(free()[0], 600)
    whole = Observer(fit()).add(time, q, tau)
    tau[300] = np.nan
    skipped = Observer(fit()).add(time, q, tau)
    assert np.isnan(skipped.torque[300]).all()
    np.testing.assert_allclose(skipped.torque[-1], whole.torque[-1], atol=0.1)
    late = time + np.where(np.arange(600) >= 400, 1.0, 0.0)
    again = Observer(fit()).add(late, q, tau)
    assert np.isnan(again.torque[400:450]).all()
    assert np.isfinite(again.torque[-1]).all()
    backward = Observer(fit()).add(np.r_[time[:10], time[:10]], q[:20], tau[:20])
    assert np.isnan(backward.velocity[10:]).all()


def test_bad_input_is_refused():
    with pytest.raises(FitError, match="no payload 'X'. Payloads of the fit: none"):
        Observer(fit(), "X")
    with pytest.raises(FitError, match="bandwidth of the observer is 0 Hz; it must be above 0"):
        Observer(fit(), bandwidth=0.0)
    with pytest.raises(WrongShape, match=r"observer: effort has shape \(1, 2\), expected \(1, 3\)"):
        Observer(fit()).step(0.0, np.zeros(3), np.zeros(2))
    with pytest.raises(RecordingError, match="bandwidth of 2000 Hz needs more than"):
        contact(fit(), free()[0], [], bandwidth=2000.0)
    with pytest.raises(RecordingError, match="train was used for the fit"):
        contact(fit(), free()[0], [arm.run("train", 1)])
    signals = {"position": free()[0].signals["position"], "current": free()[0].signals["torque"]}
    currents = replace(free()[0], signals=signals)
    with pytest.raises(RecordingError, match="the run has a current, and the runs of the fit have a torque"):
        observed(fit(), currents)
    warm = fit()
    model = replace(warm.model, effects=(*warm.model.effects, TemperatureDependentFriction()))
    with pytest.raises(NotRecorded, match="friction of the fit depends on temperature, which is not given"):
        Observer(replace(warm, model=model)).step(0.0, np.zeros(3), np.zeros(3))


def test_a_recording_of_another_arm_or_payload_is_refused():
    # Joints have the same names; name and geometry differ. Either alone may differ for one arm.
    longer = of_another_arm(run("new", 5, 6))
    other = replace(longer, model=replace(longer.model, robot=replace(longer.robot, name="long arm")))
    renamed = replace(longer.robot, name="long arm", kinematics=small_fit.fit().model.robot.kinematics)
    observed(small_fit.fit(), longer)
    observed(small_fit.fit(), replace(longer, model=replace(longer.model, robot=renamed)))
    for judge in (observed, lambda fit, recording: weigh([recording], fit=fit)):
        with pytest.raises(
            DifferentRobot, match="new was recorded on long arm, and the fit is of two joints"
        ):
            judge(small_fit.fit(), other)
    carrying = run("new", 5, 6, KnownPayload("L"))
    with pytest.raises(FitError, match="new was recorded with payload L.*--payload none"):
        observed(small_fit.plain_fit(), carrying)
    assert np.isfinite(observed(small_fit.plain_fit(), carrying, "").torque).any()


def test_currents_are_converted_by_the_gains_of_the_fit():
    currents = small_fit.fit()
    observer = Observer(currents)
    q = np.array([0.4, -0.3])
    torque = currents.torque(q, 0.0 * q, 0.0 * q)
    push = np.array([2.0, -1.0])
    for k in range(400):
        external = observer.step(0.002 * k, q, (torque - push) / currents.estimate.gain)
    np.testing.assert_allclose(external, push, atol=1e-6)
