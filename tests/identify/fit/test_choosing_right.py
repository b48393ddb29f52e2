"""The probability of choosing right, against draws of truth and noise."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from exidyn.identification.effects import (
    JointSpring,
    NonlinearViscousFriction,
    SpringBalancer,
    StribeckFriction,
)
from exidyn.trajectories.discrimination.separation import probability, separation_for

from ...parts.plans.hypotheses import OBSERVATION, hypothesis, motion, refitted, separation, stacked


def share_of_right_choices(true, rival, at, draws=4000):
    """Truth and noise are drawn, both models are fitted, the smaller chi-squared is taken."""
    random = np.random.default_rng(0)
    columns, torque = stacked(true, at)
    held = np.diag(true.precision)
    spread = np.where((held > 0) & np.isfinite(held), held, np.inf) ** -0.5
    truths = spread[:, None] * random.normal(size=(len(held), draws))
    torque = torque[:, None] + columns @ truths + random.normal(size=(2 * len(at), draws))
    misfits = []
    for one in (true, rival):
        columns, own = stacked(one, at)
        misfits.append(refitted(one, columns, torque, own)[0])
    return float(np.mean(misfits[0] < misfits[1]))


@pytest.mark.parametrize("wanted", [1.0, 6.0])
def test_probability_of_models_that_are_nearly_alike(wanted):
    at, rival = motion(size=0.3), hypothesis("spring", JointSpring(("shoulder",)))
    sampled, effect = replace(OBSERVATION, rows=len(at)), SpringBalancer("shoulder", 0.3, 0.2, 0.4)
    held = {"K0": 0.0}  # since Ts and the offset are one, the spring has one parameter of its own too
    soft = hypothesis("balancer", effect, values={"Kr": 100.0}, deviations=held)
    growth = np.sqrt(wanted / separation(soft, rival, at, sampled).separation)
    true = hypothesis("balancer", effect, values={"Kr": 100.0 * growth}, deviations=held)
    found = separation(true, rival, at, sampled)
    assert found.separation == pytest.approx(wanted, rel=1e-6)
    right = share_of_right_choices(true, rival, at)
    assert right == pytest.approx(probability(found.separation), abs=0.03)  # 0.016 is two deviations


@pytest.mark.parametrize("size", [0.4, 1.2])
def test_probability_of_models_that_are_unlike(size):
    """One column each, its nuisance the same: the law in the docstring, and where the short one is safe."""
    true = hypothesis("stribeck", StribeckFriction(("elbow",), reversal=0.05), values={"Fs2": size})
    rival, at = hypothesis("grease", NonlinearViscousFriction(("elbow",))), motion()
    found = separation(true, rival, at, replace(OBSERVATION, rows=len(at)))
    angle, short = angle_of(true, rival, at), probability(found.separation)
    b = 0.5 * np.sqrt(found.separation) / np.sin(angle / 2)
    a = b * np.tan(angle / 2)
    exact = norm.cdf(a) * norm.cdf(b) + norm.cdf(-a) * norm.cdf(-b)
    right = share_of_right_choices(true, rival, at)
    assert right == pytest.approx(exact, abs=0.02)
    assert short < right if found.separation > 3.1 else 0.0 < short - right < 0.065


def angle_of(one, other, at):
    """Between the last columns of two hypotheses, what they have in common projected off."""
    columns = [stacked(h, at)[0] for h in (one, other)]
    common, free = columns[0][:, :-1], one.free[:-1]
    held = np.diag(np.sqrt(np.diag(one.precision)[:-1][free]))
    rows = np.concatenate([common[:, free], held])
    left = []
    for own in columns:
        column = np.append(own[:, -1], np.zeros(len(held)))
        column = column - rows @ np.linalg.lstsq(rows, column, rcond=1e-9)[0]
        left.append(column / np.linalg.norm(column))
    return float(np.arccos(abs(left[0] @ left[1])))


def test_probability_and_its_inverse():
    assert probability(0.0) == 0.5
    assert probability(separation_for(0.95)) == pytest.approx(0.95)
    assert separation_for(0.95) == pytest.approx(10.82, abs=0.01)
