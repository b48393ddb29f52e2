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


def test_margins_come_off_every_limit_and_without_them_it_stays():
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
    unchanged = usable(arm(), NONE).limits
    for name, value in vars(arm().limits).items():
        np.testing.assert_array_equal(getattr(unchanged, name), value)


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


@pytest.mark.parametrize(
    ("limits", "error", "message"),
    [
        ({"velocity": [9.0, 0.0]}, BadLimits, "velocity limit 0 .*Try"),
        ({"acceleration": [9.0, -1.0]}, BadLimits, "acceleration limit -1 .*Try"),
        ({"jerk": [9.0, np.nan]}, BadLimits, "jerk limit nan .*Try"),
        ({"torque": [9.0, 0.0]}, BadLimits, "torque limit 0 .*Try"),
        ({"velocity_lower": [-1.0, 0.0]}, BadLimits, "backward velocity limit"),
        ({"acceleration_lower": [-1.0, np.nan]}, BadLimits, "backward acceleration limit"),
        ({"velocity": [3, np.inf]}, BadLimits, "no velocity limit is given. Try `velocity` under"),
        ({"velocity_lower": [-3, -np.inf]}, BadLimits, "no velocity limit .* Try `velocity_lower` under"),
        ({"position_lower": [-1, 3.0]}, BadLimits, r"lower position limit 3 is not below the upper, 2\.5"),
        ({"position_upper": [1, np.nan]}, BadLimits, "lower position limit -2.5 is not below the upper"),
        ({"position_lower": [-1, -np.inf]}, BadLimits, "position limits -inf to 2.5"),
        (
            {"position_lower": [-1, 0.0], "position_upper": [1, 0.09]},
            Infeasible,
            r"0\.05 to 0\.04 rad: the margins leave nothing",
        ),
    ],
)
def test_a_limit_that_nothing_moves_within_names_joint_value_and_remedy(limits, error, message):
    with pytest.raises(error, match=f"elbow: {message}"):
        usable(changed(**limits))


def test_a_sliding_joint_has_a_margin_and_metres_and_is_never_endless():
    one = np.ones(6)
    rails = replace(sliding(), limits=Limits(-one, one, one, one, one, one))
    limits = usable(rails, Margins(position=0.1, slide=0.02)).limits
    np.testing.assert_allclose(limits.position_upper, [0.98, 0.98, 0.9, 0.9, 0.9, 0.98])
    with pytest.raises(BadLimits, match="joint1: velocity limit 0 m/s"):
        usable(replace(rails, limits=Limits(-one, one, 0 * one, one, one, one)))
    with pytest.raises(BadLimits, match="joint1: position limits -inf to inf"):
        usable(replace(rails, limits=replace(Limits.none(6), velocity=one, velocity_lower=-one)))


@pytest.mark.parametrize(
    ("start", "window", "error", "message"),
    [
        ([0.0, 2.47], None, Infeasible, r"elbow: start 2\.47 is outside -2\.45 to 2\.45 rad.*margin"),
        ([np.nan, 0.0], None, Infeasible, "shoulder: start nan"),
        ([0.0] * 3, None, BadLimits, "start pose of shape"),
        ([0.0, 0.0], [0.1, np.nan], BadLimits, "elbow: correction window nan"),
        ([0.0, 0.0], [0.1, -0.2], BadLimits, r"elbow: correction window 0\.2 to -0\.2"),
        ([0.0, 0.0], [[-1, 1], [0.1, 0.2]], BadLimits, r"elbow: correction window 0\.1 to 0\.2"),
        ([0.0, 0.0], [0.1, 0.1, 0.1], BadLimits, "window of shape"),
        (None, [0.1, 0.1], BadLimits, "start pose"),
        ([0.0, 2.45], [[-1, 1], [0.0, 1.0]], Infeasible, "elbow: .*correction window leaves nothing of the"),
    ],
)
def test_a_start_must_be_inside_and_a_window_hold_it(start, window, error, message):
    arrays = [None if value is None else np.array(value) for value in (window, start)]
    with pytest.raises(error, match=message):
        usable(arm(), None, *arrays)


@pytest.mark.parametrize(
    "options", [{"velocity": 1.0}, {"jerk": -0.1}, {"position": np.nan}, {"slide": np.inf}]
)
def test_margins_must_be_shares(options):
    with pytest.raises(BadLimits, match=f"margins: {next(iter(options))} is"):
        Margins(**options)


def test_without_a_robot_joints_are_counted():
    with pytest.raises(BadLimits, match="joint 2: jerk limit 0 rad/s"):
        require_movable(replace(Limits.none(2), jerk=np.array([1.0, 0.0])))
    with pytest.raises(BadLimits, match="different shapes"):
        require_movable(replace(Limits.none(2), jerk=np.ones(3)))
