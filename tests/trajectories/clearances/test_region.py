import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.errors import RobotError
from exidyn.identification.robot_files.toml_fields import parse_toml
from exidyn.trajectories.clearances.clearance import RESOLUTION, clear_position, random_positions
from exidyn.trajectories.clearances.collision import Collision
from exidyn.trajectories.clearances.region import HalfSpace, Region, box, read_regions
from exidyn.trajectories.errors import BadLimits, Infeasible

from ...parts.plans.clearance_checks import bound_is_proved, differences
from ...parts.plans.sine_motion import SineMotion, sine_motion
from ...parts.runs.robots import sliding
from ...parts.small import two_joints
from ...parts.small.small_arm import small_arm

EVERYWHERE = np.full(3, np.inf)
WALLS = [
    *box(np.array([-1.0, -np.inf, 0.1]), np.array([0.7, 2.0, np.inf])),
    HalfSpace.of(np.array([1.0, 2.0, -2.0]), 0.5),
]


def region(robot, walls=WALLS, radius=0.03):
    return Region.of(robot, "flange", walls, [0.1, -0.05, 0.2], radius)


def test_margins_are_distances_to_the_walls():
    robot = sliding()
    position = random_positions(robot, 8)
    margins, data = region(robot).margins(position), robot.kinematics.createData()
    for row, one in enumerate(position):
        pin.forwardKinematics(robot.kinematics, data, one)
        x, y, z = (data.oMi[robot.dof] * robot.flange).act(np.array([0.1, -0.05, 0.2]))
        slant = 0.5 - (x + 2 * y - 2 * z) / 3
        expected = np.array([x + 1.0, 0.7 - x, 2.0 - y, z - 0.1, slant]) - 0.03
        np.testing.assert_allclose(margins[row], expected, atol=1e-12)


@pytest.mark.parametrize("point", ["flange", "slide", "tool", "mast"])
def test_points_are_of_their_frames_and_gradients_meet_finite_differences(tmp_path, point):
    """The tool is fixed at an angle on what slides."""
    robot, _ = small_arm(tmp_path)
    kept = Region.of(robot, point, WALLS, [0.1, -0.05, 0.2])
    position, data = random_positions(robot, 20), robot.kinematics.createData()
    margin, gradient = kept.gradient(position)
    np.testing.assert_allclose(margin, kept.margins(position), atol=1e-12)
    np.testing.assert_allclose(gradient, differences(kept.margins, position), atol=1e-8)
    reach = kept.reach(np.max(np.abs(position), axis=0))
    assert np.all(np.abs(gradient) <= reach + 1e-12)
    if point == "tool":
        pin.framesForwardKinematics(robot.kinematics, data, position[0])
        expected = data.oMf[robot.kinematics.getFrameId("tool")].act(np.array([0.1, -0.05, 0.2]))
        np.testing.assert_allclose(kept.points(position[:1])[0], expected, atol=1e-12)


def test_a_point_of_the_base_stays(tmp_path):
    robot, _ = small_arm(tmp_path)
    kept = Region.of(robot, "base", WALLS)
    position = random_positions(robot, 3)
    assert np.all(kept.gradient(position)[1] == 0)
    np.testing.assert_allclose(kept.margins(position), np.tile([1.0, 0.7, 2.0, 0.4, 0.5 + 1 / 3], (3, 1)))


@pytest.mark.parametrize("seed", range(4))
def test_nothing_on_a_trajectory_is_nearer_than_proved(seed):
    bound_is_proved(region(sliding()), sine_motion(sliding(), seed))


@pytest.mark.parametrize(("phase", "peak"), [(0.0, 0.075), (np.pi / 2, 0.05)])
def test_a_wall_crossed_between_samples_is_found(phase, peak):
    """The arm swings at 10 Hz, so that every tenth of a second shows it in one place, or at rest there."""
    robot = two_joints.arm()
    kept = Region.of(robot, "flange", [HalfSpace.of(np.array([0.0, 0.0, 1.0]), 0.3)])
    swing = SineMotion(np.zeros(2), np.array([0.8, 0.0]), np.full(2, 20 * np.pi), np.full(2, phase), 1.0)
    assert np.min(kept.margins(swing.every(0.1).position)) > 0.29
    found = kept.worst(swing)
    # 0.7 m of arm, 0.8 rad up
    assert found.margin == pytest.approx(0.3 - 0.7 * np.sin(0.8), abs=RESOLUTION)
    assert found.time % 0.1 == pytest.approx(peak, abs=2e-3)
    assert not found.allowed


