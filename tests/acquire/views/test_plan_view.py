"""The Rerun recording of a plan: read back, it is the trajectory's; a viewer takes all of it."""

from dataclasses import replace

import coal
import numpy as np
import pinocchio as pin
import pytest

from exidyn.acquire.views import viewers
from exidyn.acquire.views.live_view import Targets
from exidyn.acquire.views.parts import FRAMES
from exidyn.acquire.views.plan_view import plan_view
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import Payload
from exidyn.identification.robot_files.surroundings import Obstacle
from exidyn.trajectories.plans.plan_check import nominal_torque
from exidyn.trajectories.plans.plan_space import space_of

from ...parts.pages.rerun_viewer import numbers, require_drawn, require_poses, saved, seconds, text_of
from ...parts.plans.plans import fourier, known_plan
from ...parts.small import two_joints
from ...trajectories.plans.test_plan_plots import BODY

pytestmark = pytest.mark.slow

MODEL = two_joints.model(Payload("L", BODY))
OBSTACLES = (
    Obstacle("floor", "plane", coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0), pin.SE3.Identity()),
    Obstacle("crate", "box", coal.Box(0.2, 0.4, 0.6), pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.3]))),
)


def around(plan):
    return space_of(plan.trajectory, MODEL.robot, OBSTACLES, ())


@pytest.fixture(scope="module")
def plan():
    """Beyond some limits, to be run twice."""
    return known_plan(fourier().scaled(4.0))


@pytest.fixture(scope="module")
def chunks(plan, tmp_path_factory):
    return saved(plan_view(plan, MODEL, around(plan)), tmp_path_factory.mktemp("view") / "plan.rrd")


def test_curves_read_back_are_those_of_the_trajectory(chunks, plan):
    states = plan.trajectory.every(plan.tick)
    for k, joint in enumerate(plan.joints):
        for name in ("position", "velocity", "acceleration", "jerk"):
            entity = f"/{name}/{joint}/planned"
            np.testing.assert_array_equal(numbers(chunks, entity), getattr(states, name)[:, k])
            np.testing.assert_allclose(seconds(chunks, entity), states.time, atol=2e-9)


def test_torque_has_a_curve_for_each_run(chunks, plan):
    for run, values in nominal_torque(plan, MODEL).runs:
        np.testing.assert_array_equal(numbers(chunks, f"/torque/elbow/{run}"), values[:, 1])


def test_limits_and_what_is_beyond_are_there(chunks, plan):
    np.testing.assert_array_equal(numbers(chunks, "/velocity/shoulder/upper limit"), [3.0, 3.0])
    np.testing.assert_array_equal(numbers(chunks, "/velocity/shoulder/lower limit"), [-3.0, -3.0])
    np.testing.assert_allclose(
        seconds(chunks, "/velocity/shoulder/lower limit"), [0.0, plan.trajectory.every(plan.tick).time[-1]]
    )
    velocity = plan.trajectory.every(plan.tick).velocity[:, 0]
    expected = velocity[np.abs(velocity) > 3.0]
    assert len(expected) > 0
    np.testing.assert_array_equal(numbers(chunks, "/velocity/shoulder/planned beyond"), expected)


def test_shares_are_of_the_limits(chunks, plan):
    found = numbers(chunks, "/share/velocity").reshape(-1, 2)
    np.testing.assert_allclose(found, 100 / 3.0 * plan.trajectory.every(plan.tick).velocity)


def test_arm_moves_as_planned(chunks, plan):
    require_poses(chunks, "/arm/moves", MODEL.robot.kinematics, plan.trajectory.every(1.0 / FRAMES).position)


def test_summary_reports_what_is_beyond(chunks):
    assert "Motion for two joints" in text_of(chunks, "/summary")
    assert "BEYOND: shoulder: velocity" in text_of(chunks, "/summary")


def test_flange_goes_along_its_path(chunks, plan):
    position = plan.trajectory.every(1.0 / FRAMES).position
    kinematics = MODEL.robot.kinematics.copy()
    frame = kinematics.addFrame(pin.Frame("flange", 2, 0, MODEL.robot.flange, pin.FrameType.OP_FRAME))
    (way,) = chunks["/arm/path of the flange", "LineStrips3D:strips"][0].to_pylist()[0]
    data = kinematics.createData()
    for pose, place in zip(position, way, strict=True):
        pin.framesForwardKinematics(kinematics, data, pose)
        np.testing.assert_allclose(place, data.oMf[frame].translation, atol=1e-6)


def test_obstacles_stand_where_they_are(chunks):
    (corners,) = chunks["/arm/crate", "Mesh3D:vertex_positions"]
    corners = np.array(corners.to_pylist()[0])
    np.testing.assert_allclose(np.min(corners, axis=0), [0.9, -0.2, 0.0], atol=1e-6)
    np.testing.assert_allclose(np.max(corners, axis=0), [1.1, 0.2, 0.6], atol=1e-6)
    (sheet,) = chunks["/arm/floor", "Mesh3D:vertex_positions"]
    assert np.all(np.array(sheet.to_pylist()[0])[:, 2] == 0.0)


@pytest.mark.parametrize("limited", [True, False])
def test_viewer_shows_every_view_without_complaint(plan, limited, monkeypatch):
    plan = plan if limited else replace(plan, limits=Limits.none(2))
    end = plan.trajectory.every(plan.tick).time[-1]
    # five quantities together, five of each of two joints, the arm and the summary
    expected = 5 + 5 * 2 + 2
    view = plan_view(plan, MODEL, around(plan))
    require_drawn(lambda: viewers.show(view, Targets(view=True)), end, expected, monkeypatch)
