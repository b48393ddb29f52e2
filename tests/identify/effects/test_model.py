import numpy as np
import pytest

from exidyn.identification.effects import (
    CoulombFriction,
    LoadDependentFriction,
    Payload,
    Prior,
    RigidBody,
    RotorInertia,
    ViscousFriction,
    known_parameters,
)
from exidyn.identification.errors import RobotError
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import parse_model

from ...parts.runs.robots import random_motion, six_axis

pytestmark = pytest.mark.numerical

BODY = Payload("A", known_parameters(3.0, com=(0.1, -0.2, 0.3), inertia=(0.1, 0.0, 0.02, 0.2, 0.0, 0.3)))


@pytest.fixture
def robot():
    return six_axis()


def test_torque_is_the_sum_of_the_effects_in_their_order(robot):
    motion = random_motion(robot)
    model = Model(robot, (RotorInertia(("joint2",)), ViscousFriction(("joint3", "joint1"))))
    assert model.names == ["Ia2", "Fv3", "Fv1"]
    columns = model.regressor(motion)
    np.testing.assert_array_equal(columns[:, 1, 0], motion.acceleration[:, 1])
    np.testing.assert_array_equal(columns[:, 2, 1], motion.velocity[:, 2])
    np.testing.assert_array_equal(columns[:, 0, 2], motion.velocity[:, 0])
    assert np.count_nonzero(columns) == np.count_nonzero(motion.velocity[:, [0, 2]]) + len(motion)
    motion = random_motion(robot, payload="A")
    friction, body = ViscousFriction(), RigidBody()
    model = Model(robot, (friction, BODY, body))
    values = np.random.default_rng(1).normal(size=len(model.names))
    expected = friction.regressor(robot, motion) @ values[:6] + body.regressor(robot, motion) @ values[6:]
    expected += BODY.known_torque(robot, motion)
    np.testing.assert_allclose(model.torque(motion, values), expected, rtol=1e-12, atol=1e-10)


def test_adding_an_effect_makes_a_new_model(robot):
    model = Model(robot, (RotorInertia(),), {"Ia1": Prior(2.0, 0.1)})
    more = model + ViscousFriction()
    assert len(model.names) == 6
    assert more.names == [*model.names, *(f"Fv{joint}" for joint in range(1, 7))]
    assert more.priors[0] == Prior(2.0, 0.1)


def test_a_name_stands_for_one_parameter(robot):
    with pytest.raises(RobotError, match="six axis.*twice: Fc2"):
        Model(robot, (CoulombFriction(("joint1", "joint2")), CoulombFriction(("joint2",))))


def test_what_is_stated_beats_what_the_robot_states(robot):
    plain = Model(robot, (RigidBody(), ViscousFriction()))
    stated = Model(robot, plain.effects, {"M2": Prior(9.0, 0.5), "Fv6": Prior(4.0)})
    at = {name: index for index, name in enumerate(plain.names)}
    assert plain.nominal_values[at["M2"]] == pytest.approx(robot.kinematics.inertias[2].mass)
    assert plain.priors[at["Fv6"]] == Prior(0.0, np.inf)
    assert stated.priors[at["M2"]] == Prior(9.0, 0.5)
    assert stated.nominal_values[at["Fv6"]] == 4.0
    assert stated.priors[at["M3"]] == plain.priors[at["M3"]]


def test_inertias_point_at_bodies_wherever_they_stand(robot):
    model = Model(robot, (ViscousFriction(), RigidBody(), BODY, Payload("B")))
    names = [model.names[columns] for columns in model.inertias]
    assert len(names) == 7
    assert [bodies[0] for bodies in names] == [*(f"XX{link}" for link in range(1, 7)), "XXB"]
    assert [bodies[9] for bodies in names] == [*(f"M{link}" for link in range(1, 7)), "MB"]


def test_load_is_what_the_gears_transmit_with_the_nominal_values(robot):
    motion = random_motion(robot, payload="A")
    stated = {"Fv1": Prior(50.0), "Ia2": Prior(8.0), "mu3": Prior(0.1)}
    model = Model(
        robot, (RotorInertia(), RigidBody(), BODY, ViscousFriction(), LoadDependentFriction()), stated
    )
    links = Model(robot, (RigidBody(),))
    expected = links.torque(motion, links.nominal_values) + BODY.known_torque(robot, motion)
    np.testing.assert_allclose(model.loaded(motion).load, expected, rtol=1e-12)
    assert np.abs(model.torque(motion, model.nominal_values) - expected).max() > 1.0
    motion = random_motion(robot)
    model = Model(robot, (ViscousFriction(), LoadDependentFriction()), {"Fv1": Prior(5.0)})
    np.testing.assert_array_equal(model.loaded(motion).load, np.zeros_like(motion.position))


def test_a_description_of_geometry_alone_states_no_inertia():
    """Its masses of zero are not known to be zero: a fit is free, and nothing is off nominal."""
    geometry = parse_model("[[mdh]]\n[[mdh]]\nalpha = 1.5\nd = 0.3\n").robot
    assert all(np.isinf(prior.std) for prior in RigidBody().priors(geometry).values())
    one = parse_model("[[mdh]]\n[[mdh]]\nalpha = 1.5\nd = 0.3\nM = 2.0\n").robot
    assert RigidBody().priors(one)["M1"].std == 0.0
    assert RigidBody().priors(one)["M2"].std > 0.0
