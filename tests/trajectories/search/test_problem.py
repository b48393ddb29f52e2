"""Problem: the basis against the series it stands for, and gradients by the coefficients."""

from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest

from exidyn.identification.effects import (
    LoadDependentFriction,
    Payload,
    Prior,
    RigidBody,
    StribeckFriction,
    known_parameters,
)
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.clearances.region import Region, box
from exidyn.trajectories.search.experiment import Experiment, design_model, with_drive_gains, with_shapes
from exidyn.trajectories.search.goals import Focus, Informative, average, condition, volume, worst
from exidyn.trajectories.search.problem import Basis, ClearanceBound, Problem, kinematic_bounds
from exidyn.trajectories.search.torque_bound import TorqueBound
from exidyn.trajectories.trajectory import UNITS

from ...parts.plans.excitation import along, coefficients, limits, small_basis, smooth_model
from ...parts.runs.robots import sliding

BODY = known_parameters(3.0, (0.1, 0.0, 0.05))
FRICTION = {"Fc1": Prior(4.0), "Fc2": Prior(2.0), "Fv1": Prior(3.0), "Fs1": Prior(2.0)}


@pytest.mark.parametrize("series", [1, 3])
def test_basis_is_the_series_at_its_samples_and_coefficients_are_its_inverse(series):
    basis = small_basis(series)
    expected = coefficients(basis, 2)
    states, parts = basis.states(expected), basis.fourier(expected)
    assert states.position.shape == (series * basis.samples, 2)
    assert len(parts) == series
    for number, part in enumerate(parts):
        rows = slice(number * basis.samples, (number + 1) * basis.samples)
        for kind, values in zip(UNITS, part.at(basis.time[: basis.samples])[1:], strict=True):
            largest = max(np.abs(values).max(), 1.0)
            np.testing.assert_allclose(getattr(states, kind)[rows], values, rtol=0, atol=1e-12 * largest)
    np.testing.assert_array_equal(basis.coefficients(parts), expected)
    np.testing.assert_array_equal(basis.motion(expected).time, basis.time)
    waves = [[1, 0, 1], [1, 1, 0], [1, 0, -1], [1, -1, 0]]  # constant, sine, cosine of one harmonic
    np.testing.assert_allclose(Basis(2.0, 1, 4).matrices[0], waves, atol=1e-15)


def test_unknowns_are_coefficients_over_the_scale():
    problem = Problem(small_basis(), (), (), 1, np.array([0.5, 2.0]))
    given = coefficients(problem.basis, 2)
    unknowns = problem.unknowns(given)
    np.testing.assert_allclose(
        unknowns[:4], [given[0, 0] / 0.5, given[0, 1] / 2, given[1, 0] / 0.5, given[1, 1] / 2]
    )
    np.testing.assert_allclose(problem.coefficients(unknowns), given, rtol=1e-15)


@cache
def kr270():
    return design_model(read_model("kr270"), limits(read_model("kr270").robot), 0.1)


def load_friction():
    stated = FRICTION | {"mu1": Prior(0.1), "mu2": Prior(0.1)}
    return replace(smooth_model(LoadDependentFriction(reversal=0.08)), stated=stated)


def gains():
    return with_drive_gains(replace(smooth_model(Payload("L", BODY)), stated=FRICTION))


def shapes():
    of = smooth_model(StribeckFriction(("shoulder",), fade=0.3, reversal=0.08))
    return with_shapes(replace(of, stated=FRICTION), ["stribeck_friction"])


def slides():
    return Model(sliding(), (RigidBody(),))


EXPERIMENTS = {
    "kr270: friction, balancer": (kr270, ("",)),
    "load": (load_friction, ("",)),
    "pair with gains": (gains, ("", "L")),
    "shapes": (shapes, ("",)),
    "slides": (slides, ("",)),
}


def problem_of(name, criterion, series=1):
    model, payloads = EXPERIMENTS[name][0](), EXPERIMENTS[name][1]
    n = model.robot.dof
    count = len(Experiment.of(model, payloads).base.kept)
    experiment = Experiment.of(model, payloads, 1.0 + np.arange(n), 1e-3 * np.eye(count))
    objective = Informative(experiment, criterion, experiment.sizes, rows=50.0)
    return Problem(small_basis(series), [objective], [], 2, np.linspace(0.5, 1.5, n))


@pytest.mark.parametrize(
    ("name", "criterion", "series"),
    [(name, volume, 1) for name in EXPERIMENTS]
    + [
        ("pair with gains", criterion, 1)
        for criterion in (partial(condition, power=2.0), average, Focus((1, 2)))
    ]
    + [("load", worst, 2)],
)
def test_gradient_by_the_coefficients(name, criterion, series):
    problem = problem_of(name, criterion, series)
    unknowns, objective = (
        problem.unknowns(coefficients(problem.basis, len(problem.scale))),
        problem.objectives[0],
    )
    value, gradient = problem.value(unknowns, objective)
    motion = problem.basis.motion(problem.coefficients(unknowns))
    assert value == pytest.approx(objective.value(motion), rel=1e-12)
    direction = np.random.default_rng(3).normal(size=unknowns.size)
    expected = along(lambda u: problem.value(u, objective)[0], unknowns, direction, 1e-6)
    assert gradient() @ direction == pytest.approx(expected, rel=2e-4, abs=1e-6)


def test_information_does_not_depend_on_how_finely_it_is_sampled():
    """Rows are counted by the time of the run, not by the samples of the optimiser."""
    objective = problem_of("load", volume).objectives[0]
    series = small_basis().fourier(coefficients(small_basis(), 2))[0]
    values = [objective.value(series.at(np.arange(m) * 4.0 / m).motion()) for m in (400, 800)]
    assert values[0] == pytest.approx(values[1], abs=1e-3)


def test_margins_and_their_slopes():
    of, kept = load_friction(), limits()
    region = Region.of(of.robot, "flange", box([-0.5, -1, -0.3], [0.6, 1, 0.4]))
    bounds = [*kinematic_bounds(kept), TorqueBound(of, np.array([1e-2, 1e-2])), ClearanceBound(region)]
    problem = Problem(small_basis(2), [], bounds, 4, np.array([0.5, 1.5]))
    unknowns = problem.unknowns(coefficients(problem.basis, 2))
    value, slope = problem.margins(unknowns)
    states = problem.basis.states(problem.coefficients(unknowns))
    expected = [bound.margins(type(states)(*(part[::4] for part in states))).value for bound in bounds]
    np.testing.assert_allclose(value, np.concatenate([part.ravel() for part in expected]), atol=1e-12)
    every = np.arange(value.size)
    assert slope(every).shape == (value.size, unknowns.size)
    some = np.array([0, 3, value.size - 1])
    np.testing.assert_array_equal(slope(some), slope(every)[some])
    assert slope(some[:0]).shape == (0, unknowns.size)
    direction = np.random.default_rng(3).normal(size=unknowns.size)
    differences = along(lambda u: problem.margins(u)[0], unknowns, direction, 1e-7)
    np.testing.assert_allclose(
        slope(every) @ direction, differences, rtol=1e-4, atol=1e-4 * np.abs(differences).max()
    )
