"""What must hold of every effect, over the table, so that a new one is tested by being in it."""

from dataclasses import MISSING, fields, replace

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.rigid_regressor import INERTIAL
from exidyn.identification.effects import EFFECTS, Effect, JointEffect
from exidyn.identification.effects.simulator_terms import JointTerms
from exidyn.identification.errors import UnknownJoint
from exidyn.identification.model import Model

from ...parts.runs.robots import random_motion, six_axis, sliding

pytestmark = pytest.mark.numerical

CHOICES = {"joint": "joint4", "other": "joint5", "d21": 0.6964, "d22": 0.1847, "phi": -1.6148}
"""Values of the fields that have no default."""

UNITS = {
    *("kg", "kg m", "kg m^2", "N m", "N", "1", "N m s/rad", "N m/rad", "N/m", "N m/K", "N m s/rad/K"),
    *("N s/m", "N/K", "N s/m/K", "rad", "m", "rad/s"),
}

ROBOTS = {"six axis": six_axis, "sliding": sliding}
SHAPES = [(key, name) for key, effect in EFFECTS.items() for name in effect.shapes()]
POINTWISE = [key for key, effect in EFFECTS.items() if effect.pointwise]
JOINT_FIELDS = [
    (key, field.name)
    for key, effect in EFFECTS.items()
    for field in fields(effect)
    if field.name in ("joints", "joint", "other")
]
ON_JOINTS = [key for key, effect in EFFECTS.items() if issubclass(effect, JointEffect)]


def default(key: str, **choices: object) -> Effect:
    missing = [f.name for f in fields(EFFECTS[key]) if f.default is MISSING and f.default_factory is MISSING]
    return EFFECTS[key](**{name: CHOICES[name] for name in missing} | choices)


def known_run(robot):
    """A motion that lets every effect act, the payload too."""
    return random_motion(robot, payload="L")


@pytest.fixture(params=ROBOTS.values(), ids=ROBOTS.keys())
def robot(request):
    return request.param()


@pytest.mark.parametrize("key", EFFECTS)
class TestEveryEffect:
    def test_makes_torque_in_a_column_a_parameter(self, key, robot):
        effect, motion = default(key), known_run(robot)
        columns = effect.regressor(robot, motion)
        assert columns.shape == (*motion.position.shape, len(effect.parameters(robot)))
        assert effect.known_torque(robot, motion).shape == motion.position.shape
        assert np.isfinite(columns).all()
        assert np.abs(columns).max() > 0.0

    def test_describes_its_parameters(self, key, robot):
        effect = default(key)
        parameters, shapes = effect.parameters(robot), effect.shapes()
        names = [parameter.name for parameter in parameters]
        assert 0 < len(set(names)) == len(names)
        assert {*(one.unit for one in parameters), *(shape.unit for shape in shapes.values())} <= UNITS
        assert set(effect.priors(robot)) <= set(names)
        assert all(prior.std >= 0.0 for prior in effect.priors(robot).values())
        for columns in effect.inertias(robot):
            kinds = zip(names[columns], INERTIAL, strict=True)
            assert [name.startswith(kind) for name, kind in kinds] == [True] * 10
        for name, shape in shapes.items():
            assert shape.low < getattr(effect, name) < shape.high
        assert default(key) == effect
        assert hash(default(key)) == hash(effect)

    def test_has_the_derivative_of_every_shape(self, key, robot):
        effect, motion = default(key), known_run(robot)
        derivatives = effect.shape_derivatives(robot, motion)
        assert set(derivatives) == set(effect.shapes())
        for derivative in derivatives.values():
            assert derivative.shape == effect.regressor(robot, motion).shape

    def test_states_what_its_torque_depends_on(self, key, robot):
        effect, motion = default(key), known_run(robot)

        def changes(**other):
            moved = replace(motion, **other)
            pairs = (
                (torque(robot, motion), torque(robot, moved))
                for torque in (effect.regressor, effect.known_torque)
            )
            return any(np.any(one != two) for one, two in pairs)

        assert changes(load=2.0 * motion.load + 1.0) == effect.needs_load
        # The load is the sum of the transmitted torques: one that needed it would need itself.
        assert not (effect.needs_load and effect.transmitted)
        assert changes(temperature=motion.temperature + 1.0) == effect.needs_temperature
        assert changes(acceleration=2.0 * motion.acceleration + 1.0) != effect.massless

    def test_parameters_act_at_their_joint(self, key, robot):
        effect = default(key)
        columns, joints = effect.regressor(robot, known_run(robot)), effect.parameter_joints(robot)
        assert len(joints) == columns.shape[2]
        for column, joint in enumerate(joints):
            if joint is not None and not effect.of_links:  # gravity may not reach the first links
                assert np.any(columns[:, joint, column])

    def test_makes_the_torque_of_the_terms_that_simulators_have(self, key, robot):
        effect, motion = default(key), known_run(robot)
        values = np.arange(1.0, len(effect.parameters(robot)) + 1.0)
        terms = effect.portable(robot, values)
        if isinstance(terms, JointTerms):
            turned = np.tanh(motion.velocity / np.where(terms.dry > 0.0, terms.reversal, 1.0))
            torque = terms.armature * motion.acceleration + terms.damping * motion.velocity
            torque += terms.dry * turned
            torque += terms.stiffness * motion.position + terms.constant
            np.testing.assert_allclose(effect.regressor(robot, motion) @ values, torque, rtol=1e-9, atol=1e-9)

    def test_leaves_the_motion_as_it_is(self, key, robot):
        motion = known_run(robot)
        for field in fields(Motion):
            if field.name != "payload":
                getattr(motion, field.name).setflags(write=False)
        effect = default(key)
        effect.regressor(robot, motion)
        effect.known_torque(robot, motion)
        effect.shape_derivatives(robot, motion)

    def test_stands_motions_faster_than_any_robot(self, key, robot):
        motion = known_run(robot)
        fast = replace(motion, velocity=1e4 * motion.velocity, load=1e6 * motion.load)
        effect = default(key)
        sharp = replace(effect, **{name: shape.low for name, shape in effect.shapes().items()})
        assert np.isfinite(sharp.regressor(robot, fast)).all()
        for derivative in sharp.shape_derivatives(robot, fast).values():
            assert np.isfinite(derivative).all()


