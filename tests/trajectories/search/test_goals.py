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
from exidyn.trajectories.search.criteria import CRITERIA, Focus, average, condition, volume, worst
from exidyn.trajectories.search.experiment import Experiment
from exidyn.trajectories.search.goals import Identify
from exidyn.trajectories.search.unknowns import (
    WIDEST,
    DriveGains,
    ShapesOf,
    design_model,
    with_drive_gains,
    with_shapes,
)

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
    assert [name for name in alone if name.startswith("gain")] == ["gain1R"]
    assert [name for name in pair if name.startswith("gain")] == ["gain1", "gain2"]


def test_gains_are_nominal_as_the_robot_states():
    robot = replace(two_joints.arm(), drive_gain_tolerance=0.03)
    priors = DriveGains(Model(robot, (RigidBody(),))).priors(robot)
    assert priors == {"gain1": Prior(0.0, 0.03), "gain2": Prior(0.0, 0.03)}


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
    assert with_shapes(of, ["stribeck_friction"]).names == [*of.names, "fade_Fs2", "reversal_Fs2"]
    assert with_shapes(of, ["coulomb_friction"]).names == [*of.names, "reversal_Fc1", "reversal_Fc2"]


@pytest.mark.parametrize("key", ["load_dependent_friction", "viscous_friction", "nonsense"])
def test_shapes_that_the_model_does_not_have_are_reported(key):
    with pytest.raises(UnknownChoice, match=f"'{key}'. Valid: coulomb_friction, stribeck_friction$"):
        with_shapes(shaped(0.3, ("elbow",)), [key])


def test_shapes_that_need_the_load_get_it():
    of = replace(smooth_model(LoadDependentFriction()), stated={"mu1": Prior(0.1), "mu2": Prior(0.1)})
    effect = with_shapes(of, ["load_dependent_friction"]).effects[-1]
    assert isinstance(effect, ShapesOf)
    assert effect.needs_load


def test_friction_turns_over_what_a_sample_covers():
    """Acceleration limit 11.4 rad/s^2: half of it for a two hundredth of a second is 0.0285 rad/s."""
    of = Model(two_joints.arm(), (RigidBody(), CoulombFriction(reversal=0.003)))
    assert design_model(of, limits(), 0.005).effects[1].reversal == pytest.approx(0.0285)
    assert design_model(of, limits(), 1e-5).effects[1].reversal == 0.003
    assert design_model(of, limits(), 10.0).effects[1].reversal == WIDEST
    assert design_model(of, limits(), 10.0).effects[0] == RigidBody()
    assert design_model(of, limits(), 1e-5).robot is of.robot


def test_friction_within_an_effect_turns_with_it():
    """Else a gain would seem to be known from the difference between the two."""
    of = with_drive_gains(with_shapes(two_joints.model(), ["coulomb_friction"]))
    gains, shapes = of.effects[-1], next(e for e in of.effects if isinstance(e, ShapesOf))
    seen = design_model(of, limits(), 0.005)
    assert seen.effects[-1].model.effects[2].reversal == pytest.approx(0.0285)
    assert next(e for e in seen.effects if isinstance(e, ShapesOf)).effect.reversal == pytest.approx(0.0285)
    assert gains.model.effects[2].reversal == shapes.effect.reversal < 0.0285


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


def test_without_a_spacing_friction_is_as_stated():
    of = with_drive_gains(two_joints.model())
    assert design_model(of, limits(), 0.0).effects[:-1] == of.effects[:-1]
    assert design_model(of, limits(), 0.0).effects[-1].model.effects == of.effects[-1].model.effects


def test_a_joint_that_creeps_makes_the_condition_number_worse():
    """With all columns scaled to one, a joint at 3 % of its speed would change it from 1.9 to 2.5 only."""
    of = goal(rows=7.0)
    at = motion(samples=400)
    creeping = Motion.of(
        at.time, at.position, at.velocity * np.array([1.0, 0.03]), at.acceleration * np.array([1.0, 0.03])
    )
    objective = of.objectives(limits(), 0.0)[-1]
    assert objective.value(creeping) > objective.value(at) + np.log(2.0)


def test_friction_that_turns_more_gradually_stays_as_it_is():
    of = smooth_model()
    assert design_model(of, limits(), 0.001).effects == of.effects


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
    smooth = of.objectives(limits(), 0.005)[0].experiment.model
    assert smooth.effects[2].reversal == pytest.approx(0.0285)
    assert of.experiment.model.effects[2].reversal == two_joints.model().effects[2].reversal
    assert of.model is of.nominal
    plain = goal()
    assert plain.model is plain.experiment.model


def test_sizes_are_of_nominal_values():
    """Regrouped ones with all that is regrouped into them: elbow's mass at 0.4 m."""
    experiment = Experiment.of(nominal())
    size = dict(zip(experiment.base.names, experiment.sizes, strict=True))
    prior = dict(zip(experiment.model.names, experiment.model.priors, strict=True))
    assert size["Fc1"] == pytest.approx(np.hypot(4.0, 1.0))
    assert size["MX2"] == pytest.approx(np.hypot(*prior["MX2"]))
    deviation = np.hypot(prior["MX1"].std, 0.4 * prior["M2"].std)
    assert size["MX1R"] == pytest.approx(np.hypot(prior["MX1"].value + 0.4 * prior["M2"].value, deviation))


def test_what_has_no_prior_has_the_size_of_the_noise():
    """A deviation of one is then one noise of torque."""
    noise = np.array([0.3, 0.7])
    experiment = Experiment.of(smooth_model(), noise=noise)
    size = dict(zip(experiment.base.names, experiment.sizes, strict=True))
    assert size["Off2"] == pytest.approx(0.7)
    assert size["Fc1"] == pytest.approx(0.3, rel=0.05)
    assert np.all(np.isfinite(list(size.values())))
    assert min(size.values()) > 0


def test_words_name_the_criterion():
    text = {name: goal(criterion=c).words(np.log(2.5)) for name, c in CRITERIA.items()}
    assert text == {
        "condition": "condition number 2.5",
        "volume": "mean relative standard deviation 2.5",
        "average": "root mean square relative standard deviation 2.5",
        "worst": "worst relative standard deviation 2.5",
    }
    assert (
        goal(criterion=Focus((1,))).words(0.0)
        == "mean relative standard deviation of the parameters in focus 1"
    )


def test_payloads_are_those_of_the_experiment():
    of = Identify(Experiment.of(nominal(Payload("L", BODY)), ("", "L")), worst)
    assert of.payloads == ("", "L")
    assert {average, worst} < set(CRITERIA.values())
