"""Each effect in the plant is what it is in the model: torque, inertia, memory."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import EFFECTS, Hysteresis, Payload, RigidBody, known_parameters
from exidyn.identification.effects.rigid_body import inertial_parameters
from exidyn.identification.errors import WrongShape
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.plant import Transmission
from exidyn.identification.simulation.plant.forces import SHIFT, ArmForces, Joints

from ...parts.runs.robots import body, random_motion, six_axis, sliding
from ...parts.runs.simulated import known
from ..effects.test_effects import default

ROBOTS = {"six axis": six_axis, "sliding": sliding}


def drawn(model, seed=5):
    """Values such as the arm could have: of bodies, those of a body."""
    random = np.random.default_rng(seed)
    values = random.uniform(0.5, 2.0, len(model.names))
    values[[name.startswith("mu") for name in model.names]] = 0.05
    for columns in model.inertias:
        values[columns] = inertial_parameters(body(random))
    return values


def torque_of(model, values, motion, row, payload="L"):
    """Torque and inertia of the plant at one sample of a motion, without a memory of what was before."""
    forces = ArmForces(model, values, payload, Transmission.rigid(model.robot.dof))
    state = Joints(motion.position[row], motion.velocity[row], motion.acceleration[row])
    local, inertia = forces.at(state, motion.position[row], motion.temperature[row])
    return local.force + inertia @ motion.acceleration[row], local, inertia


@pytest.fixture(params=ROBOTS.values(), ids=ROBOTS.keys())
def robot(request):
    return request.param()


@pytest.mark.parametrize("key", EFFECTS)
def test_every_effect_makes_the_torque_of_the_model(key, robot):
    model = Model(robot, (RigidBody(), default(key)) if key != "link_inertia" else (RigidBody(),))
    values = drawn(model)
    motion = known(model, values).loaded(random_motion(robot, payload="L"))
    for row in (0, 3, 11):
        alone = motion[row : row + 1]
        expected = model.torque(alone, values)[0]
        found, _, inertia = torque_of(model, values, motion, row)
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
        np.testing.assert_allclose(inertia, inertia.T, atol=1e-9 * np.abs(inertia).max())


@pytest.mark.parametrize("name", ["cobot", "kr270"])
def test_an_arm_with_balancer_and_payload_makes_the_torque_of_its_model(name):
    body = known_parameters(20.0, (0.05, 0.03, 0.2), (0.8, 0.1, 0.2, 0.9, 0.3, 0.7))
    model = read_model(name) + Payload("L", body)
    values, motion = model.nominal_values, random_motion(model.robot, payload="L")
    for row in range(5):
        expected = model.torque(motion[row : row + 1], values)[0]
        np.testing.assert_allclose(torque_of(model, values, motion, row)[0], expected, rtol=1e-9, atol=1e-9)


def test_a_payload_that_is_not_carried_weighs_nothing():
    model = read_model("cobot") + Payload("L", known_parameters(10.0, (0.0, 0.0, 0.1)))
    motion = random_motion(model.robot)
    expected = model.torque(motion[2:3], model.nominal_values)[0]
    found = torque_of(model, model.nominal_values, motion, 2, payload="")[0]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


def test_links_without_mass_are_taken_from_their_columns():
    robot = six_axis()
    model = Model(robot, (RigidBody(),))
    values = drawn(model)
    values[9::10] = 0.0  # as regrouped parameters are: moments without a mass
    assert not RigidBody().bodies(robot, values, "")
    motion = random_motion(robot)
    expected = model.torque(motion[4:5], values)[0]
    np.testing.assert_allclose(torque_of(model, values, motion, 4)[0], expected, rtol=1e-9)


def test_slope_is_that_of_the_torque_by_each_velocity():
    model = read_model("cobot")
    motion = random_motion(model.robot)
    slow = replace(motion, velocity=1e-3 * motion.velocity)
    values = model.nominal_values
    friction = Model(model.robot, model.effects[2:4])
    own = values[-18:-6]
    faster = replace(slow, velocity=slow.velocity + SHIFT)
    expected = (friction.torque(faster, own) - friction.torque(slow, own)) / SHIFT
    _, local, _ = torque_of(model, values, slow, 7)
    np.testing.assert_allclose(local.slope, expected[7], rtol=1e-6)


def test_values_of_another_model_are_refused():
    model = read_model("cobot")
    with pytest.raises(WrongShape, match=r"cobot: values have shape \(3,\), expected \(84,\)"):
        ArmForces(model, np.zeros(3), "", Transmission.rigid(6))


@pytest.mark.parametrize("key", EFFECTS)
def test_pieces_of_a_run_are_the_whole(key, robot):
    effect, motion = default(key), random_motion(robot, payload="L")
    if not effect.pointwise:  # creep, in which a memory of strides of a radian is not saturated
        steps = np.random.default_rng(1).choice([-1e-4, 0.0, 1e-4], motion.position.shape)
        motion = replace(motion, position=np.cumsum(steps, axis=0))
    memory, pieces = None, []
    for start, stop in ((0, 1), (1, 2), (2, 17), (17, len(motion))):
        columns, memory = effect.continued(robot, motion[start:stop], memory)
        pieces.append(columns)
    whole = effect.regressor(robot, motion)
    np.testing.assert_allclose(np.concatenate(pieces), whole, rtol=1e-12, atol=1e-12)


def test_hysteresis_remembers_where_the_arm_came_and_not_what_was_foreseen():
    robot = six_axis()
    model = Model(robot, (RigidBody(), Hysteresis()))
    values = drawn(model)
    forces = ArmForces(model, values, "", Transmission.rigid(6))
    still, there, warm = np.zeros(6), np.full(6, 1e-3), np.full(6, 25.0)
    forces.remember(still)
    forces.at(Joints(there, still, still), there, warm)
    once = forces.at(Joints(there, still, still), there, warm)[0].force
    again = forces.at(Joints(there, still, still), there, warm)[0].force
    np.testing.assert_array_equal(once, again)
    forces.remember(there)
    back = forces.at(Joints(still, still, still), still, warm)[0].force
    back -= (
        ArmForces(model, values * [*[1.0] * 60, *[0.0] * 6], "", Transmission.rigid(6))
        .at(Joints(still, still, still), still, warm)[0]
        .force
    )
    left = 1 - np.exp(-1e-3 / 3e-4)
    np.testing.assert_allclose(back / values[-6:], -1 + (1 + left) * np.exp(-1e-3 / 3e-4), rtol=1e-6)
