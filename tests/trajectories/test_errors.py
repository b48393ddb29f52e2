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


def test_errors_inside_name_the_joints_and_others_are_left_alone():
    for error in (BadLimits, Infeasible):
        with (
            pytest.raises(error, match=r"^no lead: elbow: at 3 rad; shoulder: at 2 rad/s$"),
            in_words_of(arm()),
        ):
            raise error("no lead: joint 2: at 3 rad; joint 1: at 2 rad/s")
    with pytest.raises(KeyError, match="joint 1: x"), in_words_of(arm()):
        raise KeyError("joint 1: x")


def test_a_joint_that_slides_is_in_metres_and_newtons():
    text = "joint 1: 2 rad/s^2 of 3 rad, 4 N m; joint 2: 2 rad/s of 3 rad, 4 N m"
    assert named(text, gantry()) == "rail: 2 m/s^2 of 3 m, 4 N; swivel: 2 rad/s of 3 rad, 4 N m"
    for other in ("joint 3: 1 rad", "joint 0: 1 rad", "no joint 1 here", "the elbow: 1 rad", ""):
        assert named(other, gantry()) == other
