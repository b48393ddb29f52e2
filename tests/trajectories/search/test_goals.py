"""Goals: what is asked of a motion, unknowns beyond the parameters, and friction as an optimiser sees it."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.effects import (
    CoulombFriction,
    LoadDependentFriction,
    Payload,
    Prior,
    RigidBody,
    StribeckFriction,
    known_parameters,
)
from exidyn.identification.model import Model
from exidyn.trajectories.errors import UnknownChoice
from exidyn.trajectories.search.experiment import (
    WIDEST,
    DriveGains,
    Experiment,
    design_model,
    with_drive_gains,
    with_shapes,
)
from exidyn.trajectories.search.goals import CRITERIA, Identify, condition, volume

from ...parts.plans.excitation import goal, limits, smooth_model
from ...parts.runs.robots import random_motion
from ...parts.small import two_joints

BODY = known_parameters(3.0, (0.1, 0.0, 0.05))
FRICTION = {
    "mu1": Prior(0.1),
    "mu2": Prior(0.2),
    "Fc1": Prior(4.0, 1.0),
    "Fc2": Prior(2.0),
    "Fv1": Prior(3.0),
    "Fv2": Prior(1.5),
}


def nominal(*more):
    return replace(smooth_model(*more), stated=FRICTION)


def motion(payload="", samples=20):
    return random_motion(two_joints.arm(), samples, payload=payload)


@pytest.mark.parametrize("payload", ["", "L"])
def test_a_gain_is_the_torque_that_flows_through_it(payload):
    """What changes when all currents of one drive are read one per cent larger."""
    of = nominal(LoadDependentFriction(), Payload("L", BODY))
    at = motion(payload)
    torque = of.torque(of.loaded(at), of.nominal_values)
    columns = DriveGains(of).regressor(of.robot, at)
    assert columns.shape == (20, 2, 2)
    np.testing.assert_allclose(columns.sum(axis=2), torque)
    assert not np.any(columns[:, 0, 1])
    assert not np.any(columns[:, 1, 0])


def test_all_gains_are_reported_by_a_pair_alone():
    """Without a known body, all of them scaled together are all parameters scaled: one is regrouped."""
    of = with_drive_gains(nominal(Payload("L", BODY)))
    alone, pair = (Experiment.of(of, payloads).base.names for payloads in ([""], ["", "L"]))
    robot = replace(two_joints.arm(), drive_gain_tolerance=0.03)
    assert DriveGains(Model(robot, (RigidBody(),))).priors(robot)["gain1"] == Prior(0.0, 0.03)
    assert [name for name in alone if name.startswith("gain")] == ["gain1R"]
    assert [name for name in pair if name.startswith("gain")] == ["gain1", "gain2"]


def shaped(fade, joints=None):
    effect = StribeckFriction(joints, fade=fade, reversal=0.08)
    return replace(smooth_model(effect), stated=FRICTION | {"Fs1": Prior(3.0), "Fs2": Prior(5.0)})


def test_shapes_are_columns_of_the_derivative_joint_by_joint():
    of, step, at = shaped(0.3), 1e-6, motion()
    columns = with_shapes(of, ["stribeck_friction"])
    names = columns.names[len(of.names) :]
    assert names == ["fade_Fs1", "reversal_Fs1", "fade_Fs2", "reversal_Fs2"]
    torques = [shaped(0.3 + side * step).torque(at, of.nominal_values) for side in (1, -1)]
    expected = (torques[0] - torques[1]) / (2 * step)
    found = columns.regressor(at)[:, :, len(of.names) :]
    np.testing.assert_allclose(found[:, :, 0] + found[:, :, 2], expected, atol=1e-7)
    assert not np.any(found[:, 1, :2])
    assert not np.any(found[:, 0, 2:])
    assert np.any(found[:, 0, 0])
    assert np.any(found[:, 1, 2])


def test_shapes_of_effects_that_were_not_named_stay_known():
    of = shaped(0.3, ("elbow",))
    assert with_shapes(of, []) == of
    loaded = nominal(LoadDependentFriction())
    assert with_shapes(loaded, ["load_dependent_friction"]).effects[-1].needs_load
    assert with_shapes(of, ["stribeck_friction"]).names == [*of.names, "fade_Fs2", "reversal_Fs2"]
    assert with_shapes(of, ["coulomb_friction"]).names == [*of.names, "reversal_Fc1", "reversal_Fc2"]
    for key in ("load_dependent_friction", "viscous_friction", "nonsense"):
        with pytest.raises(UnknownChoice, match=f"'{key}'. Valid: coulomb_friction, stribeck_friction$"):
            with_shapes(of, [key])


def test_friction_turns_over_what_a_sample_covers_within_an_effect_too():
    """Acceleration limit 11.4 rad/s^2: half of it for a two hundredth of a second is 0.0285 rad/s."""
    of = Model(two_joints.arm(), (RigidBody(), CoulombFriction(reversal=0.003)))
    for spacing, expected in ((0.005, 0.0285), (1e-5, 0.003), (10.0, WIDEST), (0.0, 0.003)):
        assert design_model(of, limits(), spacing).effects[1].reversal == pytest.approx(expected)
    assert design_model(of, limits(), 10.0).effects[0] == RigidBody()
    of = with_drive_gains(with_shapes(of, ["coulomb_friction"]))
    *_, shapes, gains = design_model(of, limits(), 0.005).effects
    assert gains.model.effects[1].reversal == shapes.effect.reversal == pytest.approx(0.0285)
    assert of.effects[-1].model.effects[1].reversal == of.effects[-2].effect.reversal == 0.003


def test_a_gain_is_known_as_well_however_gradual_friction_is():
    """Its column without what the others explain of it is what the known payload makes, and no friction."""
    loaded = replace(two_joints.model(Payload("L", two_joints.MASS)), stated=FRICTION)
    of = Experiment.of(with_drive_gains(loaded), payloads=("", "L"))
    at, place = motion(samples=400), list(of.base.names).index("gain1")

    def left(spacing):
        (objective,) = Identify(of, criterion=volume).objectives(limits(), spacing)
        columns = np.concatenate(objective.experiment.columns(at)).reshape(-1, len(of.base.names))
        others = np.delete(columns, place, axis=1)
        fit = np.linalg.lstsq(others, columns[:, place], rcond=None)[0]
        return np.linalg.norm(columns[:, place] - others @ fit)

    assert left(0.005) == pytest.approx(left(1e-5), rel=0.02)


def test_a_joint_that_creeps_makes_the_condition_number_worse():
    """With all columns scaled to one, a joint at 3 % of its speed would change it from 1.9 to 2.5 only."""
    of = goal(rows=7.0)
    at = motion(samples=400)
    creeping = Motion.of(
        at.time, at.position, at.velocity * np.array([1.0, 0.03]), at.acceleration * np.array([1.0, 0.03])
    )
    objective = of.objectives(limits(), 0.0)[-1]
    assert objective.value(creeping) > objective.value(at) + np.log(2.0)


@pytest.mark.parametrize("criterion", CRITERIA.values(), ids=CRITERIA.keys())
def test_the_goal_itself_is_the_last_objective(criterion):
    """What comes before is smoother, and for the condition number never below it."""
    objectives = goal(criterion=criterion, rows=7.0).objectives(limits(), 0.01)
    assert objectives[-1].criterion is criterion
    assert [objective.criterion for objective in objectives[:-1]].count(criterion) == 0
    assert all(objective.rows == 7.0 for objective in objectives)
    if criterion is condition:
        values = [objective.value(motion()) for objective in objectives]
        assert len(values) > 1
        assert values[0] > values[-1]
        assert min(values[:-1]) >= values[-1] - 1e-12


def test_objectives_see_gradual_friction_and_the_torque_limit_the_nominal_one():
    of = goal(two_joints.model(), nominal=smooth_model())
    assert of.objectives(limits(), 0.005)[0].experiment.model.effects[2].reversal == pytest.approx(0.0285)
    assert of.model is of.nominal


def test_sizes_are_of_nominal_values():
    """Regrouped ones with all that is regrouped into them: elbow's mass at 0.4 m."""
    experiment = Experiment.of(nominal())
    size = dict(zip(experiment.base.names, experiment.sizes, strict=True))
    prior = dict(zip(experiment.model.names, experiment.model.priors, strict=True))
    assert size["Fc1"] == pytest.approx(np.hypot(4.0, 1.0))
    assert size["MX2"] == pytest.approx(np.hypot(*prior["MX2"]))
    deviation = np.hypot(prior["MX1"].std, 0.4 * prior["M2"].std)
    assert size["MX1R"] == pytest.approx(np.hypot(prior["MX1"].value + 0.4 * prior["M2"].value, deviation))
    experiment = Experiment.of(smooth_model(), noise=np.array([0.3, 0.7]))
    size = dict(zip(experiment.base.names, experiment.sizes, strict=True))
    assert size["Off2"] == pytest.approx(0.7)  # without a prior, a deviation of one is one noise of torque
    assert size["Fc1"] == pytest.approx(0.3, rel=0.05)
    assert np.all(np.isfinite(list(size.values())))