@pytest.mark.parametrize(("key", "field"), JOINT_FIELDS)
def test_a_joint_that_is_not_there_is_refused(key, field, robot):
    effect = default(key, **{field: ("joint9",) if field == "joints" else "joint9"})
    with pytest.raises(UnknownJoint, match="joint9.*joint1, joint2"):
        effect.regressor(robot, known_run(robot))


@pytest.mark.parametrize("key", POINTWISE)
def test_a_sample_depends_on_itself_alone(key, robot):
    effect, motion = default(key), known_run(robot)
    whole = effect.regressor(robot, motion)
    for row in (0, 7, len(motion) - 1):
        alone = effect.regressor(robot, motion[row : row + 1])
        np.testing.assert_allclose(alone[0], whole[row], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("key", ON_JOINTS)
def test_named_joints_are_the_same_columns_as_all(key, robot):
    motion = known_run(robot)
    every, some = default(key), default(key, joints=("joint3", "joint1"))
    names = [parameter.name for parameter in every.parameters(robot)]
    columns = [names.index(parameter.name) for parameter in some.parameters(robot)]
    assert {name[-1] for name in np.array(names)[columns]} == {"1", "3"}
    expected = every.regressor(robot, motion)[:, :, columns]
    np.testing.assert_array_equal(some.regressor(robot, motion), expected)


@pytest.mark.parametrize(("key", "name"), SHAPES)
@pytest.mark.parametrize("seed", range(2))
def test_shape_derivative_is_the_finite_difference(key, name, seed, robot):
    motion, random = known_run(robot), np.random.default_rng(seed)
    start = default(key)
    # Any values inside the bounds, and the default at seed 0; over decades where bounds span them.
    for each, shape in start.shapes().items():
        if seed:
            decades = shape.low > 0
            low, high = (np.log(shape.low), np.log(shape.high)) if decades else (shape.low, shape.high)
            drawn = random.uniform(low, high)
            start = replace(start, **{each: float(np.exp(drawn) if decades else drawn)})
    if not start.pointwise:  # what has a memory saturates in strides of a radian
        creep = np.cumsum(random.normal(size=motion.position.shape), axis=0) * 1e-4
        motion = replace(motion, position=creep)
    value = getattr(start, name)
    # Small, because reversals of 1e-4 rad/s make the columns steep; of fourth order, to be exact still.
    step = 1e-6 * abs(value)

    def columns(steps: int) -> np.ndarray:
        return replace(start, **{name: value + steps * step}).regressor(robot, motion)

    numeric = (8 * (columns(1) - columns(-1)) - (columns(2) - columns(-2))) / (12 * step)
    analytic = start.shape_derivatives(robot, motion)[name]
    assert np.abs(analytic).max() > 0.0
    np.testing.assert_allclose(analytic, numeric, rtol=1e-6, atol=1e-6 * np.abs(numeric).max())


def test_all_effects_fit_in_one_model(robot):
    model = Model(robot, tuple(default(key) for key in EFFECTS))
    motion = known_run(robot)
    assert len(set(model.names)) == len(model.names)
    assert model.regressor(motion).shape == (*motion.position.shape, len(model.names))


@pytest.mark.parametrize("key", ON_JOINTS)
def test_a_joint_that_slides_has_units_of_its_own(key):
    robot = sliding()
    turning = {p.name: p.unit for p in default(key).parameters(six_axis())}
    for parameter in default(key).parameters(robot):
        joint = int(parameter.name[-1]) - 1
        if robot.revolute[joint]:
            assert parameter.unit == turning[parameter.name]
        else:
            assert "rad" not in parameter.unit
            assert not parameter.unit.startswith(("N m", "kg m"))
