"""Deviations of a finding's numbers, its shape's among them, against those of a nonlinear fit."""

from collections.abc import Mapping
from types import SimpleNamespace

import numpy as np
import pytest
from exidyn.identify.diagnosis.candidate import Candidate, Thinned
from exidyn.identify.diagnosis.found import Found
from exidyn.identify.diagnosis.hypothesis import Hypothesis
from exidyn.identify.diagnosis.rows import Rows
from exidyn.identify.diagnosis.shape_doubt import doubts
from exidyn.identify.diagnosis.solution import Solution
from exidyn.identify.diagnosis.whitening import Whitening
from exidyn.identify.effects import Shape
from scipy import optimize

SPEED = np.linspace(0.0, 1.0, 400)
NOISE = 0.05


def fading(speed: float) -> Candidate:
    """Friction that fades with speed."""

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return fading(given["speed"])

    return Candidate(
        "stribeck_friction", (0,), lambda run: np.exp(-SPEED / speed)[:, None, None], ("Fs",), ("N m",),
        (0.0,), {"speed": speed}, {"speed": Shape("rad/s", 0.01, 10.0)}, reshaped,
        told={"half": (speed * np.log(2.0), "rad/s")},
    )  # fmt: skip


def searched(candidate: Candidate, torque: np.ndarray) -> SimpleNamespace:
    """What a search has come to that has found it, and nothing else."""
    run = SimpleNamespace(torque=np.ones((len(SPEED), 1)), thinned=lambda columns: columns)
    columns = Thinned.of(candidate, [run])
    whole = (slice(0, len(SPEED)),)
    rows = Rows(
        whole,
        torque[:, None],
        np.ones((len(SPEED), 1)),
        columns.values,
        ("Fs",),
        np.array([np.inf]),
        np.zeros(1),
    )
    whitening = Whitening.of(torque[:, None] - columns.values[:, 0] * 2.0, rows.weight, whole, order=0)
    hypothesis = Hypothesis(candidate, columns, np.array([2.0]), 100.0, 100.0)
    found = (Found(hypothesis, (), 100.0),)
    return SimpleNamespace(rows=rows, solution=Solution(rows, whitening), found=found, runs=(run,))


def test_a_shape_that_was_chosen_leaves_the_doubt_of_a_fit_that_varies_it():
    torque = 2.0 * np.exp(-SPEED / 0.3) + NOISE * np.random.default_rng(1).normal(size=len(SPEED))
    values, covariance = optimize.curve_fit(
        lambda x, height, speed: height * np.exp(-x / speed), SPEED, torque, (2.0, 0.3)
    )
    [doubt] = doubts(searched(fading(values[1]), torque))
    height, speed = np.sqrt(np.diag(covariance))
    assert doubt.values[0] == pytest.approx(height, rel=0.03)
    assert doubt.shape["speed"] == pytest.approx(speed, rel=0.03)
    assert doubt.shape["half"] == pytest.approx(speed * np.log(2.0), rel=0.03)


def test_without_a_shape_the_doubt_is_the_solutions():
    plain = Candidate(
        "viscous_friction", (0,), lambda run: SPEED[:, None, None], ("Fs",), ("N m s/rad",), (0.0,)
    )
    found = searched(plain, 2.0 * SPEED + NOISE * np.random.default_rng(2).normal(size=len(SPEED)))
    [doubt] = doubts(found)
    assert doubt.values[0] == pytest.approx(np.sqrt(found.solution.covariance[0, 0]))
    assert not doubt.shape
