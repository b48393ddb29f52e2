"""How much of a predicted effect blocks have: by noise, and by the error of the effect's formula."""

import numpy as np
import pytest
from scipy import stats

from exidyn.identification.diagnosis.blocks.block_likelihood import above_zero, all_or_nothing

pytestmark = pytest.mark.numerical

BLOCKS = 24
REPEATS = 400


def blocks(seed, mean, error, size):
    """Residual of each block along an effect of which it has `mean` on average, off by a share `error`."""
    rng = np.random.default_rng(seed)
    own = mean + error * rng.normal(size=len(size))
    return own * size + np.sqrt(size) * rng.normal(size=len(size))


def test_nothing_and_what_replaces_an_effect_are_seldom_above_zero():
    size = np.random.default_rng(1).lognormal(1.0, 1.5, BLOCKS)
    odds = np.array([above_zero(blocks(seed, 0.0, 0.0, size), size) for seed in range(REPEATS)])
    above = 1.0 / (1.0 + np.exp(-odds))
    assert np.mean(above > 0.95) < 0.05 + 3.0 * np.sqrt(0.05 * 0.95 / REPEATS)
    assert stats.kstest(above, "uniform").statistic < 0.12  # cautious, since few blocks count for most
    size = np.random.default_rng(2).lognormal(5.0, 1.5, BLOCKS)
    odds = np.array([above_zero(blocks(seed, 0.0, 1.0, size), size) for seed in range(REPEATS)])
    assert np.mean(odds > np.log(19.0)) < 0.05 + 3.0 * np.sqrt(0.05 * 0.95 / REPEATS)


def test_few_blocks_are_certain_by_their_number_and_agreement():
    # Four blocks have nearly all of the effect, but all have the same sign of it.
    size = np.append(np.full(4, 800.0), np.full(BLOCKS - 4, 30.0))
    assert above_zero(blocks(3, 1.0, 0.35, size), size) > 15.0
    assert above_zero(np.full(8, 3.0), np.full(8, 3.0)) > 15.0
    assert above_zero(np.array([50.0, 0.0, 0.0]), np.array([50.0, 0.0, 0.0])) == 0.0
    assert above_zero(np.zeros(5), np.zeros(5)) == 0.0


def test_all_of_an_effect_is_as_much_more_probable_than_nothing_as_it_is_more_frequent():
    """Of blocks of which half have all and half have nothing, odds of e are right e times of 1 + e."""
    size = np.random.default_rng(4).lognormal(-1.5, 1.0, BLOCKS)
    has = np.arange(REPEATS) % 2 == 0
    odds = np.array(
        [all_or_nothing(blocks(seed, float(own), 0.2, size), size) for seed, own in enumerate(has)]
    )
    stated = 1.0 / (1.0 + np.exp(-odds))
    near = (stated > 0.5) & (stated < 0.95)
    assert np.count_nonzero(near) > 40
    assert np.mean(has[near]) == pytest.approx(np.mean(stated[near]), abs=0.12)
    assert np.mean(has[stated > 0.95]) > 0.95
    along = blocks(0, 1.0, 0.2, size)
    assert all_or_nothing(size - along, size) == pytest.approx(-all_or_nothing(along, size))
    assert all_or_nothing(along[:1], size[:1]) == 0.0


@pytest.mark.parametrize("count", [4, 8, 24])
def test_blocks_that_see_alike_are_a_students_test_of_their_mean(count):
    own = 0.8 + np.random.default_rng(count).normal(size=count)
    size = np.full(count, 5.0)
    chance = stats.ttest_1samp(own, 0.0, alternative="greater").pvalue
    assert above_zero(own * size, size) == pytest.approx(np.log((1.0 - chance) / chance), rel=1e-6)
