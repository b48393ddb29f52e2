"""What a search names on a two-joint arm, and what it takes to be named."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from exidyn.identification.diagnosis.candidates import KINDS, contact_event, hypotheses
from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.questions.block_answer import CREDIBLE, Answer, against_all
from exidyn.identification.diagnosis.questions.candidate import Candidate, Thinned
from exidyn.identification.diagnosis.questions.comparison import better, by_blocks, competing
from exidyn.identification.diagnosis.questions.question import ask
from exidyn.identification.diagnosis.questions.shape import refined, with_shape
from exidyn.identification.diagnosis.results.evidence import deviations, places_of
from exidyn.identification.diagnosis.runs.rows import CLOCK
from exidyn.identification.diagnosis.search import additions, once, search, selected
from exidyn.identification.diagnosis.search.once import moments
from exidyn.identification.diagnosis.search.ranking import _by_hypothesis, total_prior
from exidyn.identification.diagnosis.search.selected import (
    Selected,
    contradicted,
    keys_of,
    log_prior,
    odds_of,
)
from exidyn.identification.effects import LoadDependentFriction
from exidyn.identification.recordings.recording import Signal
from exidyn.identification.text_table import NORMAL_95

from ...parts.small import two_joints
from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import (
    SOFT,
    SPRING,
    alone,
    drag_and_spring_search,
    drag_search,
    names,
    problem,
    record,
    searched,
    sound_problem,
    spring_search,
)

pytestmark = [pytest.mark.numerical, pytest.mark.slow]

BLOCKS = 20


def answer(gains, effect="something", joints=(0,), rows=None, held_out=0, **more):
    """With a gain (n,) on each joint, spread over all blocks evenly."""
    acting = np.array(joints if rows is None else rows)
    candidate = Candidate(effect, tuple(joints), lambda run: run, ("size",), ("N m",), (-np.inf,), **more)
    columns = Thinned(acting, np.ones((BLOCKS, len(acting), 1)), np.ones(1), np.zeros(1))
    whole = np.ones((BLOCKS, len(gains)))
    along = np.linspace(90.0, 110.0, BLOCKS)
    return Answer(
        candidate, columns, np.ones(1), np.ones(1, bool), whole, whole, along, np.full(BLOCKS, 100.0),
        whole * np.array(gains) / BLOCKS, np.ones(len(gains)), np.arange(BLOCKS) < BLOCKS - held_out,
    )  # fmt: skip


def judged(best, total):
    """As of blocks that leave no doubt which of two they have."""
    return selected.most_probable(best, total, lambda one, other: np.sign(one.gain - other.gain) * 1e3)


def sizes(found):
    """Values and deviations of each finding's first coefficient."""
    spread = deviations(found)
    return [
        (found.prediction.values[places_of(found, place)][0], spread[place][0][0])
        for place in range(len(found.selected))
    ]


def test_one_effect_that_is_missing_is_named_first_with_its_size():
    found = spring_search()
    assert names(found) == [("joint_spring", (1,))]
    assert alone(found)[0].candidate.effect == "joint_spring"
    assert found.selected[0].probability > CREDIBLE
    [(value, std)] = sizes(found)
    assert abs(value - SOFT["Ks2"]) < 3 * std < 0.2


def test_two_effects_at_once_are_both_named():
    found = searched(record([SPRING, LoadDependentFriction(("shoulder",))], SOFT | {"mu1": 0.08}))
    assert set(names(found)) == {("joint_spring", (1,)), ("load_dependent_friction", (0,))}
    truth = {"joint_spring": SOFT["Ks2"], "load_dependent_friction": 0.08}
    for one, (value, std) in zip(found.selected, sizes(found), strict=True):
        # Either formula may be wrong by a tenth.
        assert abs(value - truth[one.answer.candidate.effect]) < 3 * std < 0.3 * value


