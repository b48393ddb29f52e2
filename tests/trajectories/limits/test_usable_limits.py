from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.robot import Limits
from exidyn.trajectories.errors import BadLimits, Infeasible
from exidyn.trajectories.limits.usable_limits import Margins, require_movable, usable

from ...parts.runs.robots import sliding
from ...parts.small.two_joints import arm

NONE = Margins(*np.zeros(6))


def changed(**limits):
    """The two-joint arm, whose joints are called shoulder and elbow, with other limits."""
    robot = arm()
    return replace(robot, limits=replace(robot.limits, **{k: np.array(v, float) for k, v in limits.items()}))


def test_margins_come_off_every_limit():
    margins = Margins(position=0.1, velocity=0.1, acceleration=0.2, jerk=0.3, torque=0.4)
    robot = changed(velocity_lower=[-1, -2], acceleration_lower=[-4, -5])
    found = usable(robot, margins)
    assert found.assumed == ()
    limits = found.limits
    np.testing.assert_allclose(limits.position_lower, -2.4)
    np.testing.assert_allclose(limits.position_upper, 2.4)
    np.testing.assert_allclose(limits.velocity, 2.7)
    np.testing.assert_allclose(limits.velocity_lower, [-0.9, -1.8])
    np.testing.assert_allclose(limits.acceleration, 9.6)
    np.testing.assert_allclose(limits.acceleration_lower, [-3.2, -4.0])
    np.testing.assert_allclose(limits.jerk, 140.0)
    np.testing.assert_allclose(limits.torque, 120.0)


def test_no_margins_leave_the_limits_as_they_are():
    limits = usable(arm(), NONE).limits
    for name, value in vars(arm().limits).items():
        np.testing.assert_array_equal(getattr(limits, name), value)


def test_by_default_a_little_is_kept_free():
    limits = usable(arm()).limits
    np.testing.assert_allclose(limits.position_upper, 2.45)
    np.testing.assert_allclose(limits.velocity, 0.95 * 3.0)


def test_what_is_not_given_is_assumed_and_reported():
    inf = np.inf
    robot = changed(
        position_lower=[-inf, -2],
        position_upper=[inf, 2],
        acceleration=[12, inf],
        acceleration_lower=[-12, -inf],
        jerk=[inf, inf],
        torque=[inf, 50],
    )
    found = usable(robot, NONE)
    np.testing.assert_allclose(found.limits.position_upper, [np.pi, 2.0])
    np.testing.assert_allclose(found.limits.position_lower, [-np.pi, -2.0])
    np.testing.assert_allclose(found.limits.acceleration, [12.0, 3.0])  # full speed is 3 rad/s
    np.testing.assert_allclose(found.limits.acceleration_lower, [-12.0, -3.0])
    np.testing.assert_allclose(found.limits.jerk, [120.0, 30.0])
    np.testing.assert_allclose(found.limits.torque, [inf, 50.0])
    position, acceleration, jerk = found.assumed
    assert position == "shoulder: no position limit; half a turn each way is assumed"
    assert acceleration == "elbow: no acceleration limit; full speed within 1 s is assumed"
    assert jerk == "shoulder, elbow: no jerk limit; full acceleration within 0.1 s is assumed"


def test_a_window_narrows_the_limits_around_the_start():
    start = np.array([0.5, 2.3])
    limits = usable(arm(), window=np.array([0.2, 0.3]), start=start).limits
    np.testing.assert_allclose(limits.position_lower, [0.3, 2.0])
    np.testing.assert_allclose(limits.position_upper, [0.7, 2.45])
    limits = usable(arm(), window=np.array([[-0.1, 0.2], [-0.3, 0.0]]), start=start).limits
    np.testing.assert_allclose(limits.position_lower, [0.4, 2.0])
    np.testing.assert_allclose(limits.position_upper, [0.7, 2.3])


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
@pytest.mark.parametrize("name", ["velocity", "acceleration", "jerk", "torque"])
def test_a_limit_that_nothing_moves_within_names_joint_value_and_remedy(name, value):
    good = {"velocity_lower": [-3, -3], "acceleration_lower": [-12, -12]}
    with pytest.raises(BadLimits, match=rf"elbow: {name} limit {value:g} .*Try"):
        usable(changed(**good, **{name: [9.0, value]}))


@pytest.mark.parametrize("name", ["velocity", "acceleration"])
@pytest.mark.parametrize("value", [0.0, 1.0, np.nan])
def test_backward_limits_must_be_negative(name, value):
    with pytest.raises(BadLimits, match=rf"elbow: backward {name} limit"):
        usable(changed(**{f"{name}_lower": [-1.0, value]}))


