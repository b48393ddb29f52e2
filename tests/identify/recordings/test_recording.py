"""What a recording must be, and what is warned in it."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.effects import RigidBody
from exidyn.identification.errors import BadTime, BadUnit, NotFinite, NotRecorded, RecordingError, WrongShape
from exidyn.identification.model import Model
from exidyn.identification.recordings.effort_checks import check_alive
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal
from exidyn.identification.recordings.recording_checks import check, check_recorded
from exidyn.identification.recordings.units import joint_side

TIME = np.arange(1000) * 0.002


def model(limit: float = 3.0, **options) -> Model:
    """Two joints that turn and one that slides."""
    kinematics = pin.Model()
    for place, joint in enumerate((pin.JointModelRZ(), pin.JointModelRY(), pin.JointModelPZ())):
        index = kinematics.addJoint(place, joint, pin.SE3.Identity(), f"joint{place + 1}")
        kinematics.appendBodyToJoint(index, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    far = np.full(3, np.inf)
    limits = Limits(np.full(3, -limit), np.full(3, limit), far, far, far, far)
    return Model(Robot("small", kinematics, limits, **options), (RigidBody(),))


def motion() -> np.ndarray:
    return 0.5 * np.sin(np.outer(TIME, [3.0, 4.0, 5.0]))


def noise(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(len(TIME), 3))


def moved(time):
    """A recording of the usual motion at other times."""
    return recording(time=time, position=0.5 * np.sin(np.outer(time, [3.0, 4.0, 5.0])))


def recording(limit: float = 3.0, time=TIME, host_time=None, **signals) -> Recording:
    values = {"position": motion(), "current": noise()} | signals
    return Recording(
        "run",
        model(limit),
        {name: Signal(time, value) for name, value in values.items()},
        host_time=host_time,
    )


def test_a_good_run_has_no_warnings_and_a_stopped_one_says_so():
    assert check(recording()).warnings == ()
    stopped = replace(recording(), outcome={"stop": "position", "text": "joint1 is at its limit"})
    assert check(stopped).warnings == ("was stopped early, after 2 s: joint1 is at its limit",)
    assert (
        check(replace(stopped, outcome={"stop": "none", "text": "the motion came to its end"})).warnings == ()
    )
    [warning] = check(recording(limit=0.3)).warnings[:1]
    assert "joint1 goes 0.2 rad or m beyond its limits" in warning


def test_signals_have_whole_nanoseconds_and_a_rate():
    signal = Signal(np.array([0.1 + 1e-12, 0.3]), np.zeros((2, 1)))
    assert signal.time[0] == 0.1
    with pytest.raises(ValueError, match="read-only"):
        signal.values[0] = 1.0
    time = TIME[np.arange(len(TIME)) % 4 != 0]
    signal = Signal(time, np.zeros((len(time), 1)))
    assert signal.rate == pytest.approx(0.75 / 0.002, rel=2e-3)
    assert Signal(TIME, np.zeros((len(TIME), 1))).rate == pytest.approx(500.0)
    assert signal[:1].rate == 0.0


@pytest.mark.parametrize(("time", "values"), [(np.zeros(3), np.zeros((2, 1))), (np.zeros(2), np.zeros(2))])
def test_signal_refuses_shapes_that_do_not_fit(time, values):
    with pytest.raises(WrongShape, match=r"expected \(t,\) and \(t, n\)"):
        Signal(time, values)


@pytest.mark.parametrize(
    ("signals", "words"),
    [
        ({"position": motion()[:, :2]}, "has 2 columns, but small has 3 joints: joint1, joint2, joint3"),
        ({"speed": motion()}, "unknown signals speed. Valid: position, velocity"),
        ({"host_time": np.arange(10)}, "host_time has shape"),
    ],
)
def test_what_is_no_recording_is_refused(signals, words):
    with pytest.raises(WrongShape, match=words):
        recording(**signals)
    with pytest.raises(WrongShape, match="needs position and one of current, torque; it has position"):
        Recording("run", model(), {"position": Signal(TIME, motion())})


def test_payload_refuses_unknown_parameters():
    with pytest.raises(RecordingError, match="unknown parameters mass. Valid: XX"):
        KnownPayload("L", (("mass", 175.0),))


def with_a_hole():
    position = motion()
    position[500:503, 1] = np.nan
    return position


@pytest.mark.parametrize(
    ("changed", "error", "words"),
    [
        (
            {"position": with_a_hole()},
            NotFinite,
            r"joint2 is not finite in 3 of 1000 samples, first at 1\.000",
        ),
        ({"time": 1000 * TIME}, BadUnit, "comes every 2 s, .* another unit than seconds"),
        ({"position": motion() + [90.0, 0.0, 0.0]}, BadUnit, "joint1 is at 90.* another unit than rad"),
        ({"position": motion() * [1.0, 1.0, 1000.0]}, BadUnit, "joint3 is at .* m, .* another unit than m"),
        ({"temperature": np.full((1000, 3), 310.0)}, BadUnit, "looks like kelvin: subtract 273.15"),
    ],
    ids=["a hole", "milliseconds", "degrees", "millimetres", "kelvin"],
)
def test_what_cannot_have_been_recorded_is_refused_with_its_place(changed, error, words):
    with pytest.raises(error, match=words):
        check(recording(**changed))


def test_a_joint_that_was_never_measured_may_be_nan_where_it_is_optional():
    temperature = np.full((len(TIME), 3), 40.0)
    temperature[:, 2] = np.nan
    assert check(recording(temperature=temperature)).warnings == ()
    current = noise()
    current[:, 2] = np.nan
    with pytest.raises(NotFinite, match="current of joint3"):
        check(recording(current=current))


def test_silent_samples_are_dropped_with_their_host_time_and_leave_a_gap():
    position = motion()
    position[10:14] = np.nan
    checked = check(recording(position=position, host_time=np.arange(1000)))
    assert len(checked.signals["position"]) == 996
    assert 10 not in checked.host_time
    assert len(checked.signals["current"]) == 1000
    assert checked.warnings[0].startswith("position: 1 gap of more")


@pytest.mark.parametrize("step", [0.0, -0.004])
def test_time_must_increase(step):
    time = TIME.copy()
    time[300] = time[299] + step
    with pytest.raises(BadTime, match="does not increase at 1 of 999 steps, first from 0.598000 s"):
        check(recording(time=time))


def test_gaps_are_counted_once_for_signals_that_share_them():
    time = TIME.copy()
    time[500:] += 0.1
    time[700:] += 0.004
    [warning] = check(moved(time)).warnings
    assert warning.startswith("position, current: 2 gaps")
    assert "median periods of 2.000 ms, the longest 102.000 ms, the first at 0.998 s" in warning
    time = TIME.copy()
    time[500:] += 0.1
    found = moved(time)
    shorter = {**found.signals, "current": found.signals["current"][:-1]}
    [warning] = check(replace(found, signals=shorter)).warnings
    assert warning.startswith("position, current: 1 gap of")
    jitter = np.random.default_rng(0).uniform(-0.0004, 0.0004, len(TIME))
    assert check(moved(TIME + jitter)).warnings == ()


def test_gaps_are_reported_once_of_a_recording_of_which_a_part_was_lost():
    time = TIME.copy()
    time[500:] += 0.1
    time[700:] += 0.1
    whole = check(moved(time)).with_warnings("position: something else")
    part = {name: signal[:600] for name, signal in whole.signals.items()}
    first, second = check(replace(whole, signals=part)).warnings
    assert first == "position: something else"
    assert second.startswith("position, current: 1 gap of")
    assert check(whole).warnings == whole.warnings


def test_a_drive_turns_as_far_and_as_fast_as_its_robot_file_lets_it():
    position = motion()
    position[:, 0] += 30.0
    assert check(recording(limit=np.inf, position=position)).warnings == ()
    position[:, 0] += 60.0
    with pytest.raises(BadUnit, match="another unit than rad"):
        check(recording(limit=np.inf, position=position))
    fast = recording(limit=np.inf, position=60.0 * motion() * [1.0, 0.0, 0.0])
    with pytest.raises(BadUnit, match="at most 20 rad/s is possible.*limits. velocity"):
        check(fast)
    robot = fast.robot
    limits = replace(robot.limits, velocity=np.full(robot.dof, 200.0))
    assert not check(replace(fast, model=replace(fast.model, robot=replace(robot, limits=limits)))).warnings


def with_drives(gain, limit):
    robot = model(3, drive_gain=np.array(gain))
    limits = replace(robot.robot.limits, torque=np.full(3, limit))
    return replace(robot, robot=replace(robot.robot, limits=limits))


def test_currents_in_milliamperes_are_recognised_by_the_torque_they_would_make():
    driven = with_drives([-40.0, 40.0, 40.0], 200.0)
    current = 2.0 * noise() * [1.0, 0.05, 1.0]
    assert not check(replace(recording(current=current), model=driven)).warnings
    with pytest.raises(BadUnit, match=r"joint1: 1\..e\+05 N m .* its limit is 200.*another unit than A"):
        check(replace(recording(current=1e3 * current), model=driven))


def test_a_torque_far_beyond_its_limit_is_recognised_and_a_peak_or_an_unknown_gain_is_not():
    current = 300.0 * noise()
    run = replace(recording(current=current), model=with_drives([2.0] * 3, 2.0))
    torque = {"position": run.signals["position"], "torque": run.signals["current"]}
    with pytest.raises(BadUnit, match="its limit is 2. Is the torque in another unit than N m"):
        check(replace(run, signals=torque))
    check(replace(recording(current=current), model=with_drives([1.0] * 3, 2.0)))  # 1: not known
    peak = noise()
    peak[50:55] = 1e4
    check(replace(recording(current=peak), model=with_drives([2.0] * 3, 2.0)))


def test_what_exidyn_recorded_itself_is_warned_of():
    run = replace(recording(current=1e3 * noise()), model=with_drives([40.0] * 3, 200.0))
    assert any("its limit is 200" in warning for warning in check_recorded(run).warnings)


def test_currents_that_are_clipped_or_constant_give_a_warning():
    current = np.round(3.0 * motion() + 0.05 * noise(), 2)
    current[:, 1] = np.clip(current[:, 1], -1.2, 1.2)
    warnings = check(recording(current=current)).warnings
    assert len(warnings) == 2
    assert all("current: joint2 is at exactly" in warning and "clipped" in warning for warning in warnings)
    current = noise()
    current[:, 2] = 0.25
    assert check(recording(current=current)).warnings == (
        "current: joint3 is constant at 0.25; it was not measured, or the motor was off",
    )


@pytest.mark.parametrize("resolution", [1e-1, 1e-2, 1e-3])
def test_the_crest_of_a_smooth_quantised_current_is_not_clipping(resolution):
    assert check(recording(current=np.round(3.0 * motion() / resolution) * resolution)).warnings == ()


def test_degrees_leave_slides_alone(tmp_path):
    degrees = motion() * [180 / np.pi, 180 / np.pi, 1.0]
    columns = np.column_stack([TIME, degrees, noise(1), degrees])
    header = "t,q1,q2,q3,i1,i2,i3,dq_ref1,dq_ref2,dq_ref3"
    np.savetxt(tmp_path / "run.csv", columns, "%.17g", ",", header=header, comments="")
    [turned] = import_source(tmp_path / "run.csv", model(), degrees=True)
    for signal in ("position", "command_velocity"):
        np.testing.assert_allclose(turned.signals[signal].values, motion(), atol=1e-15)
    assert np.array_equal(turned.signals["current"].values, noise(1))


def test_a_motor_side_keeps_the_power_and_needs_gears():
    coupling = np.array([[1.0, 0.0, 0.0], [0.3, 1.0, 0.0], [0.0, -0.2, 1.0]])
    arm = model(gear_ratio=np.array([100.0, -50.0, 20.0]), coupling=coupling)
    motor = {"position": motion(), "velocity": noise(1), "torque": noise(2)}
    before = Recording("run", arm, {name: Signal(TIME, values) for name, values in motor.items()})
    after = joint_side(before, True).signals
    power = (motor["velocity"] * motor["torque"]).sum(axis=1)
    np.testing.assert_allclose(
        (after["velocity"].values * after["torque"].values).sum(axis=1), power, rtol=1e-9
    )
    turned = after["position"].values @ coupling.T * arm.robot.gear_ratio
    np.testing.assert_allclose(turned, motor["position"], atol=1e-12)
    assert np.array_equal(joint_side(before, ["torque"]).signals["velocity"].values, motor["velocity"])
    with pytest.raises(RecordingError, match=r"gear ratio 1 on every joint; give \[drive\] gear_ratio"):
        joint_side(recording(), ["torque"])
    assert joint_side(recording(), False).signals.keys() == recording().signals.keys()


@pytest.mark.parametrize("value", [0.0, 0.25])
def test_efforts_that_never_change_were_not_measured(value):
    dead = check(recording(current=np.full_like(noise(), value)))
    words = f"no effort was measured: all efforts are {value:g} throughout"
    assert dead.warnings == (f"current: {words}",)
    with pytest.raises(NotRecorded, match=words):
        check_alive(dead)