def relief_of_drag(deviations):
    """Of viscous friction at the elbow, so many standard deviations from what is stated, (1.425 ± 0.3)."""
    at = problem(record([], {"Fv2": 1.425 + 0.3 * deviations}))
    [drag] = [pair for pair in at.candidates if pair[0].key == ("viscous_friction", (1,), "")]
    [answer] = ask(at.prediction([]), [drag])
    return answer.relief


def test_priors_that_are_right_are_no_evidence_against_themselves():
    # All quantiles of a normal prior are as likely: a relief without its optimism would be positive.
    reliefs = [relief_of_drag(norm.ppf((k + 0.5) / 3)) for k in range(3)]
    assert -1.0 < np.mean(reliefs) < -0.3
    assert relief_of_drag(6.0) > 4.0


def test_nothing_is_named_that_is_not_there_or_not_in_the_runs_held_out():
    found = searched(record())
    assert names(found) == []
    assert all(odds_of(one, total_prior(found.problem)) < 1.0 for one in alone(found))
    assert names(searched(record([SPRING], SOFT, only="identify"))) == []


FORCE = np.array([25.0, 0.0, -15.0])


def pushed(role, motion, current):
    """The current of a run held out in which something pushes for a second."""
    if role != "validate":
        return current
    push = contact_event.share(motion.time, 3.0, 1.0)
    return (
        current
        - np.einsum("tnk,k->tn", contact_event.jacobian(nominal_model(), motion), FORCE)
        * push[:, None]
        / two_joints.GAIN
    )


@pytest.fixture(scope="module")
def pushed_problem():
    return problem(record(change=pushed))


def test_a_push_in_the_run_held_out_is_a_contact_and_a_moment(pushed_problem):
    at = pushed_problem
    found = search.search(at)
    assert names(found) == [("contact_event", ())]
    assert found.selected[0].once
    force, [(std, _)] = found.prediction.values[places_of(found, 0)], deviations(found)
    assert np.all(np.abs(force - FORCE)[[0, 2]] < NORMAL_95 * std[[0, 2]])
    assert np.all(std[[0, 2]] < 0.2 * np.linalg.norm(FORCE))
    values = found.selected[0].answer.candidate.reported
    assert values["start"][0] == pytest.approx(3.0, abs=0.3)
    [moment] = moments(at, at.prediction([]))
    assert (moment.run, moment.joints) == ("validate2", (0, 1))
    assert moment.start < 3.5 < moment.end
    assert moment.force == pytest.approx(np.linalg.norm(FORCE), rel=0.35)
    assert moment.direction @ FORCE / np.linalg.norm(FORCE) > 0.98


def test_a_push_of_less_than_the_sensors_error_of_the_usual_torque_is_no_contact(pushed_problem, monkeypatch):
    at = pushed_problem
    selected = once.with_contacts(at, [])[1]
    assert [one.answer.candidate.effect for one in selected] == ["contact_event"]
    monkeypatch.setattr(once, "LINEAR", 1.0)  # sensors as wrong as their joints' usual torque
    assert once.with_contacts(at, []) == (at, [])


def late(seconds, joints):
    """Currents of some drives that are recorded later."""

    def change(role, motion, current):
        moved = [np.interp(motion.time - seconds, motion.time, column) for column in current.T]
        return np.where(np.isin(np.arange(current.shape[1]), joints), np.stack(moved, axis=1), current)

    return change


def test_clocks_and_delays_have_the_sign_of_what_comes_late():
    at = problem(record(change=late(0.004, (0, 1))))
    prediction = at.prediction([])
    values = dict(zip(prediction.rows.names, prediction.values, strict=True))
    # Delays of all clocks and of one drive add.
    assert values[CLOCK] > 0.0
    assert values[CLOCK] + values[f"{CLOCK}1"] == pytest.approx(0.004, rel=0.2)
    run = at.runs[0]
    for candidate in hypotheses("time_delay", at.model):
        column, acting = candidate.columns(run)[:, :, 0], list(candidate.rows or (0, 1))
        if abs(candidate.shape["delay"]) == pytest.approx(0.004):
            tick = round(candidate.shape["delay"] / 0.004)
            torque = run.prepared.gain * run.prepared.current
            later = torque - np.roll(torque, -tick, axis=0)
            # Beyond the ends of a run nothing was recorded.
            np.testing.assert_allclose(column[5:-5, acting], later[5:-5, acting])


