"""Blocks that are left out, against fits without them that are written out row by row."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis.blocks.block_likelihood import trusted
from exidyn.identification.diagnosis.blocks.blocks import FEWEST, MOST, SHORTEST, Blocks
from exidyn.identification.diagnosis.questions.block_answer import prior_std
from exidyn.identification.diagnosis.questions.question import ask
from exidyn.identification.diagnosis.search.selected import contradicted

from ...parts.small.small_rows import asked, blocks, predicted, rows

pytestmark = pytest.mark.numerical

LENGTHS, JOINTS, UNKNOWNS = (30, 25, 35, 28, 32, 26), 3, 4
COUNT = sum(LENGTHS)
HELD_OUT = (4,)


def system(seed=0):
    """Unknowns that act on several joints, priors on some, and rows that do not count."""
    random = np.random.default_rng(seed)
    columns = random.normal(size=(COUNT, JOINTS, UNKNOWNS))
    columns[:, 0, 3] = 0.0  # not every unknown acts everywhere
    columns[:, 2, 0] = 0.0
    weight = (random.random((COUNT, JOINTS)) > 0.1).astype(float)
    std, mean = np.array([np.inf, 0.5, np.inf, 0.1]), np.array([0.0, 0.3, 0.0, -0.2])
    torque = columns @ np.array([1.0, -0.5, 2.0, 0.4])
    torque += random.normal(size=torque.shape) * np.array([0.3, 1.0, 3.0])
    given = rows(torque, columns, std, mean, runs=(LENGTHS[0] + LENGTHS[1],), weight=weight)
    return given, blocks(LENGTHS, HELD_OUT), random


def brute(prediction, left_out, more=None, held=None):
    """Unknowns without one block, the priors as further rows, by lstsq; `held` are values that stay."""
    given, pieces = prediction.rows, prediction.blocks
    columns, std, mean = given.columns, given.std, given.mean
    if more is not None:
        candidate, thinned = more
        columns = np.concatenate([columns, thinned.everywhere(JOINTS)], axis=2)
        std = np.concatenate([std, prior_std(candidate, thinned)])
        mean = np.concatenate([mean, thinned.mean])
    scale = np.sqrt(prediction.weighting.weight[pieces.number] * given.weight)
    scale[pieces.number == left_out] = 0.0
    held = np.full(len(std), np.nan) if held is None else np.concatenate([np.full(UNKNOWNS, np.nan), held])
    free = np.isnan(held)
    stays = columns[:, :, ~free] @ held[~free]
    system = (columns[:, :, free] * scale[:, :, None]).reshape(-1, free.sum())
    right = ((given.difference - stays) * scale).ravel()
    priors = np.diag(1.0 / std)[:, free]
    found = np.linalg.lstsq(np.vstack([system, priors]), np.append(right, mean / std), rcond=None)[0]
    values = held.copy()
    values[free] = found
    return values, columns


def rows_of(pieces):
    """Rows of each block."""
    return [np.flatnonzero(pieces.number == block) for block in range(len(pieces))]


def errors(prediction, more=None, held=None):
    """Of each block and joint, predicted by a fit without it, and the predictions (r, n)."""
    given, pieces = prediction.rows, prediction.blocks
    found, text = np.zeros((len(pieces), JOINTS)), np.zeros_like(given.difference)
    for block, own in enumerate(rows_of(pieces)):
        values, columns = brute(prediction, block, more, held)
        text[own] = columns[own] @ values
        found[block] = np.sum(given.weight[own] * (given.difference[own] - text[own]) ** 2, axis=0)
    return found, text


CASES = {
    "one joint": {"joints": (1,), "count": 1},
    "one joint, two coefficients": {"joints": (0,), "count": 2},
    "all joints": {"joints": (0, 1, 2), "count": 2},
    "expected": {"joints": (1,), "count": 2, "mean": (1.0, 0.0), "std": (0.4, 0.2)},
}


def question(case, given, random, **more):
    options = {"mean": None, "std": None} | {k: v for k, v in CASES[case].items() if k in ("mean", "std")}
    joints, count = CASES[case]["joints"], CASES[case]["count"]
    column = random.normal(size=(COUNT, len(joints), count))
    column[:, :, 0] += 0.5 * given.columns[:, list(joints), 2]  # of which an unknown has a part
    truth = np.array([0.9, -0.15])[:count]
    torque = given.difference.copy()
    torque[:, list(joints)] += column @ truth
    return replace(given, difference=torque), asked(column, joints, **options, **more)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("lengths", [LENGTHS, (2,) * (COUNT // 2)])  # more, and fewer rows than unknowns
def test_every_block_is_predicted_with_a_candidate_as_a_fit_without_it_does(case, lengths):
    given, _, random = system(0)
    pieces = blocks(lengths, HELD_OUT)
    given, pair = question(case, given, random)
    prediction = predicted(given, pieces)
    others = [question(other, given, random)[1] for other in (case, *CASES)]
    answers = ask(prediction, [*others, pair], strange=True)
    [answer] = [answer for answer in answers if answer.columns is pair[1]]
    exact, with_it = errors(prediction, pair)
    np.testing.assert_allclose(answer.errors, exact, rtol=1e-5, atol=1e-11)
    np.testing.assert_allclose(answer.values, brute(prediction, -1, pair)[0][UNKNOWNS:], rtol=1e-5)
    before, without = errors(prediction)
    np.testing.assert_allclose(answer.predicted, before, rtol=1e-5)
    effect, noise = with_it - without, 1.0 / prediction.weighting.variance
    share = prediction.weighting.independent
    for block, own in enumerate(rows_of(pieces)):
        counts = share * given.weight[own].sum(axis=0)
        sound = np.array(
            [
                trusted(np.array([s * e]), n)[0]
                for s, e, n in zip(share * noise, exact[block], counts, strict=True)
            ]
        )
        rows_count = given.weight[own] * noise * sound
        along = np.sum(rows_count * effect[own] * (given.difference[own] - without[own]))
        assert answer.along[block] == pytest.approx(along, rel=1e-4, abs=1e-6)
        assert answer.size[block] == pytest.approx(np.sum(rows_count * effect[own] ** 2), rel=1e-4)


@pytest.mark.parametrize("limit", [0.0, -0.1])
def test_a_coefficient_that_would_be_below_its_limit_stays_there(limit):
    given, pieces, random = system(7)
    given, pair = question("one joint, two coefficients", given, random)
    free = predicted(given, pieces)
    assert ask(free, [pair])[0].values[1] < -0.1
    candidate = replace(pair[0], lower=(0.0, limit))
    [answer] = ask(free, [(candidate, pair[1])])
    assert answer.values[1] == limit
    assert answer.free.tolist() == [True, False]
    exact, _ = errors(free, pair, held=np.array([np.nan, limit]))
    np.testing.assert_allclose(answer.errors, exact, rtol=1e-5)


def test_what_would_have_to_be_below_its_limit_is_no_answer():
    given, pieces, random = system(8)
    given, (candidate, thinned) = question("one joint", given, random)
    flipped = replace(thinned, values=-thinned.values)
    prediction = predicted(given, pieces)
    assert len(ask(prediction, [(candidate, flipped)])) == 1
    assert ask(prediction, [(replace(candidate, lower=(0.0,)), flipped)]) == []


@pytest.mark.parametrize(("beside", "possible"), [(-0.5, False), (-0.05, True), (0.5, True)])
def test_what_needs_an_unknown_below_its_limit_by_more_than_a_tenth_of_itself_is_no_answer(beside, possible):
    random = np.random.default_rng(3)
    known, apart = random.normal(size=(2, 240, 1, 1))
    torque = (beside + 1.0) * known + apart + 0.01 * random.normal(size=known.shape)
    given = rows(torque[:, :, 0], known, np.array([np.inf]))
    pair = asked(known + apart, (0,))
    [free] = ask(predicted(given, blocks([30] * 8)), [pair])
    assert free.values[0] == pytest.approx(1.0, abs=0.01)
    limited = ask(predicted(replace(given, lower=np.zeros(1)), blocks([30] * 8)), [pair])
    assert bool(limited) == possible


def test_what_is_far_from_what_physics_expects_is_no_answer():
    given, pieces, random = system(9)
    given, (candidate, thinned) = question("one joint", given, random)
    prediction = predicted(given, pieces)

    def expected(mean):
        one = replace(candidate, expected=((mean, 0.1),))
        return ask(prediction, [(one, replace(thinned, mean=np.array([mean]), std=np.array([0.1])))])

    assert len(expected(1.0)) == 1
    assert expected(-3.0) == []


def test_of_many_shapes_the_one_that_was_chosen_costs_their_number():
    given, pieces, random = system(3)
    given, (candidate, thinned) = question("one joint", given, random)
    prediction = predicted(given, pieces)
    [alone], [chosen] = (ask(prediction, [(replace(candidate, among=among), thinned)]) for among in (1, 50))
    assert alone.gain - chosen.gain == pytest.approx(np.log(50))


def test_a_coefficient_of_one_sign_is_twice_as_probable():
    """Its prior has half the values, each twice as dense."""
    random = np.random.default_rng(3)
    column = random.normal(size=(1600, 1, 1))
    torque = 2.0 * column[:, 0] + random.normal(size=(1600, 1))
    prediction = predicted(
        rows(torque, random.normal(size=(1600, 1, 1)), np.array([np.inf])), blocks((100,) * 16)
    )
    either, above = ask(prediction, [asked(column, (0,)), asked(column, (0,), lower=(0.0,))])
    np.testing.assert_allclose(above.gains, either.gains)
    assert above.gain - either.gain == pytest.approx(np.log(2.0))


def test_runs_held_out_are_predicted_and_not_fitted():
    given, pieces, _ = system(5)
    own = rows_of(pieces)[HELD_OUT[0]]
    other = given.difference.copy()
    other[own] += 50.0
    before, after = predicted(given, pieces), predicted(replace(given, difference=other), pieces)
    np.testing.assert_allclose(after.values, before.values, rtol=1e-9)
    np.testing.assert_allclose(after.weighting.variance, before.weighting.variance, rtol=1e-9)
    assert np.all(after.errors[HELD_OUT[0]] > 100 * before.errors[HELD_OUT[0]])


def test_a_gain_is_of_fitted_blocks_and_those_held_out_judge_it():
    given, pieces, random = system(6)
    given, pair = question("one joint", given, random)
    [answer] = ask(predicted(given, pieces), [pair])
    assert answer.held_out > 1.0
    assert answer.gain == pytest.approx(float(answer.gains[pieces.fitted].sum()) + answer.relief)
    assert not contradicted(answer)
    # Where the runs held out have less of it than none, they contradict it.
    own = rows_of(pieces)[HELD_OUT[0]]
    contrary = given.difference.copy()
    contrary[own, 1] -= 3.0 * pair[1].values[own, 0, 0]
    [against] = ask(predicted(replace(given, difference=contrary), pieces), [pair])
    assert against.held_out < -1.0
    assert against.odds == pytest.approx(answer.odds, rel=0.2)
    assert contradicted(against)


def test_what_is_explained_is_right_to_the_linearity_of_the_sensors():
    given, pieces, _ = system(6)
    prediction = predicted(given, pieces)
    share = np.ones(prediction.joints)
    found = replace(prediction, nominal=1e5 * prediction.errors)

    def gained(one, share_of_errors):
        less = one.log_probability(share_of_errors * one.errors, share)
        return float((less - one.log_probability(one.errors, share)).sum())

    # A quarter of the error remains: beside a hundred times as much of linearity, that is little.
    assert gained(prediction, 0.25) > 10.0 * gained(found, 0.25) > 0.0
    # What is explained is a hundred times the error; an error of a tenth of it is beyond linearity.
    assert gained(replace(prediction, nominal=1e2 * prediction.errors), 0.25) > 0.8 * gained(prediction, 0.25)


def test_noise_of_each_joint_weighs_its_rows():
    random = np.random.default_rng(11)
    count, noise = 2000, np.array([0.1, 5.0])
    columns = random.normal(size=(count, 2, 1))
    errors_of = []
    for _ in range(8):
        torque = columns[:, :, 0] * 2.0 + random.normal(size=(count, 2)) * noise
        prediction = predicted(rows(torque, columns, np.array([np.inf])), blocks((100,) * 20))
        np.testing.assert_allclose(np.sqrt(prediction.weighting.variance), noise, rtol=0.1)
        errors_of.append(prediction.values[0] - 2.0)
    # By the quiet joint 0.1 / sqrt(2000); by rows of equal weight it would be 5 / sqrt(8000).
    assert np.std(errors_of) < 2.0 * 0.1 / np.sqrt(count)


def run(seconds, role="identify", rate=100.0, position=None, payload=""):
    """A run of as many rows, whose motion does not repeat unless positions (r, n) say so."""
    count = round(seconds * rate)
    motion = SimpleNamespace(
        position=np.random.default_rng(count).normal(size=(count, 2)) if position is None else position,
        payload=payload,
    )
    return SimpleNamespace(
        rows=count,
        role=role,
        prepared=SimpleNamespace(decimation=SimpleNamespace(output_rate=rate)),
        motion=motion,
        centres=np.arange(count),
    )


def test_no_block_spans_two_runs_and_every_row_is_in_one():
    runs = [run(7.3), run(12.1), run(3.9, "validate")]
    found = Blocks.of(runs, "validate")
    edges = np.cumsum([0, *(one.rows for one in runs)])
    assert len(found.number) == edges[-1]
    assert np.all(np.diff(found.number) >= 0)
    held_out = []
    for rows_of_block in rows_of(found):
        of_run = np.searchsorted(edges, rows_of_block, "right")
        assert np.all(of_run == of_run[0])
        held_out.append(of_run[0] == 3)
    assert found.fitted.tolist() == [not one for one in held_out]
    assert 0 < sum(held_out) < len(found)


@pytest.mark.parametrize(
    ("seconds", "count", "length"),
    [
        (200.0, MOST, 200.0 / MOST),  # long ones have longer blocks
        (40.0, 20, 2.0),
        (8.0, FEWEST, 0.5),  # short ones shorter ones
        (2.1, 7, SHORTEST),  # but none is shorter than what a residual remembers
        (0.2, 1, SHORTEST),
    ],
)
def test_blocks_are_few_enough_to_be_long_and_many_enough_to_scatter(seconds, count, length):
    found = Blocks.of([run(seconds), run(10.0, "validate")], "validate")
    assert found.fitted.sum() == count
    assert found.seconds == pytest.approx(length)


def test_priors_that_a_candidate_relieves_support_it_as_far_as_they_were_strained():
    random = np.random.default_rng(12)
    column = random.normal(size=(COUNT, JOINTS, 1))
    torque = column[:, :, 0] * 1.0 + 0.1 * random.normal(size=(COUNT, JOINTS))
    pair = asked(column, range(JOINTS))
    for std, sigmas in ((0.1, 10.0), (1.0, 1.0)):
        given = rows(torque, column, np.array([std]))
        prediction = predicted(given, blocks(LENGTHS))
        assert abs(prediction.values[0]) / std == pytest.approx(sigmas, rel=0.05)
        [answer] = ask(prediction, [pair])
        # The same columns predict no block better; all that they do is to leave the prior where it was.
        assert abs(answer.gains.sum()) < 1.0
        before = 2.5 * np.log1p(sigmas**2 / 4.0)
        # Less one: with a free coefficient of its own in place of the prior's.
        assert answer.relief == pytest.approx(before - 1.0, abs=0.3)
        assert answer.gain > 5.0 if sigmas > 5 else answer.gain < 1.5
    unknown = predicted(rows(torque, column, np.array([np.inf])), blocks(LENGTHS))
    assert all(abs(one.relief) < 1e-9 for one in ask(unknown, [pair]))


def test_columns_that_noise_explains_as_well_are_not_compared_block_by_block():
    given, _, random = system(0)
    given, pair = question("one joint", given, random)
    noise = [asked(random.normal(size=(COUNT, 1, 1)), (1,)) for _ in range(40)]
    *idle, answer = ask(predicted(given, blocks(LENGTHS)), [*noise, pair])
    assert answer.gain > 10.0
    skipped = [one for one in idle if not np.any(one.gains)]
    assert len(skipped) > 20
    assert all(one.gain <= 0.0 and np.all(one.errors == one.predicted) for one in skipped)


def test_rows_that_repeat_the_same_count_once_beside_a_prior():
    random = np.random.default_rng(12)
    column, noise = np.repeat(random.normal(size=(2, 1600, 1)), 8, axis=1)
    alone, repeated = (
        predicted(
            rows(one * 0.3 + 2.0 * some, one[:, :, None], np.array([0.05])), blocks((len(one) // 20,) * 20)
        )
        for one, some in ((column[::8], noise[::8]), (column, noise))
    )
    assert alone.values[0] < 0.2  # between the prior's 0 and the data's 0.3
    assert repeated.values[0] == pytest.approx(alone.values[0], abs=0.03)