def test_a_velocity_must_be_given():
    with pytest.raises(BadLimits, match="elbow: no velocity limit is given. Try `velocity` under"):
        usable(changed(velocity=[3, np.inf], velocity_lower=[-3, -np.inf]))
    with pytest.raises(BadLimits, match="elbow: no velocity limit is given. Try `velocity_lower` under"):
        usable(changed(velocity_lower=[-3, -np.inf]))


@pytest.mark.parametrize(("lower", "upper"), [(1.0, -1.0), (1.0, 1.0), (np.nan, 1.0), (-1.0, np.nan)])
def test_position_limits_must_have_room(lower, upper):
    with pytest.raises(
        BadLimits, match=rf"elbow: lower position limit {lower:g} is not below the upper, {upper:g}"
    ):
        usable(changed(position_lower=[-1, lower], position_upper=[1, upper]))


def test_margins_must_leave_room():
    with pytest.raises(Infeasible, match=r"elbow: 0\.05 to 0\.04 rad: the margins leave nothing"):
        usable(changed(position_lower=[-1, 0.0], position_upper=[1, 0.09]))


def test_only_a_turning_joint_may_be_endless():
    with pytest.raises(BadLimits, match="elbow: position limits -inf to 1"):
        usable(changed(position_lower=[-1, -np.inf], position_upper=[1, 1]))
    robot = sliding()
    rails = replace(robot, limits=replace(Limits.none(6), velocity=np.ones(6), velocity_lower=-np.ones(6)))
    with pytest.raises(BadLimits, match="joint1: position limits -inf to inf"):
        usable(rails)


def test_a_sliding_joint_has_a_margin_of_its_own_and_metres():
    one = np.ones(6)
    rails = replace(sliding(), limits=Limits(-one, one, one, one, one, one))
    limits = usable(rails, Margins(position=0.1, slide=0.02)).limits
    np.testing.assert_allclose(limits.position_upper, [0.98, 0.98, 0.9, 0.9, 0.9, 0.98])
    with pytest.raises(BadLimits, match="joint1: velocity limit 0 m/s"):
        usable(replace(rails, limits=Limits(-one, one, 0 * one, one, one, one)))


def test_a_start_must_be_inside():
    with pytest.raises(Infeasible, match=r"elbow: start 2\.47 is outside -2\.45 to 2\.45 rad.*margin"):
        usable(arm(), start=np.array([0.0, 2.47]))
    with pytest.raises(Infeasible, match="shoulder: start nan"):
        usable(arm(), start=np.array([np.nan, 0.0]))
    with pytest.raises(BadLimits, match="start pose of shape"):
        usable(arm(), start=np.zeros(3))


@pytest.mark.parametrize(
    ("window", "message"),
    [
        ([0.1, 0.0], "elbow: correction window -?0 to 0 rad"),
        ([0.1, np.nan], "elbow: correction window nan"),
        ([0.1, -0.2], r"elbow: correction window 0\.2 to -0\.2"),
        ([[-1, 1], [0.1, 0.2]], r"elbow: correction window 0\.1 to 0\.2"),
        ([0.1, 0.1, 0.1], "window of shape"),
    ],
)
def test_a_window_must_hold_the_start(window, message):
    with pytest.raises(BadLimits, match=message):
        usable(arm(), window=np.array(window), start=np.zeros(2))


def test_a_window_that_leaves_nothing_names_the_place():
    start, window = np.array([0.0, 2.45]), np.array([[-1, 1], [0.0, 1.0]])
    with pytest.raises(
        Infeasible,
        match="elbow: .*the correction window leaves nothing of the position limits. Try another start",
    ):
        usable(arm(), window=window, start=start)


def test_a_window_needs_a_start():
    with pytest.raises(BadLimits, match="start pose"):
        usable(arm(), window=np.array([0.1, 0.1]))


@pytest.mark.parametrize(
    "options", [{"velocity": 1.0}, {"jerk": -0.1}, {"position": np.nan}, {"slide": np.inf}]
)
def test_margins_must_be_shares(options):
    with pytest.raises(BadLimits, match=f"margins: {next(iter(options))} is"):
        Margins(**options)


def test_limits_have_one_value_a_joint():
    with pytest.raises(BadLimits, match="different shapes"):
        require_movable(replace(Limits.none(2), jerk=np.ones(3)))


def test_without_a_robot_joints_are_counted():
    with pytest.raises(BadLimits, match="joint 2: jerk limit 0 rad/s"):
        require_movable(replace(Limits.none(2), jerk=np.array([1.0, 0.0])))
