"""Sequential quadratic programming, beside SciPy's on small problems, and where it must hold on."""

import numpy as np
import pytest
from scipy.optimize import minimize, rosen, rosen_der

from exidyn.trajectories.search import sqp
from exidyn.trajectories.search.sqp import Function

pytestmark = pytest.mark.numerical

SIZE = 6


def function(value, slope):
    return Function(lambda at: (value(at), lambda: slope(at)))


def bounds(value, slope):
    return Function(lambda at: (value(at), lambda rows: slope(at)[rows]))


def quadratic(seed=0, spread=3.0):
    """Value, slope and matrix of a convex one whose curvatures differ by ten to the `spread`."""
    random = np.random.default_rng(seed)
    turn = np.linalg.qr(random.normal(size=(SIZE, SIZE)))[0]
    matrix, centre = (turn * np.logspace(0, spread, SIZE)) @ turn.T, random.normal(size=SIZE)
    return lambda x: 0.5 * (x - centre) @ matrix @ (x - centre), lambda x: matrix @ (x - centre), matrix


WALLS = np.random.default_rng(1).normal(size=(40, SIZE))


def inside_walls(x):
    """Forty half-spaces about the origin, shape (40,)."""
    return 0.3 - WALLS @ x


def run(of, within, start, steps=200, gain=1e-12, curvature=None):
    """All iterates and the last curvature."""
    curvature = np.eye(len(start)) if curvature is None else curvature
    found = list(sqp.minimize(of, within, start, curvature, steps, gain))
    return [at for at, _ in found], found[-1][1]


def by_scipy(value, slope, margin, by, start):
    rows = {"type": "ineq", "fun": margin, "jac": by}
    return minimize(value, start, jac=slope, method="SLSQP", constraints=[rows], options={"ftol": 1e-14}).x


@pytest.mark.parametrize(
    ("margin", "by"),
    [(inside_walls, lambda x: -WALLS), (lambda x: np.array([0.5 - x @ x]), lambda x: -2.0 * x[None])],
    ids=["walls", "ball"],
)
@pytest.mark.parametrize("far", [0.0, 3.0], ids=["from inside", "from outside"])
def test_it_ends_where_scipy_ends(margin, by, far):
    value, slope, _ = quadratic()
    start = np.full(SIZE, far)
    iterates, _ = run(function(value, slope), bounds(margin, by), start)
    expected = by_scipy(value, slope, margin, by, np.zeros(SIZE))
    assert value(iterates[-1]) == pytest.approx(value(expected), rel=1e-6)
    np.testing.assert_allclose(iterates[-1], expected, atol=1e-4)
    assert margin(iterates[-1]).min() > -1e-6
    values = [value(at) for at in iterates if margin(at).min() >= 0.0]
    assert far or margin is not inside_walls or np.all(np.diff(values) < 0)


def test_what_was_learnt_serves_the_next_function():
    """The minimum of a function with the same curvature is a few steps away."""
    value, slope, matrix = quadratic(spread=2.0)
    free = bounds(lambda x: np.ones(1), lambda x: np.zeros((1, SIZE)))
    iterates, learnt = run(function(value, slope), free, np.zeros(SIZE))
    np.testing.assert_allclose(learnt, matrix, rtol=0.3, atol=0.3 * np.abs(matrix).max())
    shift = np.full(SIZE, 0.3)
    moved = function(lambda x: value(x - shift), lambda x: slope(x - shift))
    assert len(run(moved, free, iterates[-1], curvature=learnt)[0]) < len(run(moved, free, iterates[-1])[0])


def test_bounds_without_a_point_inside_end_without_one():
    """Two walls that exclude one another: the worst violation is made as small as it can be."""
    walls = np.array([[1.0, 0.0], [-1.0, 0.0]])
    within = bounds(lambda x: walls @ x - 1.0, lambda x: walls)
    iterates, _ = run(function(rosen, rosen_der), within, np.array([2.0, 0.5]), steps=60)
    assert np.min(walls @ iterates[-1] - 1.0) == pytest.approx(-1.0, abs=1e-3)


def test_a_solver_without_an_answer_is_asked_once_more_without_what_was_learnt(monkeypatch):
    value, slope, _ = quadratic()
    asked = []

    def fails(hessian, *others):
        asked.append(hessian[:-1, :-1].copy())
        return np.zeros(SIZE + 1), 0.0, -1, {}

    monkeypatch.setattr(sqp.daqp, "solve", fails)
    free = bounds(lambda x: np.ones(1), lambda x: np.zeros((1, SIZE)))
    assert list(sqp.minimize(function(value, slope), free, np.zeros(SIZE), 3.0 * np.eye(SIZE), 9, 1e-9)) == []
    np.testing.assert_array_equal(asked, [3.0 * np.eye(SIZE), np.eye(SIZE)])


def test_rows_far_from_their_bound_are_left_out(monkeypatch):
    value, slope, _ = quadratic()
    sizes, solver = [], sqp.daqp.solve

    def seen(hessian, gradient, table, *others):
        sizes.append(len(table))
        return solver(hessian, gradient, table, *others)

    monkeypatch.setattr(sqp.daqp, "solve", seen)
    far = np.concatenate([np.full(40, 0.3), np.full(500, 50.0)])
    every = np.concatenate([WALLS, np.random.default_rng(2).normal(size=(500, SIZE))])
    iterates, _ = run(
        function(value, slope), bounds(lambda x: far - every @ x, lambda x: -every), np.zeros(SIZE)
    )
    near, _ = run(function(value, slope), bounds(inside_walls, lambda x: -WALLS), np.zeros(SIZE))
    assert max(sizes) <= 40
    np.testing.assert_allclose(iterates[-1], near[-1], atol=1e-12)


def test_a_valley_that_bends_within_a_ball():
    within = bounds(lambda x: np.array([2.0 - x @ x]), lambda x: -2.0 * x[None])
    iterates, _ = run(function(rosen, rosen_der), within, np.array([-1.0, 0.5]))
    np.testing.assert_allclose(iterates[-1], [1.0, 1.0], atol=1e-4)
