import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.rigid_regressor import INERTIAL
from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.effects.rigid_body import inertial_parameters
from exidyn.identification.errors import RobotError, UnknownKey
from exidyn.identification.model import Model

from ...parts.runs.robots import body, random_motion, six_axis, sliding

pytestmark = pytest.mark.numerical

CARRIED = body(np.random.default_rng(21))
VALUES = dict(zip(INERTIAL, inertial_parameters(CARRIED), strict=True))
SUBSETS = [(), ("M",), ("ZZ", "M", "XY"), INERTIAL]


@pytest.fixture(params=[six_axis, sliding], ids=["six axis", "sliding"])
def robot(request):
    return request.param()


def added_torque(robot, motion):
    """What the body adds to inverse dynamics when it is part of the last link."""
    loaded = robot.kinematics.copy()
    loaded.appendBodyToJoint(robot.kinematics.njoints - 1, CARRIED, robot.flange)
    states = list(zip(motion.position, motion.velocity, motion.acceleration, strict=True))

    def torque(model):
        data = model.createData()
        return np.array([pin.rnea(model, data, *state).copy() for state in states])

    return torque(loaded) - torque(robot.kinematics)


@pytest.mark.parametrize("known", SUBSETS, ids=["nothing", "mass", "three", "all"])
def test_known_and_unknown_make_the_torque_of_the_body(robot, known):
    motion = random_motion(robot, payload="L")
    payload = Payload("L", tuple((name, VALUES[name]) for name in known))
    unknown = [name for name in INERTIAL if name not in known]
    assert [parameter.name for parameter in payload.parameters(robot)] == [f"{name}L" for name in unknown]
    torque = payload.regressor(robot, motion) @ np.array([VALUES[name] for name in unknown])
    torque += payload.known_torque(robot, motion)
    np.testing.assert_allclose(torque, added_torque(robot, motion), rtol=1e-9, atol=1e-8)
    assert payload.inertias(robot) == ([] if known else [slice(0, 10)])


@pytest.mark.parametrize("carried", ["", "other"])
def test_runs_without_it_feel_nothing(robot, carried):
    motion = random_motion(robot, payload=carried)
    payload = Payload("L", (("M", 5.0),))
    assert payload.regressor(robot, motion).shape == (*motion.position.shape, 9)
    assert not payload.regressor(robot, motion).any()
    assert not payload.known_torque(robot, motion).any()


def test_a_balanced_body_is_simulated_as_a_point(robot):
    """Without inertia about the flange it is no body: its inertia about its center is negative."""
    center = np.array([0.1, 0.2, -0.3])
    model = Model(robot, (Payload("L", known_parameters(2.0, center)),))
    [inertia] = model.effects[0].bodies(robot, model.nominal_values, "L").values()
    expected = robot.flange.act(pin.Inertia(2.0, center, np.zeros((3, 3))))
    np.testing.assert_allclose(inertia.toDynamicParameters(), expected.toDynamicParameters(), atol=1e-12)


def test_a_drawn_body_knows_all_ten_about_the_flange():
    mass, com = 2.0, np.array([0.1, 0.2, -0.3])
    xx, xy, xz, yy, yz, zz = 0.5, 0.01, -0.02, 0.6, 0.03, 0.7
    x, y, z = com
    expected = {
        "XX": xx + mass * (y * y + z * z),
        "XY": xy - mass * x * y,
        "XZ": xz - mass * x * z,
        "YY": yy + mass * (x * x + z * z),
        "YZ": yz - mass * y * z,
        "ZZ": zz + mass * (x * x + y * y),
        **dict(known_parameters(mass, com)),
    }
    known = known_parameters(mass, com, (xx, xy, xz, yy, yz, zz))
    assert [name for name, _ in known] == list(INERTIAL)
    assert dict(known) == pytest.approx(expected)


def test_unknown_names_are_met_with_the_valid_ones():
    with pytest.raises(UnknownKey, match="payload L: unknown key 'mass'.*MZ"):
        Payload("L", (("mass", 3.0),))
    with pytest.raises(RobotError, match="known twice: M"):
        Payload("L", (("M", 3.0), ("M", 4.0)))


@pytest.mark.parametrize("mass", [0.0, -1.0, float("nan")])
def test_a_body_has_mass(mass):
    with pytest.raises(RobotError, match="must be above 0"):
        known_parameters(mass)


def test_inertia_needs_its_point_and_a_body_that_has_it():
    with pytest.raises(RobotError, match="give com too"):
        known_parameters(3.0, inertia=(1, 0, 0, 1, 0, 1))
    with pytest.raises(RobotError, match="payload: no body can have the inertia"):
        known_parameters(3.0, (0.0, 0.0, 0.1), (-1.0, 0.0, 0.0, 1.0, 0.0, 1.0))
