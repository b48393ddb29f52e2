"""Entropy of a question: limits, and an average that can be computed otherwise."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from exidyn.identification.diagnosis.belief.open_items import entropy, expected_entropy


def apart(separation):
    return separation * (1.0 - np.eye(2))


def test_entropy_of_certainty_of_even_odds_and_of_what_a_run_settles():
    assert entropy(np.array([1.0, 0.0])) == 0.0
    assert entropy(np.array([0.5, 0.5])) == pytest.approx(np.log(2.0))
    assert expected_entropy(np.array([0.7, 0.3]), apart(1e4)) < 1e-12


@pytest.mark.parametrize("first", [0.5, 0.9, 0.999, 1.0])
def test_a_run_that_cannot_tell_leaves_the_question_as_it_is(first):
    probability = np.array([first, 1.0 - first])
    assert expected_entropy(probability, apart(0.0)) == pytest.approx(entropy(probability))


@pytest.mark.parametrize("separation", [0.3, 2.0, 10.8])
def test_between_them_it_is_the_average_over_the_logarithm_of_the_odds(separation):
    probability = np.array([0.8, 0.2])

    def left(gained, true):
        odds = np.log(probability[true] / probability[1 - true]) + gained
        share = 1.0 / (1.0 + np.exp(-odds))
        return entropy(np.array([share, 1.0 - share])) * norm.pdf(
            gained, separation / 2.0, np.sqrt(separation)
        )

    wanted = sum(probability[true] * quad(left, -60.0, 90.0, (true,), points=[0.0])[0] for true in (0, 1))
    assert expected_entropy(probability, apart(separation)) == pytest.approx(wanted, abs=0.02)


def test_one_rival_that_stays_leaves_its_share():
    probability = np.array([0.5, 0.25, 0.25])
    separation = np.full((3, 3), 1e4) * (1.0 - np.eye(3))
    separation[1, 2] = separation[2, 1] = 0.0
    assert expected_entropy(probability, separation) == pytest.approx(0.5 * np.log(2.0), abs=1e-6)


def test_an_outcome_that_settles_the_question_counts_for_nothing():
    probability, some, none = np.array([0.94, 0.06]), np.full(2, 0.95), np.full(2, np.inf)
    assert expected_entropy(probability, apart(0.0), some) == pytest.approx(entropy(probability))
    little, all_of_it = (expected_entropy(probability, apart(0.1), one) for one in (some, none))
    assert little < 0.8 * all_of_it