def test_a_torque_that_was_recorded_has_no_gain():
    runs = [(role, as_torque(run)) for role, run in record(roles=("identify", "validate"))]
    at = problem(runs)
    assert {"joint_spring", "encoder_offset", "time_delay"} <= set(at.tried)
    assert not {"drive_gain", "drive_gain_saturation"} & set(at.tried)
    assert not any(name.startswith("gain") for name in at.rows.names)
    assert {"drive_gain", "drive_gain_saturation"} <= set(sound_problem().tried)


def as_torque(run):
    current = run.signals["current"]
    signals = {name: signal for name, signal in run.signals.items() if name != "current"}
    return replace(run, signals={**signals, "torque": Signal(current.time, current.values * two_joints.GAIN)})


def test_inertias_not_given_may_be_anything_and_others_no_more_than_their_tolerance():
    stated = nominal_model()
    unstated = replace(stated, robot=replace(stated.robot, inertias_stated=False))
    values = dict(zip(stated.names, stated.nominal_values, strict=True))
    heavier = {name: 1.3 * values[name] for name in ("M2", "MX2", "MZ2", "YY2")}
    found = searched(record(values=heavier))
    # On the last link both are the same body: one finding, and neither is an alternative of the other.
    assert set(names(found)) <= {("payload", ()), ("link_inertia", (1,))}
    [one] = found.selected
    assert {one.answer.candidate.effect, *(other.candidate.effect for other, _ in one.others)} >= {
        "payload",
        "link_inertia",
    }
    assert one.probability < one.certainty
    assert one.certainty > 0.99
    assert not {"payload", "link_inertia"} & {other.candidate.effect for other, _ in one.elsewhere}
    places = places_of(found, 0)
    mass = found.prediction.values[places[0]]
    assert mass == pytest.approx(0.3 * values["M2"], rel=0.1)
    assert names(searched(record(values=heavier, model=unstated), unstated)) == []


def test_a_payload_is_told_from_the_last_link_by_the_runs_that_have_it():
    at = sound_problem(2)
    run, other = at.runs
    loaded = replace(other, motion=replace(other.motion, payload="tool"))
    ask = KINDS["payload"].ask_first
    assert list(ask(at.model, at.without_findings, at.runs)) == []
    [candidate] = ask(at.model, at.without_findings, (run, loaded))
    [everywhere] = hypotheses("payload", at.model)
    np.testing.assert_allclose(candidate.columns(run), everywhere.columns(run))
    assert not np.any(candidate.columns(loaded))
    assert np.any(everywhere.columns(loaded))
    links = [one for one in hypotheses("link_inertia", at.model) if one.same_torque is not None]
    assert [one.joints for one in links] == [(1,)]
    assert links[0].same_torque == everywhere.same_torque
    assert candidate.same_torque is None
    assert candidate.key != everywhere.key


def test_a_drive_gain_beyond_its_tolerance_is_named_and_one_within_is_not():
    def stronger(share):
        return record(change=lambda role, motion, current: current / np.array([1.0, 1.0 + share]))

    [finding] = diagnose(nominal_model(), stronger(0.15), "gain").findings
    assert (finding.effect, finding.joints) == ("drive_gain", (1,))
    assert finding.parameters["share"].value == pytest.approx(0.15, abs=0.02)
    assert names(searched(stronger(0.02))) == []


