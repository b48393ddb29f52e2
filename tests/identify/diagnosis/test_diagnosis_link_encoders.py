"""Gears between two encoders: their stiffness is measured; only links that swing add torque."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.diagnosis.candidates.joint_elasticity import of_stiffness
from exidyn.identification.diagnosis.search.problem import Problem
from exidyn.identification.diagnosis.search.search import search
from exidyn.identification.measurements.gears import bent
from exidyn.identification.simulation.plant.gears import link_size

from ...parts.small.small_search import TICK, names, problem, record, spring_search

pytestmark = pytest.mark.slow

STIFFNESS = np.array([40e3, 15e3])
LATE = 1e-3
NOISE = 2e-6


def bending(at: Problem) -> Problem:
    """The problem with encoders behind the gears, read a millisecond later, with a zero of their own."""
    rng, runs = np.random.default_rng(5), []
    for run in at.runs:
        motion = run.motion
        behind = motion.position - LATE * motion.velocity - motion.load / STIFFNESS + 0.01
        behind = behind + NOISE * rng.normal(size=behind.shape)
        runs.append(replace(run, prepared=replace(run.prepared, link_position=behind)))
    return replace(at, runs=tuple(runs))


def test_stiffness_is_that_between_the_encoders_whatever_else_is_found():
    without = spring_search()
    found = search(bending(without.problem))
    gears = {("joint_elasticity", (0,)), ("joint_elasticity", (1,))}
    assert gears < set(names(found))
    assert set(names(found)) - gears == set(names(without))
    for one in found.selected:
        if one.answer.candidate.effect == "joint_elasticity":
            [joint] = one.answer.candidate.joints
            stiffness = one.answer.candidate.reported["stiffness"][0]
            assert stiffness == pytest.approx(STIFFNESS[joint], rel=0.15)
            # The spring changes the load; a gear that was measured has no torque at any.
            assert not np.any(one.answer.columns.values)
    # Loads that differ by less than 0.2 % count as the same.
    np.testing.assert_allclose(found.prediction.errors, without.prediction.errors, rtol=5e-3)


def soft(at: Problem, resonance: float, ratio: float) -> tuple[Problem, float]:
    """The problem with a gear of the elbow on which its link swings between two encoders; its stiffness."""
    stiffness = float(link_size(at.model)[0][1] * (2 * np.pi * resonance) ** 2)
    gear = of_stiffness(at.model, 1, stiffness, 0.05 * stiffness).reshaped(
        {"resonance": resonance, "damping_ratio": ratio}
    )
    rng, runs, torque = np.random.default_rng(5), [], []
    for run in at.runs:
        weight, drag, inertia = run.unloaded.tangent.own(1)
        loss = 2 * ratio * stiffness / (2 * np.pi * resonance) + drag
        twist = bent(inertia, loss, stiffness + weight, run.motion.load[:, 1], TICK).value
        behind = run.motion.position - np.outer(twist, [0.0, 1.0])
        behind = behind + NOISE * rng.normal(size=behind.shape)
        runs.append(replace(run, prepared=replace(run.prepared, link_position=behind)))
        torque.append(run.thinned(gear.columns(run)[:, :, 0]))
    more = np.concatenate(torque)
    base, rows = (replace(one, difference=one.difference + more) for one in (at.base, at.rows))
    return replace(at, runs=tuple(runs), base=base, rows=rows), stiffness


def test_a_link_that_swings_on_a_soft_gear_is_nothing_else():
    at, stiffness = soft(problem(record()), 6.0, 0.01)
    found = search(at)
    assert names(found) == [("joint_elasticity", (1,))]
    [one] = found.selected
    assert one.answer.candidate.reported["stiffness"][0] == pytest.approx(stiffness, rel=0.05)
    assert np.any(one.answer.columns.values)
