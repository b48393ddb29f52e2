"""Waves along a joint's turn, of whatever number a turn, are found and named by that number."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.diagnosis.candidates import candidates, hypotheses
from exidyn.identification.diagnosis.candidates.torque_ripple import _peaks, line_above_cutoff, ripples
from exidyn.identification.diagnosis.questions.candidate import Thinned
from exidyn.identification.diagnosis.questions.shape import reshaped
from exidyn.identification.diagnosis.results.evidence import places_of
from exidyn.identification.diagnosis.runs.usable import usable
from exidyn.identification.diagnosis.search.problem import Problem
from exidyn.identification.diagnosis.search.search import search
from exidyn.identification.effects import TorqueRipple
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.simulation.simulate import Sensors, simulate

from ...parts.small import two_joints
from ...parts.small.small_diagnosis import TRUE, nominal_model
from ...parts.small.small_search import names

pytestmark = pytest.mark.slow

GEAR = 20.0
TICK = 0.004


def slow(seed, length):
    """To and fro at speeds that change, slow enough for waves to pass the filter."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, length, TICK)
    position = np.zeros((len(time), 2))
    velocity, acceleration = np.zeros_like(position), np.zeros_like(position)
    for joint in range(2):
        for size, period in ((0.5, length / 1.3), (0.08, length / 3.2), (0.03, length / 5.1)):
            rate, phase = 2 * np.pi / period, random.uniform(0, 2 * np.pi)
            position[:, joint] += size * np.sin(rate * time + phase)
            velocity[:, joint] += size * rate * np.cos(rate * time + phase)
            acceleration[:, joint] -= size * rate**2 * np.sin(rate * time + phase)
    return Motion.of(time, position, velocity, acceleration)


def geared():
    model = nominal_model()
    return replace(model, robot=replace(model.robot, gear_ratio=np.full(2, GEAR)))


@cache
def runs(harmonic, size, cutoff=25.0):
    """Runs of an arm with a ripple of so many waves a turn of the elbow's motor."""
    model, effect = geared(), TorqueRipple(("elbow",), harmonic=harmonic)
    plant = model + effect
    waves = {f"Rcos{harmonic:g}_2": 0.6 * size, f"Rsin{harmonic:g}_2": 0.8 * size}
    given = TRUE | waves
    true = np.array([given.get(n, b) for n, b in zip(plant.names, plant.nominal_values, strict=True)])
    assert set(waves) <= set(plant.names)
    # Steps of the encoder would be accelerations at so high a cut-off.
    quiet = Sensors(current_noise=0.002, encoder_noise=1e-8, encoder_step=0.0)
    made = []
    for seed, (role, length) in enumerate([("identify", 30.0), ("identify", 30.0), ("validate", 15.0)]):
        one = simulate(
            plant, true, two_joints.GAIN, slow(seed, length), model, quiet, name=f"{role}{seed}", seed=seed
        )
        made.append((role, one))
    filtering = Filtering(position_cutoff=40.0, torque_cutoff=cutoff)
    return Problem.of(model, usable(model, made, filtering)[0])


@pytest.mark.long
def test_a_ripple_of_any_frequency_is_named_with_it():
    harmonic = 30.65 / GEAR
    found = search(runs(harmonic, 0.3))
    assert names(found)[0] == ("torque_ripple", (1,))
    assert [name for name, _ in names(found)].count("torque_ripple") == 1
    candidate = found.selected[0].answer.candidate
    assert candidate.shape["harmonic"] == pytest.approx(harmonic, rel=0.01)
    values = found.prediction.values[places_of(found, 0)]
    assert np.hypot(*values) == pytest.approx(0.3, rel=0.1)


def test_a_ripple_that_the_filter_removes_is_located_with_the_cutoff_that_shows_it():
    at = runs(1200 / GEAR, 0.4, 3.0)
    line = line_above_cutoff(at.runs, 1)
    assert line.waves == pytest.approx(1200, rel=2e-3)
    assert line.amplitude == pytest.approx(0.4, rel=0.1)
    assert line_above_cutoff(at.runs, 0) is None
    assert line_above_cutoff(runs(1200 / GEAR, 0.4, line.cutoff).runs, 1) is None  # it is a candidate then


def test_without_a_ripple_frequencies_are_asked_for_and_none_is_found():
    at = runs(7.0, 0.0)
    asked = [*ripples(at.model, at.prediction([]), at.runs)]
    assert {one.joints for one in asked} == {(0,), (1,)}
    assert all(one.among > 50 for one in asked)
    assert "torque_ripple" not in {name for name, _ in names(search(at))}


def test_waves_that_the_range_of_a_joint_does_not_show_are_not_asked_for():
    at = runs(7.0, 0.0)
    low = [one for one, _ in at.candidates if one.effect == "torque_ripple"]
    assert {one.shape["harmonic"] for one in low if "harmonic" in one.shape} == {1.0, 2.0, 3.0, 4.0, 6.0}
    direct = replace(at.model, robot=replace(at.model.robot, gear_ratio=np.ones(2)))
    made = [Thinned.of(one, at.runs) for one in hypotheses("torque_ripple", direct)]
    # A quarter of a turn shows one and a half of six waves, at most, and nothing of one.
    turn = 2 * np.pi / np.ptp(np.concatenate([run.motion.position[:, 1] for run in at.runs]))
    asked = [
        one
        for one, columns in zip(hypotheses("torque_ripple", direct), made, strict=True)
        if not columns.empty
    ]
    assert all(one.shape.get("harmonic", 0.0) >= 1.5 * turn for one in asked if one.joints == (1,))
    assert len(asked) < len(low) / 2


def test_peaks_are_where_the_waves_are_and_as_many_as_a_range_distinguishes():
    random = np.random.default_rng(0)
    position = np.sort(random.uniform(-1.0, 1.5, 4000))
    left = np.sin(30.65 * position) + 0.4 * np.cos(211.3 * position + 1.0) + 0.5 * random.normal(size=4000)
    peaks = [*_peaks(position, left, 600.0)]
    found = sorted(waves for waves, _ in peaks[:2])
    # As well as the range distinguishes waves; what is found is refined.
    assert found == pytest.approx([30.65, 211.3], abs=2 * np.pi / 2.5)
    assert peaks[0][1] == int(600.0 / (2 * np.pi / 2.5))


def test_waves_of_one_joint_stay_apart_when_their_shape_is_refined():
    problem = runs(30.65 / GEAR, 0.3)
    waves = list(ripples(problem.model, problem.without_findings, problem.runs))
    assert len({wave.key for wave in waves}) == len(waves) > 1
    for wave in waves:
        moved = reshaped(wave, {"harmonic": wave.shape["harmonic"] + 1e-3})
        assert moved.key == wave.key
        assert (moved.among, dict(moved.bounds)) == (wave.among, dict(wave.bounds))


def test_the_shape_never_changes_which_hypothesis_it_is_of():
    shaped = [one for one in candidates(geared()) if one.bounds]
    assert len({one.effect for one in shaped}) > 5
    for candidate in shaped:
        renamed = replace(candidate, kind="another")
        assert reshaped(renamed, {}).key == renamed.key
