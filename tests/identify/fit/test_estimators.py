from dataclasses import replace

import numpy as np
import pytest
from scipy import optimize

from exidyn.identification.errors import NeedsPayload, NotExcited
from exidyn.identification.fit.estimators import ESTIMATORS, consistent, literal, maximum_likelihood, weighted
from exidyn.identification.fit.estimators.compressed import Compressed, solve
from exidyn.identification.fit.estimators.consistent import pseudo_inertia, square, triangle
from exidyn.identification.fit.estimators.covariance import sandwich
from exidyn.identification.fit.estimators.least_squares import (
    finite_tolerance,
    given_nominal,
    prior,
    residual,
    weighted_solution,
)

from ...parts.small.two_joints import GAIN, coloured, equations, white

pytestmark = [pytest.mark.numerical, pytest.mark.slow]

NOISE = np.array([0.02, 0.05])
"""White current noise [A]; torque noise is 0.8 and 1.25 N m, so that weights matter."""
WITH_GAINS = ("literal", "ml")


@pytest.fixture(scope="module")
def exact():
    return equations(rows=600, payload=True)


@pytest.fixture(scope="module")
def system(exact):
    """Noisy, some rows sticking, nominal gains 10 % wrong."""
    noisy = white(exact[0], NOISE)
    weight = np.where(np.random.default_rng(3).uniform(size=noisy.weight.shape) < 0.1, 0.0, 1.0)
    return replace(noisy, weight=weight)


def tall(system):
    """Rows of joint 1, then of joint 2, those that stick left out: regressor, torque, joint."""
    rows, torque, joint = [], [], []
    for j in range(2):
        keep = system.weight[:, j] > 0
        rows.append(system.regressor[keep, j])
        torque.append((system.gain * system.current - system.known)[keep, j])
        joint.append(np.full(keep.sum(), j))
    return np.concatenate(rows), np.concatenate(torque), np.concatenate(joint)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_without_noise_the_truth_comes_out(name, exact):
    system, truth = exact
    if name in WITH_GAINS:
        system = replace(system, gain=GAIN * [1.1, 0.9])
    estimate = ESTIMATORS[name](system)
    np.testing.assert_allclose(estimate.values, truth, rtol=1e-8)
    np.testing.assert_allclose(estimate.gain, GAIN, rtol=1e-8)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_estimates_are_near_the_truth_as_they_state_and_finite(name, exact, system):
    estimate = ESTIMATORS[name](system)
    assert estimate.covariance.shape == (len(exact[1]) + 2,) * 2
    np.testing.assert_allclose(estimate.covariance, estimate.covariance.T, rtol=1e-6, atol=1e-12)
    assert np.all(np.linalg.eigvalsh(estimate.covariance) > -1e-9 * np.trace(estimate.covariance))
    assert np.all(estimate.std > 0)
    # literal: one noise is laid to joints whose noises differ
    limit = 12 if name == "literal" else 4.5
    assert np.max(np.abs(estimate.values - exact[1]) / estimate.std) < limit
    if name in WITH_GAINS:
        assert np.max(np.abs(estimate.gain - GAIN) / estimate.gain_std) < limit
    np.testing.assert_allclose(estimate.noise, NOISE * np.abs(GAIN), rtol=0.15)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_units_of_a_parameter_do_not_matter(name, exact):
    """A column in other units changes its value and nothing else; the literal method alone is not so."""
    system = white(exact[0], NOISE)
    factor = np.ones(len(system.names))
    factor[[0, 3, 8]] = [1e3, 1e-3, 50.0]
    regrouping = system.base.regrouping / factor[:, None]
    scaled = replace(
        system, regressor=system.regressor * factor, base=replace(system.base, regrouping=regrouping)
    )
    plain, other = ESTIMATORS[name](system), ESTIMATORS[name](scaled)
    same = np.allclose(other.values * factor, plain.values, rtol=1e-4, atol=1e-3 * plain.std.min())
    assert same != (name == "literal")


def test_weighted_is_numpys_at_its_own_weights(system):
    rows, torque, joint = tall(system)
    estimate = weighted(system)
    sigma = estimate.noise[joint]
    expected = np.linalg.lstsq(rows / sigma[:, None], torque / sigma)[0]
    np.testing.assert_allclose(estimate.values, expected, rtol=1e-6)
    left = torque - rows @ estimate.values
    for j in range(2):
        freedom = np.sum(joint == j) - len(estimate.values) / 2
        assert estimate.noise[j] == pytest.approx(np.sqrt(np.sum(left[joint == j] ** 2) / freedom), rel=1e-6)
    np.testing.assert_allclose(weighted_solution(system, Compressed.of(system))[1], estimate.noise, rtol=1e-6)


