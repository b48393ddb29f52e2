"""Obstacles: where they are, how far the arm is from them, and what of them is not looked at."""

import coal
import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.errors import RobotError, UnknownKey
from exidyn.identification.robot_files.geometry import read_geometry
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.robot_files.surroundings import read_surroundings, with_obstacles
from exidyn.trajectories.clearances.clearance import clear_position, random_positions
from exidyn.trajectories.clearances.collision import Collision
from exidyn.trajectories.errors import Infeasible

from ...parts.plans.clearance_checks import bound_is_proved, differences
from ...parts.plans.sine_motion import sine_motion
from ...parts.small import small_arm as arm

ROWS = """
[[obstacle]]
name = "floor"
plane = [0, 0, 2]
at = [0, 0, -0.3]

[[obstacle]]
name = "table"
box = [0.6, 0.8, 0.4]
at = [1.1, 0.2, 0.2]
rpy = [0, 0, 0.3]

[[obstacle]]
name = "ball"
sphere = 0.15
at = [-0.5, -0.6, 1.2]

[[obstacle]]
name = "post"
cylinder = [0.1, 1.8]
at = [-0.9, 0.6, 0.9]
"""


def read(folder, rows=ROWS):
    """Robot, obstacles, and the clearance of both."""
    path = arm.write(folder)
    (folder / "robot.toml").write_text(f'urdf = "{path.name}"\n{rows}')
    source = folder / "robot.toml"
    robot, obstacles = read_model(source).robot, read_surroundings([source]).obstacles
    return robot, obstacles, Collision.of(robot, with_obstacles(read_geometry(source), obstacles))


def test_distances_are_those_of_coal_at_the_poses_of_pinocchio(tmp_path):
    robot, obstacles, collision = read(tmp_path)
    bodies = {body.name: body for body in read_geometry(tmp_path / "robot.toml").geometryObjects}
    solids = {obstacle.name: obstacle for obstacle in obstacles}
    data, compared = robot.kinematics.createData(), 0
    for position in random_positions(robot, 20, seed=3):
        pin.forwardKinematics(robot.kinematics, data, position)
        found = dict(zip(collision.names, collision.distances(position[None])[0], strict=True))
        for name, distance in found.items():
            body, _, other = name.partition(" to ")
            if other not in solids:
                continue
            place = data.oMi[bodies[body].parentJoint] * bodies[body].placement
            request, result = coal.DistanceRequest(), coal.DistanceResult()
            one = coal.Transform3s(place.rotation, place.translation)
            two = coal.Transform3s(solids[other].placement.rotation, solids[other].placement.translation)
            coal.distance(bodies[body].geometry, one, solids[other].shape, two, request, result)
            assert distance == pytest.approx(result.min_distance, abs=1e-5)
            compared += 1
    assert compared >= 20 * 4 * 4


def test_the_gradient_is_that_of_finite_differences(tmp_path):
    robot, obstacles, collision = read(tmp_path)
    position = random_positions(robot, 5, seed=2)
    rows = [row for row, name in enumerate(collision.names) if name.split(" to ")[1] in ("floor", "ball")]
    expected = differences(lambda p: collision.margins(p)[:, rows], position)
    np.testing.assert_allclose(collision.gradient(position)[1][:, rows], expected, atol=2e-4)
    assert len(obstacles) == 4


def test_nothing_on_a_trajectory_is_nearer_than_proved(tmp_path):
    robot, _, collision = read(tmp_path)
    for seed in range(2):
        found = bound_is_proved(collision, sine_motion(robot, seed))
        assert found.distance == pytest.approx(found.margin + collision.required)


def test_what_stands_on_the_table_is_not_watched_and_what_can_leave_it_is(tmp_path):
    rows = '[[obstacle]]\nname = "table"\nbox = [3, 3, 1.0]\nat = [0, 0, 0.3]\n'
    robot, _, collision = read(tmp_path, rows)
    left_out = {(p.first, p.second) for p in collision.excluded if "table" in (p.first, p.second)}
    assert left_out == {("shoulder_0", "table")}  # the column alone, which one joint turns on the spot
    assert {"fore_0 to table", "tool_0 to table"} <= set(collision.names)
    robot, _, inside = read(tmp_path, '[[obstacle]]\nname = "tank"\nbox = 9\n')
    with pytest.raises(Infeasible, match="to tank by"):
        clear_position(robot, [inside])


def test_a_mesh_is_its_hull_in_its_own_units(tmp_path):
    corners = [(x, y, z) for x in (0, 100) for y in (0, 200) for z in (0, 300)]
    faces = ["1 2 4 3", "5 6 8 7", "1 2 6 5", "3 4 8 7", "1 3 7 5", "2 4 8 6"]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {face}" for face in faces]
    (tmp_path / "fixture.obj").write_text("\n".join(lines))
    rows = '[[obstacle]]\nmesh = "fixture.obj"\nscale = 0.001\nat = [0.5, 0, 0]\n'
    _, obstacles, _ = read(tmp_path, rows)
    assert obstacles[0].name == "mesh"
    points = np.array(obstacles[0].shape.points())
    np.testing.assert_allclose(np.ptp(points, axis=0), [0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    ("row", "error", "words"),
    [
        ("name = 'x'", RobotError, "0 shapes; give one of box"),
        ("box = [1, 0, 1]", RobotError, "above 0 m"),
        ("plane = [0, 0, 0]", RobotError, "points to its free side"),
        ("sphere = 1\nscale = 2", RobotError, "is for a mesh"),
        ("sphere = 1\nradius = 2", UnknownKey, "radius"),
        ("mesh = 'none.stl'", RobotError, "cannot be read"),
        ("sphere = 1\n[[obstacle]]\nsphere = 2", RobotError, "2 obstacles are called 'sphere'"),
    ],
)
def test_a_wrong_row_is_refused_with_its_place(tmp_path, row, error, words):
    with pytest.raises(error, match=words):
        read(tmp_path, f"[[obstacle]]\n{row}\n")
