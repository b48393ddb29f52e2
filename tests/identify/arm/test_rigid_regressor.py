import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.rigid_regressor import INERTIAL, body_regressor, rigid_regressor
from exidyn.identification.arm.robot import Robot
from exidyn.identification.effects.rigid_body import inertial_parameters

from ...parts.runs.robots import body, kinematics, placement, random_motion

pytestmark = pytest.mark.numerical

TREES = {
    "revolute": {"joints": "rrrrrr"},
    "prismatic": {"joints": "ppp"},
    "mixed": {"joints": "rprrpr"},
    "branched": {"joints": "rrprrrp", "parents": (0, 1, 2, 2, 4, 1, 6)},
    "two on the base": {"joints": "rrr", "parents": (0, 0, 2)},
    "tilted gravity": {"joints": "rrpr", "gravity": (3.0, -4.0, -8.0)},
    "no gravity": {"joints": "rr", "gravity": (0.0, 0.0, 0.0)},
    "one joint": {"joints": "r"},
}


@pytest.fixture(params=TREES.values(), ids=TREES.keys())
def tree(request):
    return kinematics(**request.param, seed=5)


@pytest.fixture
def motion(tree):
    return random_motion(Robot("tree", tree))


def torque(model, motion):
    """Inverse dynamics, sample by sample."""
    data = model.createData()
    states = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
    return np.array([pin.rnea(model, data, *state).copy() for state in states])


def regressor(tree, motion):
    return rigid_regressor(tree, motion)


def test_torque_and_columns_are_those_of_pinocchio(tree, motion):
    values = np.concatenate([inertial_parameters(inertia) for inertia in list(tree.inertias)[1:]])
    np.testing.assert_allclose(regressor(tree, motion) @ values, torque(tree, motion), atol=1e-9, rtol=1e-10)
    order = [9, 6, 7, 8, 0, 1, 3, 2, 4, 5]  # of ours, in the order m mx my mz xx xy yy xz yz zz
    columns = [10 * link + column for link in range(tree.nv) for column in order]
    data = tree.createData()
    for row, found in enumerate(regressor(tree, motion)[:5, :, columns]):
        state = motion.position[row], motion.velocity[row], motion.acceleration[row]
        expected = pin.computeJointTorqueRegressor(tree, data, *state).reshape(found.shape)
        np.testing.assert_allclose(found, expected, atol=1e-10, rtol=1e-10)


def test_body_on_the_last_link_adds_its_torque(tree, motion):
    random = np.random.default_rng(11)
    flange, carried = placement(random), body(random)
    loaded = tree.copy()
    loaded.appendBodyToJoint(tree.njoints - 1, carried, flange)
    columns = body_regressor(tree, motion, flange)
    added = torque(loaded, motion) - torque(tree, motion)
    np.testing.assert_allclose(columns @ inertial_parameters(carried), added, atol=1e-8, rtol=1e-9)
    columns = body_regressor(tree, motion, pin.SE3.Identity())
    np.testing.assert_allclose(columns, regressor(tree, motion)[:, :, -len(INERTIAL) :], atol=1e-12)
