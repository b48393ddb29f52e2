"""Planning: from wishes to plans that can be run, and one clear error for each wish that cannot be."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.errors import DifferentRobot
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.errors import BadLimits, Infeasible, NothingToIdentify, UnknownChoice
from exidyn.trajectories.limits.check import check
from exidyn.trajectories.limits.usable_limits import usable
from exidyn.trajectories.planning.goals import NOISE, identification_goal, learned, nominal_noise
from exidyn.trajectories.planning.planner import GUESSED, UNSAFE, plan
from exidyn.trajectories.planning.wishes import Wishes, periods_of
from exidyn.trajectories.search.goals import Focus, condition, worst
from exidyn.trajectories.search.torque_bound import TorqueBound

from ...parts.plans.excitation import TICK, core, limits, smooth_model, weak
from ...parts.small import two_joints
from ...parts.small.small_fit import fit, plain_fit

pytestmark = pytest.mark.slow

WISHES = Wishes(harmonics=2, period=4.0, seconds=10.2, tick=TICK, rest=0.5)
BODY = known_parameters(3.0, (0.1, 0.0, 0.05))


def planned(wishes=WISHES, model=None, **options):
    """One start, here."""
    return plan(model or two_joints.model(), wishes, starts=1, seconds=1e6, **options)


def inside(one, model, payloads=("",), kept=None):
    kept = kept or limits()
    bound = TorqueBound(model, kept.torque, payloads)
    for payload in payloads:
        assert not check(one.trajectory, kept, TICK, bound.of(payload))


def test_a_plan_is_a_whole_run_inside_all_limits_and_as_good_as_it_states():
    of = two_joints.model()
    (usual,) = planned(seed=5)
    assert (usual.criterion, usual.seed, usual.tick, usual.payload_pair) == ("condition", 5, TICK, False)
    assert usual.details["goal"] == f"condition number {usual.reached:.4g}"
    assert (usual.details["period"], usual.details["harmonics"]) == (4.0, 2)
    assert usual.margins == vars(WISHES.margins)
    (text,) = usual.assumed
    assert text.startswith("Fv1, Fv2, Fc1, Fc2, Off1, Off2 have no prior")
    inside(usual, of)
    assert (core(usual.trajectory).period, core(usual.trajectory).periods) == (4.0, 2)
    states = usual.trajectory.every(TICK)
    assert not np.any(states.velocity[[0, -1]])
    assert not np.any(states.velocity[: int(0.5 / TICK)])
    assert usual.trajectory.duration / TICK == pytest.approx(round(usual.trajectory.duration / TICK))
    goal = identification_goal(of, WISHES, limits())  # its condition number by numpy
    motion = core(usual.trajectory).at(np.arange(0.0, 4.0, 0.002)).motion()
    rows = of.regressor(motion)[:, :, goal.experiment.base.kept] / goal.experiment.noise[:, None]
    rows = rows.reshape(-1, rows.shape[2])
    assert np.linalg.cond(rows / np.linalg.norm(rows, axis=0)) == pytest.approx(usual.reached, rel=0.02)


@pytest.mark.parametrize("bodies", [(BODY,), (BODY, known_parameters(4.0, (0.15, 0.0, 0.0)))])
def test_a_motion_keeps_to_the_torque_limits_unloaded_and_with_each_body(bodies):
    model = weak((110.0, 60.0))
    kept = usable(model.robot).limits
    wishes = replace(WISHES, bodies=bodies, criterion="volume")
    goal = identification_goal(model, wishes, kept)
    assert goal.payloads == (("", "L") if len(bodies) == 1 else ("", "L1", "L2"))
    assert [name for name in goal.experiment.base.names if name.startswith("gain")] == ["gain1", "gain2"]
    (one,) = planned(wishes, model)
    assert one.payload_pair
    assert "center" not in one.details
    inside(one, goal.model, goal.payloads, kept)
    motion, alone = (
        core(one.trajectory).every(0.01).motion(),
        replace(goal.experiment, payloads=goal.payloads[-1:]),
    )
    assert np.all(np.diag(goal.experiment.information(motion)) >= np.diag(alone.information(motion)))


def test_a_plan_for_a_mass_alone_says_that_the_center_is_a_guess():
    wishes = replace(WISHES, bodies=(BODY, known_parameters(4.0)), criterion="volume")
    (one,) = planned(replace(wishes, period=2.0, harmonics=1))
    assert one.details["bodies"] == f"{dict(BODY)['M']:g} kg, 4 kg"
    assert one.details["center"] == f"{GUESSED} for 4 kg; {UNSAFE}"


def test_a_focus_is_on_what_is_named():
    wishes = replace(WISHES, bodies=(BODY,), focus=("gain", "Fc2"))
    goal = identification_goal(two_joints.model(), wishes, limits())
    assert isinstance(goal.criterion, Focus)
    names = [goal.experiment.base.names[k] for k in goal.criterion.columns]
    assert sorted(names) == ["Fc2", "gain1", "gain2"]
    (one,) = planned(replace(wishes, period=2.0, harmonics=1))
    assert one.criterion == "focus on gain Fc2"
    with pytest.raises(UnknownChoice, match="no base parameter called 'Kr'. Valid: Fc1, Fc2"):
        identification_goal(two_joints.model(), replace(WISHES, focus=("Kr",)), limits())


def test_a_pair_is_planned_for_its_gains_unless_something_else_is_asked():
    pair = replace(WISHES, bodies=(BODY,), period=2.0, harmonics=1)
    goal = identification_goal(two_joints.model(), pair, limits())
    names = [goal.experiment.base.names[k] for k in goal.criterion.columns]
    assert names == ["gain1", "gain2"]
    stated = replace(pair, criterion="condition")
    assert identification_goal(two_joints.model(), stated, limits()).criterion is condition
    (one,) = planned(pair)
    assert one.criterion == "focus on gain"
    motion = core(one.trajectory).at(np.arange(0.0, 2.0, 1e-3)).motion()
    expected = goal.condition_number(motion, limits())
    assert one.details["condition"] == pytest.approx(expected, rel=0.01)


def test_after_a_fit_what_is_known_counts():
    """The nominal torque is that of the fit, and what it knows least comes to matter."""
    of = replace(two_joints.model(), effects=fit().model.effects)
    goal = identification_goal(of, replace(WISHES, fit=fit()), limits())
    names = goal.experiment.base.names
    visible = [name for name in fit().names if not name.endswith("L")]
    assert names == [*visible, "gain1", "gain2"]
    assert goal.criterion is worst
    stated = replace(WISHES, fit=fit(), criterion="condition")
    assert identification_goal(of, stated, limits()).criterion is condition
    assert identification_goal(of, WISHES, limits()).criterion is condition
    covariance = np.linalg.inv(goal.experiment.known)
    np.testing.assert_allclose(
        np.sqrt(np.diag(covariance))[: len(visible)], fit().estimate.std[: len(visible)], rtol=1e-4
    )
    relative = fit().estimate.gain_std / np.abs(fit().estimate.gain)
    np.testing.assert_allclose(np.sqrt(np.diag(covariance))[-2:], relative, rtol=1e-4)
    loaded = identification_goal(two_joints.model(), replace(WISHES, fit=fit(), bodies=(BODY,)), limits())
    assert loaded.experiment.base.names == [*fit().names, "gain1", "gain2"]
    np.testing.assert_allclose(goal.experiment.noise, fit().estimate.noise)
    assert goal.rows == pytest.approx(2.0 * fit().filtering.torque_cutoff * WISHES.seconds)
    twice = identification_goal(of, replace(WISHES, fit=fit(), series=2), limits())
    assert twice.rows == pytest.approx(2 * goal.rows)
    (one,) = planned(replace(WISHES, fit=fit()), of)
    assert one.criterion == "worst"
    inside(one, goal.model)
    objective = goal.objectives(limits(), 0.01)[-1]
    still = core(one.trajectory).scaled(1e-6).at(np.arange(0.0, 4.0, 0.01)).motion()
    assert one.reached < 0.9 * np.exp(objective.value(still))


def test_what_an_unloaded_run_cannot_show_has_the_largest_deviation_in_the_fit():
    """Gains and parameters all larger by a share make the same currents without a known body."""
    of = replace(two_joints.model(), effects=fit().model.effects)
    goal = identification_goal(of, replace(WISHES, fit=fit()), limits())
    motion = core(planned(WISHES)[0].trajectory).at(np.arange(0.0, 4.0, 0.02)).motion()
    (columns,) = goal.experiment.columns(motion)
    count = columns.shape[2] - 2
    larger = np.concatenate([fit().estimate.values[:count], -np.ones(2)])
    assert np.linalg.norm(columns @ larger) < 1e-6 * np.linalg.norm(columns[:, :, -2:])
    smaller = np.concatenate([fit().estimate.values[:count], np.ones(2)])
    known = goal.experiment.known
    assert larger @ known @ larger < 0.1 * smaller @ known @ smaller


def test_a_fit_is_nominal_as_it_was_found():
    of = learned(fit())
    np.testing.assert_allclose(fit().base.regrouping @ of.nominal_values, fit().estimate.values, rtol=1e-9)
    prior = dict(zip(of.names, of.priors, strict=True))
    assert prior["Fc1"].value == pytest.approx(fit().value("Fc1"))
    assert prior["Fc1"].std == pytest.approx(fit().estimate.std[fit().names.index("Fc1")])


def test_a_window_around_the_start_pose_is_kept():
    start = np.array([0.5, -0.4])
    wishes = replace(WISHES, criterion="volume", start=start, window=np.array([0.4, 0.6]))
    (one,) = planned(wishes)
    reached = one.trajectory.extremes().position
    assert np.all(reached.lower >= start - [0.4, 0.6] - 1e-9)
    assert np.all(reached.upper <= start + [0.4, 0.6] + 1e-9)
    assert np.all(reached.upper - reached.lower > 0.2)
    for time in (0.0, one.trajectory.duration):
        np.testing.assert_allclose(one.trajectory.at(np.array([time])).position[0], start, atol=1e-6)


def test_trajectories_planned_together_are_as_many_plans():
    both = planned(replace(WISHES, series=2, harmonics=1, criterion="volume"))
    assert len(both) == 2
    assert not np.allclose(core(both[0].trajectory).sine, core(both[1].trajectory).sine)
    for one in both:
        inside(one, two_joints.model())


@pytest.mark.parametrize("period", [None, 3.3333, 0.0051])
def test_periods_are_whole_ticks(period):
    periods = periods_of(replace(WISHES, seconds=40.0, period=period), limits())
    ticks = np.array(periods) / TICK
    np.testing.assert_allclose(ticks, np.round(ticks), atol=1e-9)
    across = np.max(2 * limits().position_upper / limits().velocity)
    assert periods == pytest.approx(
        (4 * across, 3 * across) if period is None else (period,), rel=0.1, abs=TICK
    )


def test_in_a_narrow_window_it_is_acceleration_that_makes_a_period_long():
    narrow = replace(limits(), position_lower=np.full(2, -0.01), position_upper=np.full(2, 0.01))
    slowest = min(periods_of(replace(WISHES, period=None), narrow))
    assert 0.01 * (2 * np.pi / slowest) ** 2 <= 2.5 * np.max(narrow.acceleration)
    assert 2.0 * 0.02 / np.max(narrow.velocity) < slowest


@pytest.mark.parametrize(("seconds", "period", "periods"), [(6.2, 4.0, 1), (10.2, 4.0, 2), (6.2, None, 1)])
def test_a_run_takes_the_time_that_was_asked_for(seconds, period, periods):
    wishes = replace(WISHES, seconds=seconds, period=period)
    (one,) = plan(two_joints.model(), wishes, starts=1, seconds=1e-3)
    assert one.trajectory.duration == pytest.approx(seconds, abs=1e-9)
    assert core(one.trajectory).periods == periods


def test_noise_is_a_share_of_the_torque():
    of = two_joints.model()
    still = np.zeros((1, 2))  # stretched out, as heavy as it gets
    rest = replace(two_joints.motion(1), position=still, velocity=still, acceleration=still)
    holding, noise = np.abs(of.torque(of.loaded(rest), of.nominal_values))[0], nominal_noise(of, limits())
    assert np.all((0.1 * NOISE * holding < noise) & (noise < 3 * NOISE * holding))
    heavier = replace(of.robot, kinematics=of.robot.kinematics.copy())
    for joint in (1, 2):
        link = of.robot.kinematics.inertias[joint]
        heavier.kinematics.inertias[joint] = type(link)(3 * link.mass, link.lever, 3 * link.inertia)
    np.testing.assert_allclose(nominal_noise(replace(of, robot=heavier), limits()), 3 * noise, rtol=1e-9)
    unknown = Model(two_joints.arm(), smooth_model().effects[1:])  # without priors
    np.testing.assert_array_equal(nominal_noise(unknown, limits()), [1.0, 1.0])


def limited(kind, value):
    """The arm with another limit of its elbow."""
    of, robot = two_joints.model(), two_joints.arm()
    wrong = np.where([False, True], value, getattr(robot.limits, kind))
    return replace(of, robot=replace(robot, limits=replace(robot.limits, **{kind: wrong})))


@pytest.mark.parametrize(
    ("model", "wishes", "error", "message"),
    [
        ("kr270", {"fit": fit()}, DifferentRobot, r"the fit is of two joints \(joints shoulder, elbow\)"),
        (None, {"fit": plain_fit(), "bodies": (BODY,)}, NothingToIdentify, "no information on a payload"),
        (
            None,
            {"fit": fit(), "shapes": ("coulomb_friction",)},
            NothingToIdentify,
            "no information on shapes",
        ),
        (None, {"seconds": 6.0}, BadLimits, "length: 6 s; the shortest possible is 6.2 s: one period of 4 s"),
        (None, {"criterion": "best"}, UnknownChoice, "called 'best'. Valid: average, condition, volume"),
        (None, {"start": np.array([0.0, 3.0])}, Infeasible, "elbow: start 3 is outside"),
        (limited("jerk", 0.0), {}, BadLimits, "elbow: .*jerk limit 0"),
        (limited("torque", np.nan), {}, BadLimits, "elbow: .*torque limit nan"),
        (Model(two_joints.arm(), ()), {}, NothingToIdentify, "two joints: the model has no effects"),
        (Model(two_joints.arm(), (Payload("L"),)), {}, NothingToIdentify, "no parameter .* makes any torque"),
    ],
)
def test_what_cannot_be_planned_is_refused_in_one_sentence(model, wishes, error, message):
    of = read_model(model) if isinstance(model, str) else model
    with pytest.raises(error, match=message):
        planned(replace(WISHES, **wishes), of)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"tick": 0.0}, "tick: 0 s"),
        ({"period": np.nan}, "period: nan s"),
        ({"seconds": -3.0}, "length: -3 s"),
        ({"rest": -1.0}, "rest: -1 s"),
        ({"harmonics": 0}, "harmonics: 0"),
        ({"series": 0}, "trajectories: 0"),
        ({"sure": -0.1}, "sure: -0.1; it is a share of arms"),
        ({"sure": 1.0}, "sure: 1; it is a share of arms"),
    ],
)
def test_wishes_that_make_no_sense_are_refused(wrong, words):
    with pytest.raises(BadLimits, match=words):
        replace(WISHES, **wrong)