def test_covariance_of_white_noise_is_that_of_least_squares(system):
    """With little colour found, the sandwich is inverse(W^T W / sigma^2)."""
    rows, _, joint = tall(system)
    estimate = weighted(system)
    rows = rows / estimate.noise[joint][:, None]
    plain = np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))
    np.testing.assert_allclose(estimate.std, plain, rtol=0.25)  # colour is estimated, too


def brute_force_sandwich(jacobian, residual, system, lags=60):
    """Bread and meat by their definitions, with the exact autocovariance of tests.two_joints.coloured."""
    from .test_colored_noise import exact_autocovariance

    gamma = exact_autocovariance(lags) * np.outer(GAIN, GAIN)
    counts = system.weight.sum(axis=0)
    variance = np.sum(system.weight * residual**2, axis=0) / (counts - jacobian.shape[2] / 2)
    moved = jacobian * (system.weight / variance)[:, :, None]
    bread = np.einsum("rnk,rnl->kl", moved, jacobian)
    meat = np.zeros_like(bread)
    for run in system.runs:
        part = moved[run]
        for lag in range(lags + 1):
            stop = len(part) - lag
            term = np.einsum("tik,ij,tjl->kl", part[lag:], gamma[lag], part[:stop])
            meat += term if lag == 0 else term + term.T
    return np.linalg.solve(bread, np.linalg.solve(bread, meat).T)


