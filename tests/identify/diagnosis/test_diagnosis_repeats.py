"""Laps of a repeated motion are left out together, and what repeats in their residual counts once."""

from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis.blocks.blocks import Blocks
from exidyn.identification.diagnosis.blocks.prediction import Prediction
from exidyn.identification.preparation.repeated_motion import first_rows, repeated_share
from tests.parts.small.small_rows import RATE, rows

SECONDS = 10.0  # duration of a lap


def positions(laps, joints=2, seed=1, start=0.0, seconds=SECONDS):
    """A periodic motion of several laps, with the error of a controller, shape (r, n) [rad]."""
    random = np.random.default_rng(seed)
    time = start + np.arange(round(laps * seconds * RATE)) / RATE
    waves = 2 * np.pi * np.arange(1, 6) / seconds
    amplitude, phase = random.normal(size=(2, 5, joints))
    motion = np.sum(amplitude * np.sin(waves[:, None] * time[:, None, None] + phase), axis=1)
    return motion + 0.003 * np.ptp(motion, axis=0) * np.sin(7.3 * time[:, None])


def run(position, role="identify", payload=""):
    return SimpleNamespace(
        rows=len(position),
        role=role,
        prepared=SimpleNamespace(decimation=SimpleNamespace(output_rate=RATE)),
        motion=SimpleNamespace(position=position, payload=payload),
        centres=np.arange(len(position)),
    )


@pytest.mark.parametrize("laps", [3.5, 20.0])
@pytest.mark.parametrize("rows", [0.0, 0.4])
def test_each_lap_is_known_by_the_first_one(laps, rows):
    lap = SECONDS * RATE + rows
    first = first_rows([positions(laps, seconds=lap / RATE)], [0])
    apart = (first - np.arange(len(first)) + lap / 2) % lap - lap / 2
    np.testing.assert_allclose(apart, 0.0, atol=2)


@pytest.mark.parametrize("start", [0.0, 4.0])
def test_a_second_run_of_the_same_motion_is_known_by_the_first_one(start):
    count = round(SECONDS * RATE)
    first = first_rows([positions(1.0), positions(0.6, start=start)], [0, 0])
    expected = np.arange(round(0.6 * count)) + round(start * RATE)
    np.testing.assert_allclose(first[count:], expected, atol=2)


def test_laps_of_a_later_run_are_known_by_an_earlier_one():
    first = first_rows([positions(1.5), positions(2.6, start=3.0)], [0, 0])
    assert np.mean(first == np.arange(len(first))) == pytest.approx(1.0 / 4.1, abs=0.01)


def test_a_run_of_another_kind_repeats_no_other_one():
    first = first_rows([positions(1.0), positions(1.0)], ["", "weight"])
    np.testing.assert_array_equal(first, np.arange(len(first)))


@pytest.mark.parametrize(
    "motion",
    [
        positions(1.0),
        np.cumsum(np.random.default_rng(2).normal(size=(3000, 3)), axis=0),
        np.zeros((500, 2)),
        np.linspace(0.0, 1.0, 2000)[:, None] * [1.0, 2.0],
        np.concatenate([positions(1.0), positions(1.0, seed=2)]),
    ],
    ids=["one lap", "no laps", "standstill", "one way", "two motions"],
)
def test_a_motion_that_does_not_repeat_has_one_lap(motion):
    np.testing.assert_array_equal(first_rows([motion], [0]), np.arange(len(motion)))


def test_joints_that_stand_still_do_not_hide_that_a_motion_repeats():
    noise = 1e-5 * np.random.default_rng(3).normal(size=(3000, 1))
    first = first_rows([np.hstack([positions(3.0), noise])], [0])
    assert np.mean(first == np.arange(len(first))) == pytest.approx(1 / 3, abs=0.01)


def test_blocks_are_those_of_one_lap():
    once, thrice = (Blocks.of([run(positions(laps))], "validate") for laps in (1.0, 3.0))
    assert len(once) == len(thrice)
    assert thrice.seconds == pytest.approx(once.seconds, rel=0.01)
    np.testing.assert_allclose(np.bincount(thrice.number), 3 * np.bincount(once.number), atol=3)


