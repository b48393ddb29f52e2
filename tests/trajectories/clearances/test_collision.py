import pickle
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.errors import BrokenTree, RobotError
from exidyn.identification.robot_files.geometry import hull, read_geometry
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.clearances.clearance import RESOLUTION, Clearance, nearest, random_positions
from exidyn.trajectories.clearances.collision import Collision

from ...parts.plans.clearance_checks import bound_is_proved, differences
from ...parts.plans.sine_motion import SineMotion, sine_motion
from ...parts.small import small_arm as arm


@pytest.fixture
def small(tmp_path):
    robot, geometry = arm.small_arm(tmp_path)
    return robot, Collision.of(robot, geometry)


def test_bodies_are_where_pinocchio_puts_them(tmp_path):
    path = arm.write(tmp_path)
    model, ours = read_model(path).robot.kinematics, read_geometry(path)
    theirs = pin.buildGeomFromUrdf(model, str(path), pin.GeometryType.COLLISION)
    mine = {body.name: body for body in ours.geometryObjects}
    assert len(theirs.geometryObjects) == 6  # its parser knows no capsules
    for other in theirs.geometryObjects:
        body = mine[other.name]
        assert (body.parentJoint, body.parentFrame) == (other.parentJoint, other.parentFrame)
        assert body.placement.isApprox(other.placement, 1e-12)
        assert type(body.geometry) is type(other.geometry)


def test_bodies_beyond_a_held_joint_belong_to_the_joint_before_it(tmp_path):
    path = arm.write(tmp_path)
    joints = read_model(path).robot.joints[:-1]
    (tmp_path / "robot.toml").write_text(f'urdf = "{path.name}"\njoints = {list(joints)}')
    held = {body.name: body for body in read_geometry(tmp_path / "robot.toml").geometryObjects}
    whole = {body.name: body for body in read_geometry(path).geometryObjects}
    assert held.keys() == whole.keys()
    assert max(body.parentJoint for body in held.values()) == len(joints)
    assert max(body.parentJoint for body in whole.values()) == len(joints) + 1


def test_distance_of_two_balls_is_that_of_their_centres_less_their_radii(small):
    robot, collision = small
    column = collision.names.index("tool_0 to mast_0")
    balls = {body.name: body for body in collision.geometry.geometryObjects}
    data = robot.kinematics.createData()
    for position in random_positions(robot, 20, seed=4):
        pin.forwardKinematics(robot.kinematics, data, position)
        one, other = (
            (data.oMi[balls[name].parentJoint] * balls[name].placement).translation
            for name in ("tool_0", "mast_0")
        )
        expected = np.linalg.norm(one - other) - 0.15
        assert collision.distances(position[None])[0, column] == pytest.approx(expected, abs=1e-9)


def test_gradient_meets_finite_differences_apart_and_overlapping(small):
    robot, collision = small
    position = random_positions(robot, 400, seed=1)
    distance, gradient = collision.distances_and_gradient(position)
    error = np.max(np.abs(gradient - differences(collision.distances, position)), axis=2)
    apart, overlapping = error[distance > 0], error[distance < -1e-3]
    assert len(overlapping) > 50
    # a cylinder has a rim and a box edges, on which a distance has no gradient
    assert np.quantile(apart, 0.99) < 1e-4
    assert np.quantile(overlapping, 0.95) < 1e-4


def test_margins_are_distances_less_the_required_one_and_some_are_those_asked_for(small):
    robot, collision = small
    position = random_positions(robot, 5)
    every, (margin, gradient) = collision.margins(position), collision.gradient(position)
    np.testing.assert_allclose(margin, collision.distances(position) - 0.02, atol=1e-9)
    np.testing.assert_allclose(margin, every, atol=1e-9)
    assert gradient.shape == (5, len(collision.names), robot.dof)
    wanted = np.random.default_rng(0).uniform(size=(5, len(collision.names))) < 0.5
    some = collision.some_margins(position, wanted)
    np.testing.assert_allclose(some[wanted], every[wanted], atol=1e-9)
    assert np.all(np.isinf(some[~wanted]))