@pytest.mark.parametrize(("seconds", "drives"), [(0.012, ()), (-0.008, (0,))])
def test_a_delay_is_as_long_as_it_is(seconds, drives):
    found = searched(record(change=late(seconds, drives or (0, 1))))
    assert names(found) == [("time_delay", drives)]
    assert found.selected[0].answer.candidate.shape["delay"] == pytest.approx(seconds, abs=2.5e-4)


def test_drives_of_almost_one_delay_have_it_in_common_each_with_its_deviation():
    def change(role, motion, current):
        moved = [np.interp(motion.time - d, motion.time, c) for d, c in zip(LATE, current.T, strict=True)]
        return np.stack(moved, axis=1)

    found = searched(record(change=change))
    assert names(found) == [("time_delay", ())]
    common = found.selected[0].answer.candidate.shape["delay"]
    own = found.prediction.values[places_of(found, 0)][1:]
    np.testing.assert_allclose(common + own - own.mean(), LATE, atol=1e-3)


LATE = np.array([0.024, 0.031])
"""Delays of two drives [s]."""


def test_a_single_motor_has_no_delay_in_common_with_a_passive_joint():
    model = nominal_model()
    alone = replace(model, robot=replace(model.robot, passive=("shoulder",)))
    every = {candidate.joints for candidate in hypotheses("time_delay", alone)}
    assert every == {(1,)}


# What it takes to be named.


def test_of_all_hypotheses_together_one_is_as_likely_as_nothing():
    one = answer([6.0])
    assert judged([one], total=1.0) is not None
    assert judged([one], total=150.0) is None  # e^6 is 400: by chance one of 150 does as well
    assert judged([answer([10.0])], total=150.0) is not None
    assert log_prior(one, 150.0) == pytest.approx(-np.log(150.0))
    rare = answer([9.0], prior=0.01)
    assert judged([rare], total=150.0) is None
    assert odds_of(answer([9.0]), 150.0) - odds_of(rare, 150.0) == pytest.approx(np.log(100.0))


def test_what_acts_on_all_joints_is_seen_by_several_and_lacking_on_none():
    alone, both = (
        answer([60.0, 1.0, 0.5], joints=(), rows=(0, 1, 2)),
        answer([30.0, 30.0, 1.0], joints=(), rows=(0, 1, 2)),
    )
    assert odds_of(alone, 10.0) == -np.inf
    assert judged([alone], 10.0) is None
    assert judged([both], 10.0) is not None
    assert judged([answer([60.0, 1.0, 0.5], joints=(0,))], 10.0) is not None
    common = {"joints": (), "rows": (0, 1, 2), "everywhere": True}
    assert judged([answer([30.0, 30.0, 8.0], **common)], 150.0) is not None
    assert judged([answer([30.0, 30.0, -3.0], **common)], 150.0) is None