def test_the_end_of_a_run_that_repeats_another_one_is_no_block_of_its_own():
    runs = [run(positions(1.0)), run(np.concatenate([positions(1.0), positions(0.02, seed=2)]))]
    once, both = (Blocks.of(some, "validate") for some in (runs[:1], runs))
    assert len(both) == len(once)
    assert both.number[-1] == both.number[len(once.number) - 1] == len(once) - 1


def test_a_lap_shorter_than_a_block_is_one():
    shaken = np.sin(2 * np.pi * 8.0 * np.arange(2000)[:, None] / RATE + [0.0, 1.0])
    assert len(Blocks.of([run(shaken)], "validate")) == 1


def test_laps_of_fitted_runs_are_counted():
    runs = [run(positions(3.0)), run(positions(1.0, seed=2)), run(positions(3.0), role="validate")]
    assert Blocks.of(runs, "validate").laps == pytest.approx(2.0, rel=0.02)


def predicted(laps, repeats=True):
    """Prediction of a torque whose error repeats with the motion, or does not."""
    position, random = positions(laps), np.random.default_rng(4)
    error = random.normal(size=(len(position), 2))
    if repeats:
        error = error[np.arange(len(position)) % round(SECONDS * RATE)]
    columns = np.sin(position[:, :, None] * [1.0, 2.0])
    given = rows(columns @ [1.0, -2.0] + 0.1 * error, columns, np.full(2, np.inf))
    return Prediction.of(given, Blocks.of([run(position)], "validate"), RATE)


def test_a_block_is_predicted_without_any_of_its_laps():
    prediction = predicted(3.0)
    given, number = prediction.rows, prediction.blocks.number
    left_out = prediction.sums.in_sequence(prediction.sums.residual(prediction.left_out))
    for block in (0, 5, 11):
        inside = number == block
        weight = np.sqrt(prediction.weighting.weight[number[~inside]])
        columns, torque = given.columns[~inside] * weight[:, :, None], given.difference[~inside] * weight
        values = np.linalg.lstsq(columns.reshape(-1, 2), torque.ravel(), rcond=None)[0]
        np.testing.assert_allclose(prediction.left_out[block], values, rtol=1e-6)
        residual = given.difference - given.columns @ values
        np.testing.assert_allclose(left_out[inside], residual[inside], atol=1e-8)


@pytest.mark.parametrize("repeats", [True, False])
def test_what_repeats_counts_once_and_noise_in_each_lap(repeats):
    once, thrice = predicted(1.0), predicted(3.0, repeats)
    evidence = [p.weighting.independent * p.sums.counts.sum(axis=0) for p in (once, thrice)]
    np.testing.assert_allclose(evidence[1] / evidence[0], 1.0 if repeats else 3.0, rtol=0.15)
    std = [np.sqrt(np.diag(p.covariance)) for p in (once, thrice)]
    assert np.mean(std[1] / std[0]) == pytest.approx(1.0 if repeats else 3**-0.5, rel=0.3)


def test_rows_are_sorted_by_block_and_put_back():
    prediction = predicted(2.5)
    sums, values = prediction.sums, np.random.default_rng(5).normal(size=(2, len(prediction.blocks.number)))
    in_order = np.concatenate([sums.sorted([column[None]], joint)[0] for joint, column in enumerate(values)])
    np.testing.assert_allclose(sums.in_sequence(in_order), values.T * prediction.rows.weight)
    squares = np.bincount(prediction.blocks.number, values[1] ** 2 * prediction.rows.weight[:, 1])
    np.testing.assert_allclose(sums.sums(np.square(in_order))[:, 1], squares)
    np.testing.assert_allclose(sums.products_of(in_order, in_order.T)[:, 1, 1], squares)


def test_rows_that_do_not_count_are_no_laps():
    residual = np.concatenate([np.tile(np.ones((50, 1)), (3, 1)), np.zeros((300, 1))]) * [1.0, 0.0]
    assert repeated_share(residual, np.r_[np.arange(150) % 50, 150:450]) == pytest.approx([1 / 3, 1.0])
