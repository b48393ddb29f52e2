"""Torque of a finding whose numbers are collinear, with its interval, and which of them are not given."""

from collections.abc import Mapping
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis.findings.quantities import quantities
from exidyn.identification.diagnosis.questions.block_answer import Answer
from exidyn.identification.diagnosis.questions.candidate import Candidate, Thinned
from exidyn.identification.diagnosis.results.evidence import deviations, with_shapes
from exidyn.identification.diagnosis.results.sizes import left_out, size
from exidyn.identification.diagnosis.search.selected import Selected
from exidyn.identification.effects import Shape
from exidyn.identification.quantity import Quantity

from ...parts.small.small_rows import blocks, predicted, rows

pytestmark = pytest.mark.numerical

COUNT, BLOCKS = 2000, 40
NOISE = 0.1
FLAT = 40.0
"""Standard deviation of what is expected of a coefficient, far above what any is."""
POSITION = 1.0 + np.sin(np.linspace(0.0, 67.0, COUNT))
LOAD = 0.5 + 0.5 * np.sin(np.linspace(0.0, 41.0, COUNT))
VELOCITY = np.where(np.sin(np.linspace(0.0, 89.0, COUNT)) > 0.0, 1.0, -1.0)
STIFFNESS, OFFSET = 3.0, 0.7
MU, PRELOAD = 0.4, 0.8


def noise(seed: int) -> np.ndarray:
    return NOISE * np.random.default_rng(seed).normal(size=COUNT)


def spring() -> Candidate:
    """With its torque where the position is zero."""
    both = np.column_stack([POSITION, np.ones(COUNT)])[:, None]
    names, units = ("Ks1", "Ts1"), ("N m/rad", "N m")
    return Candidate("joint_spring", (0,), lambda run: both, names, units, (0.0, -np.inf))


def pressed(preload: float) -> Candidate:
    """Friction of a gear whose teeth have a preload."""

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return pressed(given["preload"])

    column = VELOCITY * (np.hypot(LOAD, preload) - preload)
    return Candidate(
        "load_dependent_friction", (0,), lambda run: column[:, None, None], ("mu1",), ("1",), (0.0,),
        {"preload": preload}, {"preload": Shape("N m", 0.0, 5.0)}, reshaped,
    )  # fmt: skip


def searched(candidate: Candidate, values: list[float], beside: np.ndarray, torque: np.ndarray):
    """What a search has come to that has found it beside a free parameter's column (r,), and traces."""
    run = SimpleNamespace(
        torque=np.ones((COUNT, 1)), thinned=lambda columns: columns, centres=np.arange(COUNT), rows=COUNT
    )
    thinned = Thinned.of(candidate, [run])
    columns = np.concatenate([beside[:, None, None], thinned.values], axis=2)
    given = rows(torque[:, None], columns, np.append(np.inf, np.full(len(values), FLAT)))
    prediction = predicted(given, blocks((COUNT // BLOCKS,) * BLOCKS))
    nothing, still = np.zeros((BLOCKS, 1)), np.zeros(BLOCKS)
    answer = Answer(
        candidate, thinned, np.array(values), np.ones(len(values), bool), nothing, nothing, still, still,
        nothing, np.ones(1), np.ones(BLOCKS, bool),
    )  # fmt: skip
    model = SimpleNamespace(effects=(), robot=None)
    problem = SimpleNamespace(runs=(run,), fitted=(run,), held_out=(), model=model, pairs=lambda wanted: [])
    trace = SimpleNamespace(
        position=POSITION[:, None], velocity=VELOCITY[:, None], load=LOAD[:, None], weight=np.ones((COUNT, 1))
    )
    found = SimpleNamespace(prediction=prediction, selected=(Selected(answer, 100.0),), problem=problem)
    return found, [trace]


def with_spring(seed: int):
    torque = STIFFNESS * POSITION + OFFSET + noise(seed)
    return searched(spring(), [STIFFNESS, 0.0], np.ones(COUNT), torque)


def with_preload(seed: int):
    """Which of preload and Coulomb friction and growth it is, such loads hardly tell."""
    torque = VELOCITY * (MU * (np.hypot(LOAD, PRELOAD) - PRELOAD) + 0.3) + noise(seed)
    return searched(pressed(1.5), [MU], VELOCITY, torque)


def numbers(found) -> dict[str, Quantity]:
    own, [spread] = found.selected[0].answer.candidate, deviations(found)
    return quantities(own, found.prediction.values[1:], *spread)


def test_the_change_of_a_spring_s_torque_is_known_beside_a_free_offset_to_its_interval():
    found, traces = with_spring(1)
    sized = size(found, with_shapes(found), traces, 0)
    assert sized.over == "position"
    assert sized.change
    first, _, last = sized.points
    assert (first.torque, first.std) == (0.0, 0.0)
    assert [one.which for one in sized.points] == ["lowest", "middle", "highest"]
    assert last.torque == pytest.approx(STIFFNESS * (last.at - first.at), abs=3.0 * last.std)
    assert last.std < 0.05


def test_an_interval_contains_the_truth_as_often_as_it_says():
    apart = []
    for seed in range(20):
        found, traces = with_spring(seed)
        first, *_, last = size(found, with_shapes(found), traces, 0).points
        apart.append((last.torque - STIFFNESS * (last.at - first.at)) / last.std)
    assert np.sum(np.abs(apart) < 1.96) >= 16
    assert np.sqrt(np.mean(np.square(apart))) < 1.6


def test_a_constant_torque_is_not_given_beside_a_free_offset_and_the_stiffness_is():
    found, _ = with_spring(1)
    known = numbers(found)
    assert known["Ts1"].std > 10.0 * known["Ks1"].std
    missing = left_out(found, with_shapes(found), 0, known)
    assert set(missing) == {"Ts1"}
    assert missing["Ts1"].beside == "x0"


def test_torque_of_friction_under_load_is_known_where_its_numbers_are_not():
    found, traces = with_preload(2)
    missing = left_out(found, with_shapes(found), 0, numbers(found))
    assert "preload" in missing
    sized = size(found, with_shapes(found), traces, 0)
    assert sized.over == "size of the load"
    first, usual, largest = sized.points
    for one in (usual, largest):
        grown = np.hypot(one.at, PRELOAD) - np.hypot(first.at if sized.change else 0.0, PRELOAD)
        assert one.torque == pytest.approx(MU * grown, abs=2.5 * one.std)
    assert 1.96 * largest.std < largest.torque


def test_a_number_whose_sign_is_known_is_given():
    torque = STIFFNESS * POSITION + OFFSET + noise(3)
    found, _ = searched(spring(), [STIFFNESS, OFFSET], VELOCITY, torque)
    assert not left_out(found, with_shapes(found), 0, numbers(found))


def test_what_follows_nothing_recorded_is_given_by_what_no_other_parameter_takes():
    wave = np.sin(np.linspace(0.0, 1000.0, COUNT))
    one = Candidate(
        "torque_ripple", (0,), lambda run: wave[:, None, None], ("Rcos1_1",), ("N m",), (-np.inf,)
    )
    found, [trace] = searched(one, [0.5], VELOCITY, 0.5 * wave + noise(4))
    trace.motor_angle = POSITION[:, None]
    sized = size(found, with_shapes(found), [trace], 0)
    assert not sized.over
    assert not sized.known
    value, std = sized.beside_rms, sized.beside_std
    assert value == pytest.approx(0.5 / np.sqrt(2.0), abs=3.0 * std)