def test_runs_held_out_contradict_beyond_the_scatter_of_coefficients():
    one = answer([60.0], held_out=4)
    against = replace(one, gains=np.where(one.fitted[:, None], one.gains, -1.0))
    assert against.held_out == pytest.approx(-4.0)
    assert odds_of(against, 10.0) == pytest.approx(odds_of(one, 10.0))
    assert contradicted(against)
    assert not contradicted(one)
    one = answer([60.0], held_out=BLOCKS // 4)
    shares = np.where(one.fitted, 60.0, -1.0 / (BLOCKS // 4))[:, None]
    one = replace(one, gains=shares)
    many = replace(one, free=np.ones(12, bool))  # twelve lose two nats, one loses a sixth
    assert contradicted(one)
    assert not contradicted(many)


def test_odds_are_against_nothing_and_against_a_misfit_that_differs_from_block_to_block():
    one = answer([20.0])
    assert one.odds == pytest.approx(20.0 + np.log(2.0), abs=1e-3)  # scatter alone says far more
    scattered = replace(one, along=np.where(np.arange(BLOCKS) % 2, 300.0, -100.0), scatter={})
    assert scattered.scatter_odds < 5.0
    assert scattered.odds == pytest.approx(scattered.scatter_odds + np.log(2.0), abs=1e-3)
    assert against_all(3.0, 3.0) == pytest.approx(3.0 - np.log(2.0))


def test_what_a_few_blocks_show_alone_is_not_credible():
    one = answer([60.0])
    size, along = np.full(BLOCKS, 0.01), 0.1 * np.random.default_rng(0).normal(size=BLOCKS)
    size[3] = along[3] = 100.0  # ten standard deviations of noise, once
    alone = replace(one, size=size, along=along, scatter={})
    assert alone.log_odds < 2.0
    assert judged([one], 10.0) is not None
    assert judged([alone], 10.0) is None


def test_a_shape_costs_gain_and_odds_what_a_shape_taken_blindly_would():
    gains = [20.0, 12.0, 3.0, -5.0]
    shapes = [answer([gain], shape={"speed": float(k)}) for k, gain in enumerate(gains)]
    [best] = _by_hypothesis(shapes)
    assert best.candidate.shape["speed"] == 0.0
    assert best.gain == pytest.approx(np.log(np.mean(np.exp(gains))))
    # Shapes that predict alike cost nothing.
    [any_of_them] = _by_hypothesis([answer([20.0])] * 4)
    assert any_of_them.gain == pytest.approx(20.0)
    best = answer([20.0], shape={"speed": 0.0})
    other = replace(answer([3.0], shape={"speed": 1.0}), along=np.tile([10.0, -10.0], BLOCKS // 2))
    [chosen] = _by_hypothesis([best, other])
    assert chosen.candidate.shape["speed"] == 0.0
    assert chosen.odds == pytest.approx(np.logaddexp(best.odds, other.odds) - np.log(2.0))


def test_alternatives_are_what_explains_the_same_joint():
    rivals = [answer([29.0, 0.0], "stribeck_friction"), answer([0.0, 29.5], "viscous_friction", (1,))]
    one = judged([answer([30.0, 0.0], "hysteresis"), *rivals], 10.0)
    assert [other.candidate.effect for other, _ in one.others] == ["stribeck_friction"]
    assert competing(one.answer, rivals[0])
    assert not competing(one.answer, rivals[1])
    assert one.probability == pytest.approx(1 / (1 + np.exp(-1.0)), rel=0.01)
    assert one.not_excluded[0][1] == pytest.approx(1 - one.probability, rel=0.01)


@pytest.mark.parametrize(
    ("gain", "cost", "blocks", "ahead"),
    [
        (33.0, 3.0, -5.0, -3.0),  # what predicts alike differs by what its shape cost
        (40.0, 0.0, 100.0, 7.0),
        (40.0, 0.0, 7.0, 7.0 - np.log(2.0)),
        (40.0, 0.0, 2.0, 2.0),  # no further than the scatter of blocks agrees
        (40.0, 0.0, -4.0, 0.0),
        (40.0, 10.0, 100.0, -3.0),
        (40.0, 10.0, -4.0, -10.0),  # costs are known without blocks
    ],
)
def test_blocks_and_costs_of_shapes_distinguish_two_answers(gain, cost, blocks, ahead):
    one, other = replace(answer([gain]), cost=cost), answer([33.0], "something_else")
    assert better(one, other, blocks) == pytest.approx(ahead, abs=0.01)
    assert better(other, one, -blocks) == pytest.approx(-ahead, abs=0.01)
    assert better(one, other, blocks, prior=1.0) == pytest.approx(ahead + 1.0, abs=0.01)


def test_blocks_have_what_the_arm_has_and_not_what_looks_like_it():
    found = spring_search()
    at = found.problem.prediction([])
    spring = alone(found)[0]
    [other] = [
        one
        for one in alone(found)
        if one.candidate.effect == "torque_ripple" and one.candidate.joints == (1,)
    ][:1]
    odds = by_blocks(at, spring, other)
    assert odds > 10.0
    assert by_blocks(at, other, spring) == pytest.approx(-odds)
    assert by_blocks(at, spring, spring) == 0.0


def test_a_shape_costs_how_many_are_distinguished_within_its_bounds():
    at = drag_search().problem
    prediction = at.prediction([])
    [whole] = [pair for pair in at.candidates if pair[0].key == ("nonlinear_viscous_friction", (1,), "")][2:3]
    [start] = ask(prediction, [whole])
    best = refined(prediction, start, at.runs)
    at_best, bounds = best.candidate.shape["exponent"], best.candidate.bounds["exponent"]
    # The integral of the likelihood over the exponent, over its bounds, by many shapes.
    grid = np.linspace(at_best - 0.1, at_best + 0.1, 41)
    gains = [with_shape(prediction, best, at.runs, {"exponent": value}).gain for value in grid]
    mean = np.trapezoid(np.exp(np.array(gains) - best.gain), np.log(grid))
    mean /= np.log(bounds.high / bounds.low)
    # To a factor of three: the width is that of a parabola through a few shapes.
    assert best.cost == pytest.approx(-np.log(mean), abs=np.log(3.0) + 0.1)
    assert best.cost > np.log(20.0)


@pytest.mark.parametrize(("share", "there"), [(0.01, False), (0.3, True)])
def test_a_spring_within_the_sensors_error_of_the_usual_torque_is_none(share, there):
    """However quiet the joint is: a sensor that is not linear has torque by position, too."""
    at = sound_problem(2)
    (_, columns), *_ = [pair for pair in at.candidates if pair[0].key == ("joint_spring", (1,), "")]
    spring = columns.everywhere(2)[:, :, 0]
    spring *= share * columns.usual[0] / np.std(spring[:, 1])
    quiet = at.rows.difference - 0.98 * at.without_findings.residual + spring
    base, rows = (replace(of, difference=quiet) for of in (at.base, at.rows))
    found = search.search(replace(at, base=base, rows=rows))
    assert (("joint_spring", (1,)) in names(found)) == there


# What becomes of a finding beside others.


def test_a_finding_whose_shape_physics_excludes_stays_in_one_that_it_allows(monkeypatch):
    found = drag_and_spring_search()
    by_name = {one.answer.candidate.effect: one for one in found.selected}
    drag, spring = by_name["nonlinear_viscous_friction"], by_name["joint_spring"]
    problem = replace(
        found.problem,
        candidates=[pair for pair in found.problem.candidates if pair[0].key != spring.answer.candidate.key],
    )
    monkeypatch.setattr(additions, "answer_beside", lambda *_: None)
    _, stay = additions._still_needed(problem, [drag, spring], total_prior(found.problem))
    assert [one.answer.candidate.effect for one in stay] == ["nonlinear_viscous_friction", "joint_spring"]
    grid = [one.shape["exponent"] for one, _ in problem.candidates if one.key == drag.answer.candidate.key]
    assert stay[0].answer.candidate.shape["exponent"] in grid
    assert abs(stay[0].answer.candidate.shape["exponent"] - 1.7) < 0.5
    # One that has no other shape goes.
    _, stay = additions._still_needed(problem, [spring, drag], total_prior(found.problem))
    assert [one.answer.candidate.effect for one in stay] == ["nonlinear_viscous_friction"]


EVERYWHERE = np.full(2, np.inf)
"""Change of the evidence on each joint."""


def test_what_is_not_credible_beside_all_others_goes():
    found = drag_search()
    assert names(found) == [("nonlinear_viscous_friction", (1,))]

    total = total_prior(found.problem)

    def stay(total, changed=EVERYWHERE):
        return search._rechosen(found.problem, list(found.selected), total, changed, {}, set())

    assert len(stay(total)) == 1
    # All is as improbable as one of very many.
    assert stay(total * 1e300) == []
    assert stay(total * 1e300, np.zeros(2)) == list(found.selected)  # nothing changed about it


def test_each_finding_is_chosen_anew_of_all_hypotheses_given_all_others():
    found = drag_and_spring_search()
    [spring] = [one for one in found.selected if one.answer.candidate.effect == "joint_spring"]
    [wrong] = [
        one
        for one in alone(found)
        if one.candidate.effect == "current_offset" and one.candidate.joints == (1,)
    ]
    others = [one for one in found.selected if one is not spring]
    mistaken = Selected(wrong, 50.0, ((wrong, 1.0),))
    left = search._rechosen(
        found.problem, [*others, mistaken], total_prior(found.problem), EVERYWHERE, {}, set()
    )
    assert {one.answer.candidate.effect for one in left} == {"joint_spring", "nonlinear_viscous_friction"}


def test_a_search_goes_on_until_a_pass_changes_nothing(monkeypatch):
    at, real, passes = spring_search().problem, search._rechosen, []

    def mistaken(problem, selected, *more):
        """The first pass drops everything."""
        passes.append([one.answer.candidate.effect for one in selected])
        return [] if len(passes) == 1 else real(problem, selected, *more)

    monkeypatch.setattr(search, "_rechosen", mistaken)
    found = search.search(at)
    assert passes[:2] == [["joint_spring"], ["joint_spring"]]
    assert names(found) == [("joint_spring", (1,))]


def test_what_another_effect_took_out_is_not_taken_again_in_the_same_pass(monkeypatch):
    """Of two effects that each take out the other, one is taken, then the other, and no more."""
    either, taken = [answer([50.0], "one"), answer([50.0], "other")], []
    at = SimpleNamespace(prediction=lambda _: SimpleNamespace(joints=1))

    def beside(_, prediction, found, *more):
        return [one for one in either if one.candidate.key not in keys_of(found)]

    def latest_alone(here, found, total):
        taken.append(found[-1].answer.candidate.effect)
        return here, found[-1:]

    monkeypatch.setattr(additions, "with_contacts", lambda here, found: (here, found))
    monkeypatch.setattr(additions, "ranked", beside)
    monkeypatch.setattr(additions, "without_idle_curves", lambda best, _: best)
    monkeypatch.setattr(additions, "simplest", lambda _, best, __: Selected(best[0], 50.0) if best else None)
    monkeypatch.setattr(additions, "_still_needed", latest_alone)
    monkeypatch.setattr(additions, "_material", lambda *_: True)
    monkeypatch.setattr(additions, "advantage", lambda *_: 1.0)
    _, found = additions.with_additions(at, [], 1.0, {}, set())
    assert taken == ["one", "other"]
    assert [one.answer for one in found] == either[1:]


def test_an_effect_of_given_size_is_there_whole_or_not_at_all():
    """Three blocks of many that have all of it, whose size is known, say more than if some of it would do."""
    one = answer([50.0])
    shown = np.where(np.arange(BLOCKS) < 3, 400.0, 0.01)
    along = np.where(np.arange(BLOCKS) < 3, 1.0, 0.0) * shown + np.sin(np.arange(BLOCKS)) * np.sqrt(shown)
    some, whole = (
        replace(one, columns=columns, along=along, size=shown, scatter={}).odds
        for columns in (replace(one.columns, mean=np.full(1, size)) for size in (0.0, 1.0))
    )
    assert whole > some + 1.0


@pytest.mark.long
def test_load_dependent_friction_is_found_with_the_preload_of_its_teeth():
    preloaded = LoadDependentFriction(("shoulder",), preload=10.0)
    found = searched(record([preloaded], {"mu1": 0.2}))
    assert names(found) == [("load_dependent_friction", (0,))]
    [(value, _)] = sizes(found)
    # A slope and where it begins replace one another.
    assert value == pytest.approx(0.2, rel=0.05)
    assert found.selected[0].answer.candidate.shape["preload"] == pytest.approx(10.0, rel=0.3)
