"""Exports: what is read back from their text is the trajectory's own."""

import re
from dataclasses import replace

import numpy as np
import pytest
from ruamel.yaml import YAML

from exidyn.identification.arm.robot import Limits
from exidyn.trajectories.errors import BadLimits
from exidyn.trajectories.plans.exports import EXPORTS, KRL_AXES, csv_text, krl_text, ros_text

from ...parts.plans.plans import SAMPLES, fourier, known_plan, phases
from ...parts.small.hostile_names import HALVES, NAMES


@pytest.fixture
def plan():
    return known_plan()


def at_rest(plan):
    """A motion that starts and ends standing still."""
    return replace(plan, trajectory=phases().hold(np.array([0.3, -0.2]), 1.5))


def test_csv_holds_every_tick_to_the_last_bit(plan):
    head, *rows = csv_text(plan).splitlines()
    assert head == "t,q1,q2,v1,v2,a1,a2"
    states = plan.trajectory.every(plan.tick)
    found = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    expected = np.column_stack([states.time, states.position, states.velocity, states.acceleration])
    assert np.array_equal(found, expected)
    rows = csv_text(plan, 10.0).splitlines()[1:]
    assert len(rows) == 1 + np.floor(10.0 * plan.trajectory.duration)


def message(text):
    """The message as ROS reads it: YAML 1.1, in which 1e-5 without a point is a text."""
    yaml = YAML(typ="safe", pure=True)
    yaml.version = (1, 1)
    return yaml.load(text)


@pytest.mark.parametrize(("family", "rate"), [(family, 7.0) for family in SAMPLES] + [("phases", None)])
def test_ros_message_has_the_shape_of_a_joint_trajectory(plan, family, rate):
    plan = replace(plan, trajectory=SAMPLES[family](), joints=("yes", "it's: 2"))
    read = message(ros_text(plan, rate))
    assert set(read) == {"header", "joint_names", "points"}
    assert read["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    assert read["joint_names"] == ["yes", "it's: 2"]
    keys = {"positions", "velocities", "accelerations", "time_from_start"}
    assert all(set(point) == keys for point in read["points"])
    stamps = [point["time_from_start"] for point in read["points"]]
    assert all(0 <= stamp["nanosec"] < 10**9 and stamp["sec"] >= 0 for stamp in stamps)
    time = np.array([stamp["sec"] + 1e-9 * stamp["nanosec"] for stamp in stamps])
    assert np.all(np.diff(time) > 0)
    assert time[-1] == pytest.approx(plan.trajectory.duration, abs=1e-9)
    np.testing.assert_allclose(np.diff(time)[:-1], 1.0 / (rate or 50.0), atol=2e-9)
    states = plan.trajectory.at(np.minimum(time, plan.trajectory.duration))
    for key, expected in zip(("positions", "velocities", "accelerations"), states[1:4], strict=True):
        found = np.array([point[key] for point in read["points"]])
        assert found.dtype == float
        np.testing.assert_allclose(found, expected, atol=1e-7)  # rounded to nine digits, and to nanoseconds


def test_ros_names_the_place_the_motion_is_not_at_rest(plan):
    assert "# It starts in motion" in ros_text(plan)
    assert "# It ends in motion" in ros_text(plan)
    assert "in motion" not in ros_text(at_rest(plan))
    for export in EXPORTS.values():
        assert "-0.0" not in export(at_rest(plan), None).replace("-0.2", "")


def krl_points(text):
    """Positions of all PTP lines."""
    lines = re.findall(r"^PTP \{(.*?)\}( C_PTP)?$", text, flags=re.M)
    return [dict((pair.split()[0], float(pair.split()[1])) for pair in line.split(", ")) for line, _ in lines]


def krl_speeds(text):
    """Per cent at which each point is approached, the first left out."""
    speeds, now = [], None
    for line in text.splitlines():
        if line.startswith("BAS(#VEL_PTP"):
            now = int(re.fullmatch(r"BAS\(#VEL_PTP, (\d+)\)", line).group(1))
        elif line.startswith("PTP"):
            speeds.append(now)
    assert speeds[0] == 10
    return np.array(speeds[1:])


def test_krl_points_are_the_positions_in_degrees(plan):
    text = krl_text(plan, 5.0)
    points = krl_points(text)
    time = np.append(np.arange(len(points) - 1) / 5.0, plan.trajectory.duration)
    expected = np.degrees(plan.trajectory.at(time).position)
    found = np.array([[point["A1"], point["A2"]] for point in points])
    np.testing.assert_allclose(found, expected, atol=0.6e-4)
    assert text.splitlines()[1] == "DEF exidyn_two_joints( )"
    assert text.rstrip().endswith("}\nEND")
    assert "times these points itself: this is no identification motion" in text
    assert max(map(len, text.splitlines())) <= 110


def test_krl_speeds_are_the_fastest_joints_share(plan):
    speeds = krl_speeds(krl_text(plan, 5.0))
    for k, speed in enumerate(speeds):
        until = min((k + 1) / 5.0, plan.trajectory.duration)
        velocity = plan.trajectory.at(np.linspace(k / 5.0, until, 500)).velocity
        # sampled elsewhere, and rounded up to whole per cent
        assert -0.01 <= speed - 100.0 * np.max(np.abs(velocity) / plan.limits.velocity) <= 1.01
    assert len(set(speeds)) > 3


def test_krl_of_a_sliding_joint_is_in_millimetres(plan):
    points = krl_points(krl_text(replace(plan, units=("m", "rad"))))
    start = plan.trajectory.at(np.zeros(1)).position[0]
    assert points[0]["A1"] == pytest.approx(1000.0 * start[0], abs=1e-4)
    assert points[0]["A2"] == pytest.approx(np.degrees(start[1]), abs=1e-4)


def test_krl_refuses_what_it_cannot_express(plan):
    with pytest.raises(BadLimits, match="shoulder has no velocity limit"):
        krl_text(replace(plan, limits=Limits.none(2)))
    n = len(KRL_AXES) + 1
    many = replace(fourier(), centre=np.zeros(n), sine=np.zeros((n, 1)), cosine=np.zeros((n, 1)))
    names = tuple(f"j{i}" for i in range(n))
    with pytest.raises(BadLimits, match="13 joints"):
        krl_text(replace(plan, trajectory=many, joints=names, units=("rad",) * n, limits=Limits.none(n)))


def test_a_motion_of_one_sample_has_a_start_and_an_end(plan):
    short = replace(plan, trajectory=phases().hold(np.zeros(2), 0.01))
    assert len(krl_points(krl_text(short))) == 2
    assert len(message(ros_text(short))["points"]) == 2


@pytest.mark.parametrize("name", [*NAMES, *HALVES])
def test_hostile_names_stay_inside_their_comment_or_text(plan, name):
    plan = replace(plan, trajectory=phases())
    plain = name.replace("\ud800", "").replace("\udcff", "")
    named = replace(plan, robot=name, joints=(f"{plain}0", f"{plain}1"))
    lines, harmless = krl_text(named).splitlines(), krl_text(plan).splitlines()
    assert len(lines) == len(harmless)
    commands = [line for line in lines if not line.startswith((";", "&COMMENT", "DEF "))]
    assert commands == [line for line in harmless if not line.startswith((";", "&COMMENT", "DEF "))]
    assert re.fullmatch(r"DEF exidyn_\w*\( \)", lines[1], re.ASCII)
    assert message(ros_text(named))["joint_names"] == list(named.joints)
    assert csv_text(named) == csv_text(plan)
