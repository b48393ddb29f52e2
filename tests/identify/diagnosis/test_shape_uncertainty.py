"""Deviations of a finding's numbers, its shape's among them, against those of a nonlinear fit."""

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import optimize

from exidyn.identification.diagnosis.blocks.prediction import CERTAIN
from exidyn.identification.diagnosis.questions.block_answer import Answer
from exidyn.identification.diagnosis.questions.candidate import Candidate, Thinned
from exidyn.identification.diagnosis.results.evidence import deviations
from exidyn.identification.diagnosis.search.selected import Selected
from exidyn.identification.effects import Shape

from ...parts.small.small_rows import blocks, predicted, rows

pytestmark = pytest.mark.numerical

COUNT = 4000
SPEED = np.tile(np.linspace(0.0, 1.0, 100), COUNT // 100)
NOISE = 0.1


def fading(speed: float) -> Candidate:
    """Friction that fades with speed."""

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return fading(given["speed"])

    return Candidate(
        "stribeck_friction", (0,), lambda run: np.exp(-SPEED / speed)[:, None, None], ("Fs",), ("N m",),
        (0.0,), {"speed": speed}, {"speed": Shape("rad/s", 0.01, 10.0)}, reshaped,
        reported={"half": (speed * np.log(2.0), "rad/s")},
    )  # fmt: skip


def searched(candidate: Candidate, torque: np.ndarray) -> SimpleNamespace:
    """What a search has come to that has found it, and nothing else."""
    run = SimpleNamespace(torque=np.ones((COUNT, 1)), thinned=lambda columns: columns)
    columns = Thinned.of(candidate, [run])
    given = rows(torque[:, None], columns.values, np.array([np.inf]))
    prediction = predicted(given, blocks((COUNT // 40,) * 40))
    nothing, still = np.zeros((40, 1)), np.zeros(40)
    answer = Answer(
        candidate, columns, np.array([2.0]), np.ones(1, bool), nothing, nothing, still, still, nothing,
        np.ones(1), np.ones(40, bool),
    )  # fmt: skip
    problem = SimpleNamespace(runs=(run,), pairs=lambda wanted: [])
    return SimpleNamespace(prediction=prediction, selected=(Selected(answer, 100.0),), problem=problem)


def noise(seed):
    return NOISE * np.random.default_rng(seed).normal(size=COUNT)


def test_a_shape_that_was_chosen_leaves_the_uncertainty_of_a_fit_that_varies_it():
    torque = 2.0 * np.exp(-SPEED / 0.3) + noise(1)
    values, covariance = optimize.curve_fit(
        lambda x, height, speed: height * np.exp(-x / speed), SPEED, torque, (2.0, 0.3)
    )
    [(coefficients, shape)] = deviations(searched(fading(values[1]), torque))
    height, speed = np.sqrt(np.diag(covariance))
    # By the scatter over 40 blocks, which is known to a ninth.
    assert coefficients[0] == pytest.approx(height, rel=0.35)
    assert shape["speed"] == pytest.approx(speed, rel=0.35)
    assert shape["half"] == pytest.approx(shape["speed"] * np.log(2.0), rel=0.01)
    fixed = 1.0 / np.sqrt(np.sum(np.exp(-2 * SPEED / 0.3))) * NOISE
    assert coefficients[0] > 1.3 * fixed


def test_without_a_shape_the_uncertainty_is_that_of_a_straight_fit():
    plain = Candidate(
        "viscous_friction", (0,), lambda run: SPEED[:, None, None], ("Fs",), ("N m s/rad",), (0.0,)
    )
    spread = [deviations(searched(plain, 2.0 * SPEED + noise(seed)))[0] for seed in range(6)]
    assert not spread[0][1]
    expected = NOISE / np.sqrt(SPEED @ SPEED)
    assert np.mean([own[0] for own, _ in spread]) == pytest.approx(expected, rel=0.2)


def test_a_number_without_a_range_has_no_uncertainty():
    """As the preload of friction on a joint that bears no load."""
    torque = 2.0 * np.exp(-SPEED / 0.3) + noise(1)
    fixed = replace(fading(0.3), bounds={"speed": Shape("rad/s", 0.3, 0.3)})
    [(coefficients, shape)] = deviations(searched(fixed, torque))
    assert shape["speed"] == 0.0
    expected = 1.0 / np.sqrt(np.sum(np.exp(-2 * SPEED / 0.3))) * NOISE
    assert coefficients[0] == pytest.approx(expected, rel=0.35)


def test_what_a_limit_of_physics_holds_is_as_uncertain_as_without_it():
    torque = noise(3)
    found = searched(fading(0.3), torque)
    [one] = found.selected
    answer = replace(one.answer, values=np.zeros(1), free=np.zeros(1, bool))
    held = replace(found.prediction.rows, std=np.array([CERTAIN]), mean=np.zeros(1))
    found.selected = (one._replace(answer=answer),)
    found.prediction = predicted(held, found.prediction.blocks)
    [(coefficients, _)] = deviations(found)
    fixed = 1.0 / np.sqrt(np.sum(np.exp(-2 * SPEED / 0.3))) * NOISE
    assert coefficients[0] == pytest.approx(fixed, rel=0.35)


class Searching(SimpleNamespace):
    """A problem with a constant as its only other unknown."""

    def prediction(self, answers, similar=None):
        columns = np.concatenate([np.ones((COUNT, 1, 1)), *(one.columns.values for one in answers)], axis=2)
        return predicted(rows(self.torque[:, None], columns, np.full(columns.shape[2], 1e3)), self.blocks)


def test_a_shape_far_away_that_predicts_as_well_widens_the_interval_to_it():
    """As of a balancer with its angle mirrored: another speed gives the same torque with half the size."""
    run = SimpleNamespace(torque=np.ones((COUNT, 1)), thinned=lambda columns: columns)

    def twofold(speed: float) -> Candidate:
        column = np.exp(-SPEED / speed) if speed < 1.0 else 2.0 * np.exp(-SPEED * 10.0 / speed)
        return replace(
            fading(speed), columns=lambda run: column[:, None, None],
            reshape=lambda shape: twofold(shape["speed"]), reported={},
        )  # fmt: skip

    def deviation(speeds: tuple[float, ...]) -> tuple[float, float]:
        torque = 2.0 * np.exp(-SPEED / 0.3) + noise(4)
        pairs = [(twofold(speed), Thinned.of(twofold(speed), [run])) for speed in speeds]
        found = searched(twofold(0.3), torque)
        found.problem = Searching(
            runs=(run,), torque=torque, blocks=found.prediction.blocks, pairs=lambda wanted: pairs
        )
        found.prediction = found.problem.prediction([found.selected[0].answer])
        [(coefficients, shape)] = deviations(found)
        return coefficients[0], shape["speed"]

    assert max(deviation((0.1, 0.3))) < 0.05
    # Of three equally probable shapes, one has half the size and ten times the speed.
    assert deviation((0.1, 0.3, 3.0)) == pytest.approx((1.0 / np.sqrt(3.0), 2.7 / np.sqrt(3.0)), rel=0.1)
