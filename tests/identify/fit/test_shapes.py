"""Shapes of friction found in a simulated run, and the shortcuts on the way there."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.effects import CoulombFriction, Hysteresis
from exidyn.identification.errors import RobotError
from exidyn.identification.fit.base_parameters import base_parameters
from exidyn.identification.fit.equations import assemble
from exidyn.identification.fit.estimators.compressed import Compressed
from exidyn.identification.fit.shapes import fit_shapes
from exidyn.identification.preparation.prepare import Filtering, Prepared, prepare

from ...parts.small.two_joints import model, true_values
from .test_identify import record

pytestmark = pytest.mark.numerical

FILTERING = Filtering(position_cutoff=20.0, torque_cutoff=10.0)
PRESLIDING = (2e-3, 8e-3)
"""True displacements of the two joints [rad]."""


def presliding_model(first: float, second: float):
    laws = [Hysteresis(("shoulder",), first), Hysteresis(("elbow",), second)]
    others = [effect for effect in model().effects if not isinstance(effect, CoulombFriction)]
    return replace(model(), effects=(*others, *laws))


@pytest.fixture(scope="module")
def run() -> Prepared:
    """A run whose currents are those of a model with presliding."""
    prepared = prepare(record(), FILTERING)
    plant = presliding_model(*PRESLIDING)
    values = true_values(plant)
    values[[plant.names.index("Fh1"), plant.names.index("Fh2")]] = 4.0, 2.0
    torque = plant.torque(prepared.motion, values)
    noise = np.random.default_rng(0).normal(size=torque.shape) * 0.05
    return replace(prepared, current=(torque + noise) / prepared.gain)


def test_each_joint_gets_its_own_presliding(run):
    others = tuple(effect for effect in model().effects if not isinstance(effect, CoulombFriction))
    text = []
    fitted = fit_shapes(replace(model(), effects=(*others, Hysteresis())), [run], ["hysteresis"], text.append)
    found = [effect.presliding for effect in fitted.effects if isinstance(effect, Hysteresis)]
    np.testing.assert_allclose(found, PRESLIDING, rtol=0.2)
    assert len(text) == 2
    assert "elbow" in text[1]


@pytest.mark.parametrize("name", ["hysteresis", "viscous_friction", "nonsense"])
def test_only_an_effect_of_the_model_with_shapes_can_be_fitted(run, name):
    with pytest.raises(RobotError, match=rf"no effect '{name}'.* are: coulomb_friction$"):
        fit_shapes(model(), [run], [name])


def test_shapes_of_coupled_motors_follow_from_the_motors_torques(run):
    """The elbow's friction is on both motors where the shoulder's also turns with the elbow."""
    coupled = replace(model().robot, coupling=np.array([[1.0, 0.8], [0.0, 1.0]]))
    plant = replace(presliding_model(*PRESLIDING), robot=coupled)
    torque = run.current * run.gain @ coupled.to_motors.T
    start = replace(presliding_model(3e-4, 3e-4), robot=coupled)
    fitted = fit_shapes(start, [replace(run, current=torque / run.gain)], ["hysteresis"])
    found = [effect.presliding for effect in fitted.effects if isinstance(effect, Hysteresis)]
    np.testing.assert_allclose(found, PRESLIDING, rtol=0.2)
    assert [type(effect) for effect in fitted.effects] == [type(effect) for effect in plant.effects]


def test_factors_formed_again_are_those_of_the_changed_equations(run):
    of = presliding_model(*PRESLIDING)
    before = assemble(of, base_parameters(of), [run])
    regressor = before.regressor.copy()
    regressor[:, 1] *= 1.5
    after = replace(before, regressor=regressor)
    expected, found = Compressed.of(after), Compressed.of(before).updated(after, [1])
    for mine, theirs in zip(found.factors, expected.factors, strict=True):
        np.testing.assert_array_equal(mine, theirs)


def test_presliding_is_dahl_s_law_step_by_step():
    random = np.random.default_rng(0)
    position = np.cumsum(random.normal(size=400)) * 1e-3
    position[100:150] = position[100]  # stands still for a while
    state, expected = 0.0, []
    for step in np.diff(position, prepend=position[0]):
        sign = np.sign(step)
        state = sign + (state - sign) * np.exp(-abs(step) / 2e-3) if sign else state
        expected.append(state)
    both = np.stack([position, np.zeros_like(position)], axis=1)
    motion = Motion.of(np.arange(len(position)) * 0.01, both, both, both)
    found = Hysteresis(("shoulder",), 2e-3).regressor(model().robot, motion)
    np.testing.assert_allclose(found[:, 0, 0], expected, atol=1e-12)
    assert not found[:, 1].any()