def test_what_repeats_in_each_lap_is_counted_once(system):
    [columns, residual] = np.random.default_rng(4).normal(size=(2, len(system.weight) // 4, 2, 2))
    columns, residual = np.tile(columns, (4, 1, 1)), np.tile(residual[:, :, 0], (4, 1))
    once = replace(system, weight=np.ones_like(system.weight))
    laps = replace(once, first=np.arange(len(residual)) % (len(residual) // 4))
    counted = [np.diag(sandwich(columns, residual, one).covariance) for one in (once, laps)]
    np.testing.assert_allclose(counted[1] / counted[0], 4.0, rtol=0.1)


def test_columns_that_are_alike_to_nine_digits_keep_their_variances(system):
    one, other, residual = np.random.default_rng(3).normal(size=(3, *system.weight.shape))
    apart = sandwich(np.stack([one, other], axis=2), residual, system).covariance
    alike = sandwich(np.stack([one, one + 1e-9 * other], axis=2), residual, system).covariance
    change = np.array([[1.0, -1.0], [0.0, 1.0]]) / [1.0, 1e-9]
    np.testing.assert_allclose(alike, change @ apart @ change.T, rtol=1e-3)


@pytest.mark.once
def test_sandwich_is_the_sum_over_lags_of_the_known_colour():
    system, truth = equations(rows=6000)
    random = np.random.default_rng(5)
    noise = [coloured(run.stop - run.start, random) for run in system.runs]
    weight = np.where(random.uniform(size=system.weight.shape) < 0.05, 0.0, 1.0)
    system = replace(system, current=system.current + np.concatenate(noise), weight=weight)
    left = residual(system, truth, GAIN)
    found = np.sqrt(np.diag(sandwich(system.regressor, left, system).covariance))
    expected = np.sqrt(np.diag(brute_force_sandwich(system.regressor, left, system)))
    np.testing.assert_allclose(found, expected, rtol=0.15)  # six thousand rows give the colour to some 10 %
    rows = (system.regressor * system.weight[:, :, None] / np.std(left, axis=0)[:, None]).reshape(
        -1, len(truth)
    )
    assert np.median(found / np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))) > 1.5


def test_stated_deviations_of_a_short_run_are_those_of_estimates_from_other_noise():
    """Its slow columns follow coloured noise, so that the residual has less of it than there was."""
    exact, truth = equations(rows=240)
    estimates = []
    for seed in range(150):
        random = np.random.default_rng(seed)
        noise = np.concatenate([coloured(run.stop - run.start, random) for run in exact.runs])
        estimates.append(weighted(replace(exact, current=exact.current + noise)))
    spread = np.sqrt(np.mean([(one.values - truth) ** 2 for one in estimates], axis=0))
    stated = np.sqrt(np.mean([one.std**2 for one in estimates], axis=0))
    assert np.median(stated / spread) == pytest.approx(1.0, abs=0.07)


def test_each_run_counts_with_its_own_noise():
    """The second run, which alone shows the payload, is four times as noisy as the first."""
    system, truth = equations(rows=6000, payload=True)
    spread = np.ones((6000, 1))
    spread[system.runs[1]] = 4.0
    left = 0.5 * spread * np.random.default_rng(6).normal(size=system.current.shape)
    found = np.sqrt(np.diag(sandwich(system.regressor, left, system).covariance))
    rows, each = system.regressor.reshape(-1, len(truth)), np.repeat(0.25 * spread[:, 0] ** 2, 2)
    bread = np.linalg.inv(rows.T @ rows)
    expected = np.sqrt(np.diag(bread @ (rows.T * each) @ rows @ bread))
    # one level for both runs would make the payload's 0.73 of this
    np.testing.assert_allclose(found, expected, rtol=0.15)


def test_gram_with_known_colour_is_the_double_sum():
    from scipy import signal

    from exidyn.identification.fit.estimators.covariance import _colored_gram

    from .test_colored_noise import exact_autocovariance

    known = exact_autocovariance(12)
    gamma = np.zeros((121, 2, 2))
    gamma[:13] = known * signal.windows.parzen(25)[12:, None, None]
    rows = np.random.default_rng(8).normal(size=(121, 2, 3))
    rows[:, :, 1] = np.linspace(0, 1, 121)[:, None] ** [1, 2]
    expected = np.zeros((3, 3))
    for k in range(121):
        for m in range(121):
            lag = gamma[k - m] if k >= m else gamma[m - k].T
            expected += rows[k].T @ lag @ rows[m]
    found = _colored_gram(rows, known, np.zeros((242, 2)))
    np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())


def test_segments_of_a_long_run_change_the_sandwich_little(monkeypatch):
    from exidyn.identification.fit.estimators import covariance

    system, truth = equations(rows=4000)
    random = np.random.default_rng(6)
    system = replace(system, current=system.current + coloured(4000, random), runs=(slice(0, 4000),))
    left = residual(system, truth, GAIN)
    monkeypatch.setattr(covariance, "SEGMENT", 10**6)
    whole = np.diag(sandwich(system.regressor, left, system).covariance)
    monkeypatch.setattr(covariance, "SEGMENT", 500)
    cut = np.diag(sandwich(system.regressor, left, system).covariance)
    np.testing.assert_allclose(cut, whole, rtol=0.05)


def test_maximum_likelihood_is_scipys_in_current_space(exact):
    system = white(exact[0], NOISE)
    estimate = maximum_likelihood(system)
    sigma = estimate.noise / np.abs(estimate.gain)
    count = len(estimate.values)

    def misfit(unknown):
        predicted = (system.regressor @ unknown[:count] + system.known) / unknown[count:]
        return ((system.current - predicted) / sigma).ravel()

    start = np.concatenate([exact[1] * 1.2 + 0.01, GAIN * 0.8])
    found = optimize.least_squares(misfit, start, x_scale=np.abs(start), xtol=1e-14, ftol=1e-14, gtol=1e-14)
    np.testing.assert_allclose(estimate.gain, found.x[count:], rtol=1e-6)
    np.testing.assert_allclose(estimate.values, found.x[:count], atol=1e-4 * estimate.std.min(), rtol=1e-6)
    covariance = np.linalg.inv(found.jac.T @ found.jac)
    plain, own = np.sqrt(np.diag(covariance)), np.concatenate([estimate.std, estimate.gain_std])
    np.testing.assert_allclose(own, plain, rtol=0.3)
    correlation, expected = estimate.covariance / np.outer(own, own), covariance / np.outer(plain, plain)
    np.testing.assert_allclose(correlation, expected, atol=0.3)
    strong = np.abs(expected) > 0.5
    assert np.all(np.sign(correlation[strong]) == np.sign(expected[strong]))
    assert np.any(strong[:count, count:])


def uncompressed(system):
    """The paper's (13), rows of joint 1 then joint 2."""
    blocks = []
    for j in range(2):
        keep = system.weight[:, j] > 0
        currents = np.zeros((keep.sum(), 2))
        currents[:, j] = system.current[keep, j]
        blocks.append(np.column_stack([currents, -system.regressor[keep, j], -system.known[keep, j]]))
    return np.concatenate(blocks)


def test_literal_is_the_papers_12_to_21(system):
    matrix = uncompressed(system)
    rows, columns = matrix.shape
    left, singular, right = np.linalg.svd(matrix, full_matrices=False)
    unknowns = right[-1] / right[-1, -1]
    estimate = literal(system)
    np.testing.assert_allclose(estimate.gain, unknowns[:2], rtol=1e-7)
    np.testing.assert_allclose(estimate.values, unknowns[2:-1], rtol=1e-6, atol=1e-9)
    compatible = matrix - singular[-1] * np.outer(left[:, -1], right[-1])  # (17)
    sigma = singular[-1] / np.sqrt(rows - columns)  # (19)
    gram = compatible[:, :-1].T @ compatible[:, :-1]
    covariance = sigma**2 * (1 + np.sum(unknowns[:-1] ** 2)) * np.linalg.inv(gram)  # (20)
    deviation = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(estimate.gain_std, deviation[:2], rtol=1e-5)
    np.testing.assert_allclose(estimate.std, deviation[2:], rtol=1e-5)


def test_signs_of_gains_are_found(exact):
    system = replace(white(exact[0], NOISE), gain=np.abs(GAIN))
    assert np.all(np.sign(maximum_likelihood(system).gain) == np.sign(GAIN))


def test_torque_with_noisy_currents_as_regressors_is_biased_and_likelihood_is_not(exact):
    """What makes total least squares necessary: least squares pulls the gains down."""
    loud = white(exact[0], 5 * NOISE, seed=9)
    matrix = uncompressed(loud)
    shrunk = np.linalg.lstsq(matrix[:, :-1], -matrix[:, -1])[0][:2]
    unbiased = maximum_likelihood(loud)
    assert np.all(np.abs(shrunk) < np.abs(GAIN) * 0.97)
    assert np.all(np.abs(unbiased.gain - GAIN) < 3 * unbiased.gain_std)


@pytest.mark.parametrize("name", WITH_GAINS)
def test_gains_need_a_known_payload_and_currents(name):
    system, _ = equations(rows=200)
    with pytest.raises(NeedsPayload, match="known mass"):
        ESTIMATORS[name](white(system, NOISE))
    system, _ = equations(rows=200, payload=True)
    with pytest.raises(NeedsPayload, match="torque was recorded"):
        ESTIMATORS[name](replace(white(system, NOISE), gain_known=True))


def nominal(system, truth_is_off=0.0):
    """Priors about every parameter, some off."""
    tolerance = np.maximum(0.1 * np.abs(system.nominal), 0.01)
    return replace(system, tolerance=tolerance, nominal=system.nominal + truth_is_off * tolerance)


def unconstrained(system):
    """Most probable base and standard parameters of any sign, by the stacked normal equations."""
    data, (mean, spread) = weighted(system), prior(system)
    precision = np.linalg.inv(given_nominal(data))
    right = precision @ data.values + np.linalg.solve(spread, mean)
    values = np.linalg.solve(precision + np.linalg.inv(spread), right)
    deviation = finite_tolerance(system)
    change = np.linalg.lstsq(system.base.regrouping * deviation, values - mean)[0]
    return values, system.nominal + deviation * change


def test_prior_is_that_of_the_standard_parameters(system):
    system = nominal(system)
    draws = system.nominal + system.tolerance * np.random.default_rng(0).normal(
        size=(20_000, len(system.tolerance))
    )
    base = draws @ system.base.regrouping.T
    mean, deviation = prior(system)
    np.testing.assert_allclose(mean, base.mean(axis=0), atol=5 * np.sqrt(np.diag(deviation).max() / 20_000))
    np.testing.assert_allclose(np.sqrt(np.diag(deviation)), base.std(axis=0), rtol=0.03)
    correlation = deviation / np.sqrt(np.outer(np.diag(deviation), np.diag(deviation)))
    np.testing.assert_allclose(correlation, np.corrcoef(base.T), atol=0.04)


def test_loose_tolerance_is_far_above_what_data_state(system):
    loose = finite_tolerance(system)[system.base.kept]
    assert np.all(loose > 100 * weighted(system).std)
    assert np.all(np.isfinite(finite_tolerance(system)))


@pytest.mark.parametrize("off", [0.0, 3.0])
@pytest.mark.parametrize("noise", [0.0, 1.0, 100.0, 1000.0])
def test_consistent_bodies_can_exist(exact, noise, off):
    system = nominal(white(exact[0], noise * NOISE), off)
    estimate = consistent(system)
    for body in system.bodies:
        eigenvalues = np.linalg.eigvalsh(pseudo_inertia(estimate.standard[body]))
        assert eigenvalues.min() > 0.5e-6 * np.abs(estimate.standard[body]).max()
    for value, parameter in zip(estimate.standard, system.base.parameters, strict=True):
        if parameter.name[:2] in ("Fv", "Fc"):
            assert value > -1e-9
    np.testing.assert_allclose(
        system.base.regrouping @ estimate.standard, estimate.values, rtol=1e-9, atol=1e-9
    )


def test_consistent_is_unconstrained_where_that_is_consistent(exact):
    system = white(exact[0], 0.1 * NOISE)
    unknown = np.arange(len(system.nominal)) >= 20  # friction, offsets and the payload
    held = 0.01 * np.maximum(np.abs(system.nominal), 0.01)
    system = replace(system, tolerance=np.where(unknown, np.inf, held))
    (values, standard), estimate = unconstrained(system), consistent(system)
    assert all(np.linalg.eigvalsh(pseudo_inertia(standard[body])).min() > 0 for body in system.bodies)
    np.testing.assert_allclose(estimate.values, values, rtol=1e-6, atol=1e-5 * estimate.std.min())


def test_consistent_is_weighted_without_priors_where_that_is_consistent(exact):
    system = white(exact[0], 0.1 * NOISE)
    free, estimate = weighted(system), consistent(system)
    np.testing.assert_allclose(estimate.values, free.values, atol=1e-3 * free.std.min())


def test_consistent_is_the_nearest_consistent(exact):
    """Negative friction in the data: no step from the answer that stays consistent comes nearer."""
    system = nominal(white(exact[0], 40 * NOISE, seed=1), 2.0)
    (_, free), estimate, data = unconstrained(system), consistent(system), weighted(system)
    count = len(data.values)
    precision = np.linalg.inv(data.covariance[:count, :count])
    tolerance = finite_tolerance(system)

    def cost(standard):
        wrong = system.base.regrouping @ standard - data.values
        return wrong @ precision @ wrong + np.sum(((standard - system.nominal) / tolerance) ** 2)

    def possible(standard):
        bodies = all(np.linalg.eigvalsh(pseudo_inertia(standard[body])).min() > 0 for body in system.bodies)
        least = [-np.inf if k < 20 else p.minimum for k, p in enumerate(system.base.parameters)]
        return bodies and np.all(standard >= least)

    assert not possible(free)
    assert possible(estimate.standard + 1e-9 * np.eye(len(tolerance))[:, 20:].sum(axis=1))
    best, random = cost(estimate.standard), np.random.default_rng(2)
    assert best > cost(free)
    tried = 0
    for _ in range(3000):
        size = 10.0 ** random.uniform(-4, 0)
        toward = random.uniform() * (free - estimate.standard)
        near = estimate.standard + size * (toward + 0.3 * tolerance * random.normal(size=len(tolerance)))
        if possible(near):
            tried += 1
            assert cost(near) > best - 1e-3 * abs(best)
    assert tried > 20


def test_triangle_and_square_are_inverse_and_keep_inner_products():
    random = np.random.default_rng(0)
    a, b = random.normal(size=(2, 4, 4))
    a, b = a + a.T, b + b.T
    np.testing.assert_allclose(square(triangle(a)), a)
    assert triangle(a) @ triangle(b) == pytest.approx(np.trace(a @ b))


def test_compression_keeps_every_residual(system):
    compressed = Compressed.of(system)
    rows, torque, joint = tall(system)
    for seed in range(3):
        values = np.random.default_rng(seed).normal(size=len(system.names))
        for j in range(2):
            small = compressed.torque(j, GAIN) - compressed.regressor(j) @ values
            large = (torque - rows @ values)[joint == j]
            assert np.linalg.norm(small) == pytest.approx(np.linalg.norm(large), rel=1e-10)
    np.testing.assert_array_equal(compressed.counts, system.weight.sum(axis=0))


def test_a_joint_that_sticks_is_named(system):
    weight = system.weight.copy()
    weight[5:, 1] = 0.0
    with pytest.raises(NotExcited, match="joint 2 slides in only"):
        weighted(replace(system, weight=weight))


def test_columns_that_are_not_distinguished_are_named():
    rows = np.random.default_rng(0).normal(size=(30, 3))
    with pytest.raises(NotExcited, match="does not reveal b"):
        solve(rows * [1.0, 0.0, 1.0], rows[:, 0], ["a", "b", "c"])
    rows[:, 2] = rows[:, 0] - 2 * rows[:, 1]
    with pytest.raises(NotExcited, match="does not distinguish c"):
        solve(rows, rows[:, 0], ["a", "b", "c"])


@pytest.mark.parametrize("name", [n for n in ESTIMATORS if n not in WITH_GAINS])
def test_gains_that_are_known_are_passed_through_with_no_deviation(name, system):
    estimate = ESTIMATORS[name](replace(system, gain_known=True, gain_tolerance=0.0))
    np.testing.assert_array_equal(estimate.gain, GAIN)
    assert not np.any(estimate.gain_std)
