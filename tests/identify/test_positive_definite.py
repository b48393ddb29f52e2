"""Factors of normal matrices and covariances of any rank and size."""

import numpy as np
import pytest
from scipy import linalg

from exidyn.identification.errors import FitError
from exidyn.identification.positive_definite import (
    ROUNDING,
    after_unit_prior,
    factored,
    inverse,
    root,
    solve,
    spectrum,
    whitening,
)

COUNT = 7


def well(random, decades=0.0):
    """A well conditioned matrix, its unknowns in units that differ by so many decades."""
    rows = random.normal(size=(4 * COUNT, COUNT)) * 10.0 ** random.uniform(-decades, decades, COUNT)
    return rows.T @ rows


def singular(random, rank, decades=0.0):
    rows = random.normal(size=(rank, COUNT)) * 10.0 ** random.uniform(-decades, decades, COUNT)
    return rows.T @ rows


@pytest.fixture(params=range(5))
def random(request):
    return np.random.default_rng(request.param)


def test_where_cholesky_works_it_is_the_same(random):
    matrix, right = well(random, 3.0), random.normal(size=(COUNT, 2))
    factor = factored(matrix)
    assert np.allclose(root(matrix), np.linalg.cholesky(matrix), rtol=1e-10, atol=0.0)
    expected = linalg.cho_solve(linalg.cho_factor(matrix), right)
    assert np.allclose(
        solve(factor, right), expected, rtol=1e-8, atol=1e-10 * np.abs(expected).max(axis=1)[:, None]
    )
    assert np.allclose(solve(factor, right[:, 0]), solve(factor, right)[:, 0], rtol=1e-12)
    size = np.sqrt(np.diag(np.linalg.inv(matrix)))
    assert np.allclose(
        inverse(matrix) / np.outer(size, size), np.linalg.inv(matrix) / np.outer(size, size), atol=1e-9
    )


def test_where_cholesky_works_the_diagnosis_is_the_same_bit_for_bit(random):
    matrix, right = singular(random, COUNT - 2, 3.0), random.normal(size=COUNT)
    scale = 1.0 / np.sqrt(np.diag(matrix))
    scaled = matrix * scale[:, None] * scale + 1e-9 * np.eye(COUNT)
    expected = scale * linalg.cho_solve(linalg.cho_factor(scaled), scale * right)
    assert np.array_equal(solve(factored(matrix, 1e-9), right), expected)


def test_whitened_unknowns_are_independent(random):
    matrix = well(random, 3.0)
    rows = whitening(factored(matrix))
    assert np.allclose(rows @ matrix @ rows.T, np.eye(COUNT), atol=1e-9)


@pytest.mark.parametrize("size", [1.0, 1e-6, 1e150, 1e300])
@pytest.mark.parametrize("rank", [1, 3, COUNT - 1])
def test_a_singular_matrix_has_a_factor(random, rank, size):
    matrix = size * singular(random, rank)
    lower = root(matrix) / np.sqrt(size)
    assert np.all(np.diag(lower) > 0.0)
    assert np.allclose(lower, np.tril(lower))
    assert np.allclose(lower @ lower.T, matrix / size, atol=1e-9 * np.max(matrix / size))


def test_singular_systems_are_solved_as_far_as_they_can_be(random):
    matrix = singular(random, 3)
    right = matrix @ random.normal(size=COUNT)
    assert np.allclose(matrix @ solve(factored(matrix), right), right, atol=1e-2 * np.abs(right).max())
    held = solve(factored(matrix, 1e-9), right)
    assert np.allclose(matrix @ held, right, atol=1e-6 * np.abs(right).max())
    matrix, right = well(random), random.normal(size=COUNT)
    matrix[4], matrix[:, 4], right[4] = 0.0, 0.0, 0.0
    rest = np.delete(np.arange(COUNT), 4)
    factor = factored(matrix)
    found = solve(factor, right)
    assert np.allclose(found[rest], np.linalg.solve(matrix[np.ix_(rest, rest)], right[rest]), rtol=1e-8)
    assert found[4] == 0.0


def test_nearly_singular_and_slightly_negative_matrices_have_a_factor(random):
    axes = np.linalg.qr(random.normal(size=(COUNT, COUNT)))[0]
    for least in (1e-13, 1e-17, 0.0, -1e-17, -1e-12, -1e-9):
        values = np.append(np.ones(COUNT - 1), least)
        matrix = (axes * values) @ axes.T
        lower = root(0.5 * (matrix + matrix.T))
        assert np.all(np.isfinite(lower))
        assert np.allclose(lower @ lower.T, matrix, atol=1e-8)
        assert np.all(np.isfinite(whitening(factored(matrix))))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused_in_one_line(random, value):
    matrix = well(random)
    matrix[1, 2] = matrix[2, 1] = value
    for use in (factored, root, inverse, spectrum):
        with np.errstate(invalid="ignore"), pytest.raises(FitError, match="not finite"):
            use(matrix)


def test_eigenvalues_are_above_rounding(random):
    values, axes = spectrum(singular(random, 3))
    assert np.all(values >= ROUNDING)
    assert np.allclose(axes @ axes.T, np.eye(COUNT))


def test_rows_beside_a_unit_prior(random):
    rows = random.normal(size=(3, COUNT))
    expected = np.linalg.inv(rows.T @ rows + np.eye(COUNT))
    assert np.allclose(after_unit_prior(rows), expected, atol=1e-12)
    more = random.normal(size=(3 * COUNT, COUNT))
    assert np.allclose(after_unit_prior(more), np.linalg.inv(more.T @ more + np.eye(COUNT)), atol=1e-12)


@pytest.mark.parametrize("size", [1e6, 1e9, 1e12, 1e200])
def test_a_prior_survives_beside_certain_rows(size):
    rows = np.zeros((2, 4))
    rows[0, :2], rows[1, 2] = size, size
    left = after_unit_prior(rows)
    assert np.allclose(np.diag(left), [0.5, 0.5, 0.0, 1.0], atol=1e-12)
    assert left[0, 1] == pytest.approx(-0.5)
    assert np.all(np.linalg.eigvalsh(left) > -1e-12)


def test_rows_that_are_not_finite_are_refused():
    with pytest.raises(FitError, match="too small"):
        after_unit_prior(np.array([[np.inf, 1.0]]))