def test_no_distance_changes_faster_than_the_reach(small):
    robot, collision = small
    position = random_positions(robot, 1000, seed=2)
    reach = collision.reach(np.max(np.abs(position), axis=0))
    gradient = np.abs(collision.distances_and_gradient(position)[1])
    assert np.all(gradient <= reach + 1e-9)
    # and it is not just any large number
    assert np.median(reach[reach > 0] / np.max(gradient, axis=0)[reach > 0]) < 2.0


def test_joints_that_move_neither_body_or_both_do_not_count(small):
    robot, collision = small
    mast, pan = robot.joints.index("mast_turn"), robot.joints.index("pan")
    row = collision.names.index("shoulder_0 to fore_0")
    gradient = collision.gradient(random_positions(robot, 10))[1][:, row]
    assert np.all(gradient[:, [mast, pan]] == 0)
    assert np.all(collision.reach(np.ones(robot.dof))[row, [mast, pan]] == 0)


def test_adjacent_and_ignored_links_are_excluded_and_listed(tmp_path):
    robot, geometry = arm.small_arm(tmp_path)
    collision = Collision.of(robot, geometry, ignored=[("mast", "tool")])
    reasons = {frozenset((pair.first, pair.second)): pair.reason for pair in collision.excluded}
    assert reasons[frozenset(("base_0", "shoulder_0"))] == "adjacent"
    assert reasons[frozenset(("mast_0", "tool_1"))] == "ignored"
    assert not any("tool" in name and "mast" in name for name in collision.names)
    assert "tool_0 to tool_1" not in collision.names
    pairs = len(collision.names) + len(collision.excluded)
    assert pairs == 8 * 7 // 2 - 3  # all, but for three within slider and tool, which are one body


def test_bodies_together_by_design_are_left_out_and_listed(tmp_path):
    parts = [part.replace('radius="0.06" length="0.3"', 'radius="0.3" length="0.9"') for part in arm.PARTS]
    path = arm.write(tmp_path, parts)
    collision = Collision.of(read_model(path).robot, read_geometry(path))
    found = [pair for pair in collision.excluded if {pair.first, pair.second} == {"fore_0", "tool_0"}]
    assert found == []  # the slide takes the tool out of the long cylinder
    robot = read_model(path).robot
    robot.limits.position_upper[robot.joints.index("slide")] = -0.15
    collision = Collision.of(robot, read_geometry(path))
    found = [pair for pair in collision.excluded if {pair.first, pair.second} == {"fore_0", "tool_0"}]
    assert "by design" in found[0].reason
    assert not any(name == "fore_0 to tool_0" for name in collision.names)


def test_a_link_that_is_not_there_and_geometry_of_another_robot_are_refused(tmp_path):
    robot, geometry = arm.small_arm(tmp_path)
    with pytest.raises(RobotError, match="no link 'hand'.*Links: base, fore, mast"):
        Collision.of(robot, geometry, ignored=[("hand", "base")])
    other = read_model(arm.write(tmp_path, turning(), "other.urdf")).robot
    with pytest.raises(RobotError, match="Read robot and geometry from one file"):
        Collision.of(other, geometry)


@pytest.mark.parametrize("seed", range(6))
def test_nothing_on_a_trajectory_is_nearer_than_proved(small, seed):
    robot, collision = small
    found = bound_is_proved(collision, sine_motion(robot, seed))
    assert found.allowed == (found.bound >= -1e-3)


def test_a_contact_between_samples_is_found(small):
    """The joint swings at 10 Hz, so that every tenth of a second shows it at rest in one place."""
    robot, collision = small
    centre, swing = np.zeros(robot.dof), np.zeros(robot.dof)
    lift = robot.joints.index("lift")
    centre[lift], swing[lift] = 0.2, 2.6
    trajectory = SineMotion(centre, swing, np.full(robot.dof, 20 * np.pi), np.zeros(robot.dof), 1.0)
    assert np.min(collision.margins(trajectory.every(0.1).position)) > 0
    found = collision.worst(trajectory)
    assert found.margin < 0
    assert not found.allowed


