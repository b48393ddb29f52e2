"""Probability of predicted blocks: coloured noise, strange blocks, how often chance passes for an effect."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from exidyn.identification.diagnosis.blocks.block_likelihood import (
    FREEDOM,
    autocorrelation,
    common_variance,
    independent_share,
    log_probability,
    strain,
    trust,
)
from exidyn.identification.diagnosis.questions.block_answer import CERTAIN_ODDS, CREDIBLE
from exidyn.identification.diagnosis.questions.comparison import colouring, equally_weighted
from exidyn.identification.diagnosis.questions.question import ask
from exidyn.identification.diagnosis.search.additions import _material
from exidyn.identification.diagnosis.search.selected import odds_of

from ...parts.small.small_rows import RATE, asked, blocks, predicted, remembering, rows

pytestmark = pytest.mark.numerical

LONG = 60_000


def share(noise, effect=None):
    return independent_share(noise, (slice(0, len(noise)),), RATE, effect)


def test_rows_of_white_noise_are_all_independent():
    noise = np.random.default_rng(0).normal(size=(LONG, 2))
    assert share(noise) == pytest.approx([1.0, 1.0], abs=0.01)


@pytest.mark.parametrize(("own", "other"), [(0.02, 0.02), (0.02, 0.1), (0.05, 0.03)])
def test_coloured_rows_are_fewer_as_bartletts_formula_has_it(own, other):
    random = np.random.default_rng(1)
    residual, effect = (remembering(random, (LONG, 1), memory) for memory in (own, other))
    product = np.exp(-1.0 / (RATE * own)) * np.exp(-1.0 / (RATE * other))
    assert share(residual, effect)[0] == pytest.approx((1 - product) / (1 + product), rel=0.12)
    # That is by how much the variance of the sum of products is greater than of white noise.
    sums = [
        float(np.sum(remembering(random, (2000, 1), own) * remembering(random, (2000, 1), other)))
        for _ in range(400)
    ]
    assert 2000 / np.var(sums) == pytest.approx((1 - product) / (1 + product), rel=0.25)


def test_autocorrelation_is_the_sum_of_products_at_each_lag():
    values = np.random.default_rng(3).normal(size=(101, 2))  # a prime, padded to a length that is fast
    found = autocorrelation(values, (slice(0, 101),), RATE)
    for lag in range(len(found)):
        product = np.sum(values[: 101 - lag] * values[lag:], axis=0)
        assert found[lag] == pytest.approx(product / np.sum(values**2, axis=0))


def test_runs_are_not_remembered_by_the_next():
    noise = np.ones((400, 1))
    noise[200:] = -1.0  # alike within each run, and opposite in the other
    runs = (slice(0, 200), slice(200, 400))
    assert independent_share(noise, runs, RATE)[0] < 0.05


def test_probability_of_usual_blocks_is_that_of_the_normal_distribution():
    counts = np.full((20, 1), 80.0)
    better, worse = counts * 1.0, counts * 1.3
    gain = np.sum(log_probability(better, counts) - log_probability(worse, counts))
    assert gain == pytest.approx(0.5 * counts.sum() * np.log(1.3), rel=1e-6)


def test_one_wild_block_neither_outvotes_the_others_nor_draws_a_fit():
    counts = np.full((20, 1), 80.0)
    without, with_it = 1.0 * counts, 0.8 * counts
    without[7] *= 1e4
    with_it[7] = 1.2 * without[7]
    gains = log_probability(with_it, counts) - log_probability(without, counts)
    assert gains.sum() > 100.0
    assert abs(gains[7, 0]) < 20.0
    # By a normal distribution of one variance for all, the wild one would decide.
    assert np.log(with_it.sum() / without.sum()) > 0.0
    counts = np.full((20, 1), 80.0)
    errors = counts.copy()
    errors[3] *= 100.0
    weight = trust(errors, counts)
    assert weight[3, 0] < 0.05
    assert np.delete(weight, 3, 0) == pytest.approx(np.ones((19, 1)), abs=0.01)


@pytest.mark.parametrize("memory", [0.0, 0.02])
def test_pure_noise_is_taken_for_an_effect_less_often_than_its_probability_states(memory):
    random = np.random.default_rng(4)
    odds, gains = [], []
    for _ in range(3):
        torque = remembering(random, (3200, 2), memory)
        prediction = predicted(
            rows(torque, random.normal(size=(3200, 2, 2)), np.full(2, np.inf), runs=(1600,)),
            blocks((160,) * 20, held_out=(18, 19)),
        )
        for slowness in (0.0, 0.02, 0.1):
            columns = remembering(random, (3200, 1, 60), slowness)
            pairs = [asked(columns[:, :, [k]], (0,)) for k in range(60)]
            answers = [colouring(prediction, one) for one in ask(prediction, pairs)]
            assert len(answers) == 60
            odds += [odds_of(one, 1.0) for one in answers]
            gains += [one.gain for one in answers]
    assert len(odds) == 540
    assert np.mean(np.array(odds) > CERTAIN_ODDS) < 1 - CREDIBLE
    assert np.mean(np.array(gains) > CERTAIN_ODDS) < 1 - CREDIBLE


def test_of_two_answers_the_one_that_leaves_less_is_ahead_be_it_slower():
    random = np.random.default_rng(5)
    slow = remembering(random, (3200, 1), 0.5)
    noise = remembering(random, (3200, 1), 0.1)
    torque = slow + 0.05 * noise
    rough = slow + 0.15 * random.normal(size=(3200, 1))  # faster, and worse
    pairs = [asked(one[:, :, None], (0,), effect=name) for name, one in (("slow", slow), ("rough", rough))]
    prediction = predicted(rows(torque, np.ones((3200, 1, 1)), np.array([np.inf])), blocks((160,) * 20))
    answers = ask(prediction, pairs)
    ahead, behind = equally_weighted(prediction, answers)
    assert ahead.candidate.effect == "slow"
    assert ahead.errors.sum() < behind.errors.sum()
    assert ahead.gain > behind.gain
    np.testing.assert_array_equal(ahead.independent, behind.independent)
    own = [colouring(prediction, one) for one in answers]
    assert own[0].independent[0] < own[1].independent[0]


def test_one_strange_block_hardly_changes_the_variance_that_all_share():
    rows = np.full((20, 1), 50.0)
    errors = np.random.default_rng(3).chisquare(50.0, (20, 1)) * 0.04
    usual = common_variance(errors, rows)
    assert usual == pytest.approx(0.04, rel=0.1)
    strange = errors.copy()
    strange[4] *= 100.0
    assert common_variance(strange, rows) == pytest.approx(usual, rel=0.2)
    assert strange.sum() > 5.0 * errors.sum()


def test_an_effect_matters_though_one_block_is_predicted_worse_with_it():
    rows, without = np.full((20, 1), 50.0), np.full((20, 1), 100.0)
    beside = rows.copy()
    beside[4] = 5000.0
    prediction = SimpleNamespace(
        errors=without, common_variance=lambda errors, share: common_variance(share * errors, share * rows)
    )
    effect = SimpleNamespace(
        predicted=without,
        errors=beside,
        independent=np.ones(1),
        by_joint=np.ones(1),
        joint=0,
        relief=0.0,
        torque=np.eye(2)[:, :1],
        candidate=SimpleNamespace(smooth=False),
        columns=SimpleNamespace(usual=np.full(1, 40.0), joints=np.zeros(1, int)),
    )
    assert _material(effect, prediction)
    # Of a variance of 2 N² m² it takes one: less than the sensors' error of 40 N m, which is slow.
    effect.candidate.smooth = True
    assert not _material(effect, prediction)
    assert _material(SimpleNamespace(**vars(effect) | {"torque": np.ones((2, 1))}), prediction)  # a constant
    effect.candidate.smooth, effect.errors = False, 0.9999 * without
    assert not _material(effect, prediction)


def test_a_bound_is_exceeded_less_easily_than_a_prior():
    apart = np.array([1.0, 6.0])
    assert strain(apart[:1], True) == pytest.approx(0.5)
    assert strain(apart, np.array([True, True])) == pytest.approx(18.5)
    assert strain(apart, np.array([True, False])) == pytest.approx(0.5 + strain(6.0))
    assert strain(6.0) < 6.0


def test_a_blocks_error_has_the_multivariate_students_distribution():
    """By how much more probable one error of a block is than another, beside many of the same variance."""
    count, scale = 6, 2.0
    density = stats.multivariate_t(np.zeros(count), scale * np.eye(count), df=FREEDOM)
    others = np.sum(density.rvs(20000, random_state=5) ** 2, axis=1)
    rows, small, large = np.full((20001, 1), float(count)), count * scale, 20.0 * count
    one, other = (log_probability(np.append(others, error)[:, None], rows)[-1, 0] for error in (small, large))
    expected = [density.logpdf(np.sqrt(error / count) * np.ones(count)) for error in (small, large)]
    assert one - other == pytest.approx(expected[0] - expected[1], rel=0.03)
