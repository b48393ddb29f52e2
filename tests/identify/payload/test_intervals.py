"""Intervals of random estimates hold the truth in 95 %, whatever the mass."""

import numpy as np
import pytest

from exidyn.identification.payload.body import Body, consistent_body, intervals

from .arms import TOOL

DRAWS = 300
"""Their share of 95 % scatters by 1.3 %."""


@pytest.mark.parametrize("scale", [0.02, 0.3])
def test_intervals_hold_the_truth_in_95_percent(scale: float) -> None:
    random, truth = np.random.default_rng(0), TOOL.parameters
    std = scale * np.array([0.05, 0.03, 0.03, 0.05, 0.03, 0.05, 0.1, 0.1, 0.3, 1.0])
    held = []
    for _ in range(DRAWS):
        estimate = truth + std * random.normal(size=10)
        body = Body.of(consistent_body(estimate, np.diag(std**2)))
        result = intervals(estimate, np.diag(std**2), body)
        values = [TOOL.mass, *TOOL.center, *TOOL.inertia[np.triu_indices(3)]]
        together = [result.mass, *result.center, *result.inertia]
        held.append([interval.holds(value) for interval, value in zip(together, values, strict=True)])
    share = np.mean(held, axis=0)
    assert np.all(share > 0.91)
    assert np.all(share[:4] < 0.98)


def test_a_mass_that_may_be_zero_leaves_the_center_open() -> None:
    estimate, std = TOOL.parameters, np.full(10, 0.01)
    std[-1] = 2.0
    body = Body.of(consistent_body(estimate, np.diag(std**2)))
    result = intervals(estimate, np.diag(std**2), body)
    assert result.mass.low == 0.0
    assert all(np.isinf(interval.half) for interval in result.center)
    assert all(np.isinf(interval.high) for interval in result.inertia)


def test_an_impossible_estimate_becomes_a_body_near_it() -> None:
    estimate, std = TOOL.parameters.copy(), np.full(10, 0.01)
    estimate[3] = -0.05  # a negative moment of inertia
    values = consistent_body(estimate, np.diag(std**2))
    assert np.all(np.linalg.eigvalsh(Body.of(values).inertia) > 0.0)
    assert abs(values[-1] - estimate[-1]) < 0.05