@dataclass(frozen=True, eq=False)
class AwayFrom(Clearance):
    """A joint kept away from one position: a margin that always changes as fast as its reach allows."""

    position: float
    names = ("away",)

    def margins(self, position):
        return np.abs(position - self.position)

    def gradient(self, position):
        return self.margins(position), np.sign(position - self.position)[:, :, None]

    def reach(self, travel):
        return np.ones((1, 1))


@pytest.mark.parametrize("position", np.linspace(-0.9, 0.95, 20))
def test_the_bound_holds_where_the_margin_falls_as_fast_as_it_can(position):
    """The joint passes the position, so that the margin is 0 there, at some time that is no sample's."""
    swing = SineMotion(np.zeros(1), np.ones(1), np.array([2.0]), np.zeros(1), 3.0)
    found = nearest(AwayFrom(position), swing)
    assert found.bound <= 0.0
    assert 0.0 <= found.margin <= 2 * RESOLUTION


class Unmeasured(Clearance):
    names = ("what no one can measure",)

    def margins(self, position):
        return np.where(position[:, :1] > 0.9, np.nan, 1.0)

    def gradient(self, position):
        raise NotImplementedError

    def reach(self, travel):
        return np.full((1, len(travel)), 10.0)


def test_a_margin_that_cannot_be_measured_is_not_allowed():
    assert not nearest(Unmeasured(), SineMotion(*np.ones((4, 1)), 1.0)).allowed
    between = SineMotion(np.zeros(1), np.ones(1), np.array([20 * np.pi]), np.zeros(1), 1.0)
    assert np.all(Unmeasured().margins(between.every(0.1).position) == 1.0)
    assert not nearest(Unmeasured(), between).allowed
    assert nearest(Unmeasured(), SineMotion(*0.1 * np.ones((4, 1)), 1.0)).allowed


def test_it_can_be_sent_to_another_process(small):
    robot, collision = small
    position = random_positions(robot, 3)
    copy = pickle.loads(pickle.dumps(collision))
    np.testing.assert_array_equal(copy.distances(position), collision.distances(position))
    assert copy.names == collision.names


def turning(base="", body=""):
    """Parts of an arm of one joint, with bodies on its two links."""
    return [arm.link("base", base), arm.link("arm", body), arm.joint("only", "base", "arm", "0 0 1")]


def test_an_arm_without_geometry_has_none(tmp_path):
    assert read_geometry(arm.write(tmp_path, turning())) is None
    assert read_geometry("kr270") is None
    (tmp_path / "rows.toml").write_text('[[link]]\njoint = "a"\n')
    assert read_geometry(tmp_path / "rows.toml") is None


def test_one_body_alone_keeps_clear_of_everything(tmp_path):
    path = arm.write(tmp_path, turning(body=arm.body('sphere radius="0.1"')))
    collision = Collision.of(read_model(path).robot, read_geometry(path))
    assert collision.names == []
    assert collision.gradient(np.zeros((4, 1)))[1].shape == (4, 0, 1)
    assert collision.worst(SineMotion(*np.ones((4, 1)), 1.0)).allowed


def test_a_robot_file_names_its_urdf(tmp_path):
    arm.write(tmp_path)
    (tmp_path / "robot.toml").write_text('urdf = "small.urdf"\n')
    assert read_geometry(tmp_path / "robot.toml").ngeoms == 8


def ell():
    """Corners of an L-shaped bar: its inner edge is not on its hull; shape (12, 3) [m]."""
    outline = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 2], [0, 2]], float)
    return np.concatenate([np.column_stack([outline, np.full(6, z)]) for z in (0.0, 1.0)])


def write_mesh(path):
    """Any triangles over the corners will do: only the hull of the corners is used."""
    path.parent.mkdir(parents=True, exist_ok=True)
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in ell())
    faces = "".join(f"f {i} {i + 1} {i + 2}\n" for i in range(1, 11))
    path.write_text(corners + faces)


def with_mesh(folder, name, scale="1 1 1"):
    folder.mkdir(parents=True, exist_ok=True)
    mesh = arm.body(f'mesh filename="{name}" scale="{scale}"')
    return arm.write(folder, turning(arm.body('sphere radius="0.1"'), mesh))