def test_a_position_that_is_clear_of_all(tmp_path):
    robot, geometry = small_arm(tmp_path)
    kept = Region.of(robot, "tool", box(np.array([-1.0, 0.1, 0.3]), np.array([1.0, 0.6, 1.0])), radius=0.05)
    collision = Collision.of(robot, geometry)
    position = clear_position(robot, [kept, collision])
    assert np.min(kept.margins(position[None])) >= 0
    assert np.min(collision.margins(position[None])) >= 0
    bounded = np.isfinite(robot.limits.position_upper)
    assert np.all((np.abs(position) <= 3.0)[bounded])


def test_a_region_of_a_centimetre_is_found(tmp_path):
    """Random positions hit it once in about a million; the gradient leads in."""
    robot, _ = small_arm(tmp_path)
    corner = np.array([0.5, 0.3, 0.8])
    kept = Region.of(robot, "tool", box(corner, corner + 0.012))
    assert np.max(np.min(kept.margins(random_positions(robot, 2000)), axis=1)) < 0
    assert np.min(kept.margins(clear_position(robot, [kept])[None])) >= 0


def test_a_region_out_of_reach_is_named_with_the_nearest_miss():
    robot = two_joints.arm()  # its flange is at most 0.7 m from the shoulder
    kept = Region.of(robot, "flange", box(np.array([0.9, -np.inf, -np.inf]), EVERYWHERE))
    with pytest.raises(Infeasible, match=r"two joints: .*flange x >= 0.9 m by 0.2\d* m") as caught:
        clear_position(robot, [kept])
    assert "shoulder" in str(caught.value)
    assert "elbow" in str(caught.value)


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (
            lambda: Region.of(two_joints.arm(), "flange", [], radius=0.0),
            BadLimits,
            "expected at least one wall",
        ),
        (lambda: Region.of(two_joints.arm(), "flange", WALLS, radius=np.nan), BadLimits, "expected at least"),
        (
            lambda: Region.of(two_joints.arm(), "hand", WALLS),
            RobotError,
            "no point 'hand'. Valid: flange, shoulder",
        ),
        (
            lambda: box(np.zeros(3), np.array([1.0, -1.0, 1.0])),
            BadLimits,
            "lower y = 0 m is not below upper -1 m",
        ),
        (lambda: HalfSpace.of(np.zeros(3), 1.0), BadLimits, "half-space"),
        (lambda: HalfSpace.of(np.array([0.0, 0.0, 1.0]), np.inf), BadLimits, "half-space"),
        (lambda: read_regions({"lower": 1}, two_joints.arm()), RobotError, "expected rows headed"),
    ],
)
def test_what_makes_no_region_is_refused(make, error, message):
    with pytest.raises(error, match=message):
        make()


TOML = """
[[region]]
point = "elbow"
offset = [0, 0, 0.1]
radius = 0.05
lower = [-inf, -1, 0.2]
upper = [inf, 1, inf]
half_space = [{ normal = [0, 3, 4], offset = 0.8 }]

[[region]]
upper = [1, 1, 1]
"""


def test_regions_are_read_from_toml():
    robot = two_joints.arm()
    elbow, flange = read_regions(parse_toml(TOML, "test")["region"], robot)
    assert elbow.names == [
        "elbow y >= -1 m",
        "elbow y <= 1 m",
        "elbow z >= 0.2 m",
        "elbow wall [0.0, 3.0, 4.0] <= 0.8 m",
    ]
    # at zero the elbow is at x = 0.4 and the point 0.1 above it
    expected = np.array([1.0, 1.0, -0.1, 0.8 - 0.08]) - 0.05
    np.testing.assert_allclose(elbow.margins(np.zeros((1, 2)))[0], expected, atol=1e-12)
    assert flange.point == "flange"
    np.testing.assert_allclose(flange.margins(np.zeros((1, 2)))[0], [0.3, 1.0, 1.0])


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({"lowr": [0, 0, 0]}, "region 1: unknown key 'lowr'. Valid keys: half_space, lower"),
        ({"upper": [1, 1, float("nan")]}, "expected a number; found nan"),
        ({"half_space": [{"normal": 1, "offset": 1, "at": 2}]}, "unknown key 'at'"),
        ({"radius": -1, "upper": [1, 1, 1]}, "radius: -1 is less than 0"),
    ],
)
def test_a_wrong_row_is_named(row, message):
    with pytest.raises(RobotError, match=message.replace("[", r"\[")):
        read_regions([row], two_joints.arm())
