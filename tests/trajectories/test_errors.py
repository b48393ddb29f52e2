import pinocchio as pin
import pytest

from exidyn.identification.arm.robot import Robot
from exidyn.trajectories.errors import BadLimits, Infeasible, in_words_of, named

from ..parts.small.two_joints import arm


def gantry():
    kinematics = pin.Model()
    kinematics.addJoint(0, pin.JointModelPX(), pin.SE3.Identity(), "rail")
    kinematics.addJoint(1, pin.JointModelRZ(), pin.SE3.Identity(), "swivel")
    return Robot("gantry", kinematics)


@pytest.mark.parametrize("error", [BadLimits, Infeasible])
def test_errors_inside_name_the_joints(error):
    with (
        pytest.raises(error, match=r"^no lead: elbow: at 3 rad; shoulder: at 2 rad/s$") as caught,
        in_words_of(arm()),
    ):
        raise error("no lead: joint 2: at 3 rad; joint 1: at 2 rad/s")
    assert isinstance(caught.value.__cause__, error)


def test_a_joint_that_slides_is_in_metres_and_newtons():
    text = "joint 1: 2 rad/s^2 of 3 rad, 4 N m; joint 2: 2 rad/s of 3 rad, 4 N m"
    assert named(text, gantry()) == "rail: 2 m/s^2 of 3 m, 4 N; swivel: 2 rad/s of 3 rad, 4 N m"


@pytest.mark.parametrize(
    "text", ["joint 3: 1 rad", "joint 0: 1 rad", "no joint 1 here", "the elbow: 1 rad", ""]
)
def test_what_is_about_no_joint_of_the_robot_stays(text):
    assert named(text, gantry()) == text


def test_what_else_is_raised_inside_is_left_alone():
    with pytest.raises(KeyError, match="joint 1: x"), in_words_of(arm()):
        raise KeyError("joint 1: x")