@pytest.mark.parametrize(
    ("name", "mesh"),
    [
        ("meshes/ell.obj", "ws/my_arm/urdf/meshes/ell.obj"),
        ("package://my_arm/meshes/ell.obj", "ws/my_arm/meshes/ell.obj"),
        ("package://my_arm/meshes/ell.obj", "given/my_arm/meshes/ell.obj"),
        ("package://my_arm/meshes/ell.obj", "ros1/my_arm/meshes/ell.obj"),
        ("package://my_arm/meshes/ell.obj", "ros2/share/my_arm/meshes/ell.obj"),
        ("package://other_name/meshes/ell.obj", "ws/my_arm/meshes/ell.obj"),
    ],
)
def test_a_mesh_is_found_and_taken_as_its_hull(tmp_path, monkeypatch, name, mesh):
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros1"))
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "ros2"))
    urdf = with_mesh(tmp_path / "ws" / "my_arm" / "urdf", name, "0.1 0.1 0.2")
    (tmp_path / "ws" / "my_arm" / "package.xml").write_text("<package/>")
    write_mesh(tmp_path / mesh)
    geometry = read_geometry(urdf, [tmp_path / "given"])
    shape = geometry.geometryObjects[1].geometry
    assert shape.num_points == 10  # twelve corners, but for the inner edge
    # 3 x 2 less the corner triangle of 2 x 1 / 2, one high, in metres after scaling
    assert shape.computeVolume() == pytest.approx(5.0 * 0.1 * 0.1 * 0.2)


def test_a_mesh_that_is_not_there_is_named_with_the_folders_searched(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # whose name may be so long that the message is shortened
    monkeypatch.setenv("ROS_PACKAGE_PATH", "ros1")
    urdf = with_mesh(Path("urdf"), "package://my_arm/meshes/none.stl")
    with pytest.raises(RobotError, match="link 'arm': mesh 'package://my_arm/meshes/none.stl'") as caught:
        read_geometry(urdf, ["given"])
    assert "Searched: given, ros1, the folders around the URDF. State" in str(caught.value)


def test_a_file_that_is_no_mesh_is_named(tmp_path):
    urdf = with_mesh(tmp_path, "meshes/ell.obj")
    write_mesh(tmp_path / "meshes/ell.obj")
    (tmp_path / "meshes/ell.obj").write_text("not a mesh")
    with pytest.raises(RobotError, match=r"link 'arm': mesh .*ell.obj cannot be read"):
        read_geometry(urdf)


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ('sphere radius="-1"', "every size must be above 0 m"),
        ('box size="1 1"', r"expected 3 finite number"),
        ('cylinder radius="1"', r'length="">: expected 1 finite number'),
        ('cone radius="1"', "expected one of box, capsule"),
    ],
)
def test_a_wrong_shape_is_named(tmp_path, shape, message):
    with pytest.raises(BrokenTree, match=f"link 'base'.*{message}"):
        read_geometry(arm.write(tmp_path, turning(arm.body(shape))))


def test_a_flat_mesh_has_a_hull():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0]], float)
    corners = np.array(hull(square).points(), float)
    np.testing.assert_allclose(np.ptp(corners, axis=0), [1, 1, 0], atol=1e-6)


def ur10():
    """The URDF of a UR10 with its meshes, if the package example-robot-data is installed."""
    share = Path(pin.__file__).parents[4] / "share"
    path = share / "example-robot-data" / "robots" / "ur_description" / "urdf" / "ur10_robot.urdf"
    if not path.exists():
        pytest.skip("not installed: example-robot-data, which has a UR10 with meshes; pip install '.[bench]'")
    return path


def test_ur10_watches_what_can_collide():
    path = ur10()
    robot = read_model(path).robot
    collision = Collision.of(robot, read_geometry(path))
    together = {(pair.first, pair.second) for pair in collision.excluded if "design" in pair.reason}
    assert ("forearm_link_0", "wrist_2_link_0") in together
    assert "upper_arm_link_0 to wrist_3_link_0" in collision.names
    position = random_positions(robot, 50)
    gradient = collision.distances_and_gradient(position)[1]
    error = np.abs(gradient - differences(collision.distances, position))
    assert np.quantile(error, 0.99) < 1e-6
    bound_is_proved(collision, sine_motion(robot, 1))
