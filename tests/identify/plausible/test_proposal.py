"""Units, order, signs and sizes that a log shows, on one whose truth is known."""

import re

import numpy as np
import pytest

from exidyn.identification.errors import BadTime, NotFinite, RecordingError
from exidyn.identification.model import Model
from exidyn.identification.plausible.proposal import propose
from exidyn.identification.plausible.search import posterior
from exidyn.identification.plausible.suspicion import Guess

from ...parts.runs.logs import columns, short_arm, short_log
from ...parts.small import two_joints

LOG = short_log()
ROBOT = LOG.model.robot


def proposed(named, model=LOG.model):
    return propose(list(named), np.column_stack(list(named.values())), model)


def probability(found, what):
    return next(guess.probability for guess in found.guesses if guess.what == what)


@pytest.mark.parametrize(
    ("second", "time", "angle"), [(1.0, "s", "deg"), (1e3, "ms", "rad"), (1e9, "ns", "deg")]
)
def test_units_of_time_and_position_are_found_without_velocities(second, time, angle):
    position = np.degrees(LOG.position) if angle == "deg" else LOG.position
    named = {"t": second * LOG.time, **columns("q{k}", position), **columns("i{k}", LOG.current)}
    found = proposed(named)
    assert found.units == (time, angle, "")
    assert min(probability(found, f"unit of {part}") for part in ("time", "position")) > 0.99


def test_units_are_known_or_left_open():
    named = {"t": LOG.time, **columns("q{k}", np.degrees(LOG.position)), **columns("dq{k}", LOG.velocity)}
    found = proposed(named | columns("i{k}", LOG.current))
    assert found.units == ("s", "deg", "rad")
    noise = np.random.default_rng(0).normal(size=LOG.position.shape)
    found = proposed({"t": LOG.time, **columns("q{k}", 2.0 * LOG.position), **columns("i{k}", noise)})
    assert "unit of position" in [guess.what for guess in found.open]
    counts = np.round(LOG.position * 65536 / (2 * np.pi))
    found = proposed({"t": LOG.time, **columns("q{k}", counts), **columns("i{k}", LOG.current)})
    assert probability(found, "unit of position") < 0.05
    assert any("steps of an encoder" in note for note in found.notes)


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (2, 1, 0, 3)])
def test_order_of_joints_is_that_which_rigid_bodies_explain(order):
    named = {"t": LOG.time, **columns("q{k}", LOG.position[:, order])}
    found = proposed(named | columns("i{k}", LOG.current[:, order]))
    assert found.columns["position"] == tuple(f"q{order.index(joint) + 1}" for joint in range(4))
    assert found.columns["current"] == tuple(f"i{order.index(joint) + 1}" for joint in range(4))


def test_columns_without_meaning_are_known_by_their_motion():
    named = {"x": LOG.time, **columns("a{k}", LOG.velocity), **columns("b{k}", LOG.current)}
    found = proposed(named | columns("c{k}", np.degrees(LOG.position)))
    first = {signal: names[0] for signal, names in found.columns.items()}
    assert first == {"time": "x", "position": "c1", "velocity": "a1", "current": "b1"}
    named = {"t": LOG.time, **columns("q{k}", LOG.position[:, :2]), **columns("i{k}", LOG.current[:, :2])}
    with pytest.raises(
        RecordingError, match=r"The log has 2 joints: name the 2 in a robot.toml .*joints = \["
    ):
        proposed(named)


def test_torques_of_the_joints_are_told_from_efforts_in_another_unit():
    position = {"t": LOG.time, **columns("q{k}", LOG.position)}
    torque = proposed(position | columns("effort{k}", LOG.torque))
    other = proposed(position | columns("effort{k}", LOG.torque / 250.0))
    assert "torque" in torque.columns
    assert not torque.gains
    assert "current" in other.columns
    assert "torque" not in other.columns


def test_torques_of_all_joints_may_count_against_the_positions():
    position = {"t": LOG.time, **columns("q{k}", LOG.position)}
    found = proposed(position | columns("tau{k}", -LOG.torque))
    assert "torque" in found.columns
    assert found.against
    assert not found.gains
    assert probability(found, "unit of tau{number}") > 0.99
    assert not proposed(position | columns("tau{k}", LOG.torque)).against
    turned = found.by_gains()
    assert turned.columns["current"] == found.columns["torque"]
    assert [(gain.value, gain.known) for gain in turned.gains] == [(-1.0, True)] * ROBOT.dof


def test_a_description_without_masses_says_nothing_of_the_sign_of_torques():
    model = short_arm("cobot")
    for place in range(1, model.robot.dof + 1):
        model.robot.kinematics.inertias[place].mass = 1.0
    named = {"t": LOG.time, **columns("q{k}", LOG.position), **columns("tau{k}", -LOG.torque)}
    found = proposed(named, model)
    assert "torque" in found.columns
    assert not found.against


def test_signs_and_sizes_of_gains_are_right_where_they_are_told():
    sign = np.array([1, -1, 1, -1])
    named = {"t": LOG.time, **columns("q{k}", LOG.position), **columns("i{k}", sign * LOG.current)}
    found = proposed(named)
    told = [k for k, gain in enumerate(found.gains) if gain.known]
    assert {1, 2} <= set(told)  # the joints that lift the arm
    for k in told:
        assert 0.5 < found.gains[k].value / (sign * ROBOT.drive_gain)[k] < 2.0
    assert all((gain.positive > 0.5) == (s > 0) for gain, s in zip(found.gains, sign, strict=True))


def test_gains_are_not_told_by_a_description_whose_masses_are_one_number():
    model = short_arm("cobot")
    for body in list(model.robot.kinematics.inertias)[1:]:
        body.mass = 1.0
    for place in range(1, model.robot.dof + 1):
        model.robot.kinematics.inertias[place].mass = 1.0
    named = {"t": LOG.time, **columns("q{k}", LOG.position), **columns("i{k}", LOG.current)}
    assert not any(gain.known for gain in proposed(named, model).gains)


def test_gaps_repeats_limits_and_time_that_stands_still_are_said():
    rows = np.delete(np.arange(2000), slice(700, 720))
    rows = np.sort(np.concatenate([rows, [300]]))
    position = LOG.position[rows] + np.array([0, 0, 3.0, 0])
    named = {"t": LOG.time[rows], **columns("q{k}", position), **columns("i{k}", LOG.current[rows])}
    notes = " ".join(proposed(named).notes)
    assert "1 gap of more than 1.5 median periods of 10.000 ms, the longest 210.000 ms" in notes
    assert "position: 1 of 1981 samples are written twice" in notes
    assert "joint3 goes" in notes
    named = {"t": 0.0 * LOG.time, **columns("q{k}", LOG.position), **columns("i{k}", LOG.current)}
    with pytest.raises(BadTime, match="All times are equal, .* exidyn init --rate HZ"):
        proposed(named)


@pytest.mark.parametrize(
    ("named", "missing"),
    [
        ({**columns("q{k}", LOG.position), **columns("i{k}", LOG.current)}, "no column of time"),
        ({"t": LOG.time, **columns("q{k}", LOG.position)}, "no current or torque"),
        ({"t": LOG.time, **columns("i{k}", LOG.current)}, "no position"),
    ],
)
def test_what_is_not_there_is_an_error_that_names_it(named, missing):
    with pytest.raises(RecordingError, match=missing):
        proposed(named)


@pytest.mark.parametrize(("scale", "read"), [(1.0, True), (np.radians(1.0), False)])
def test_commands_are_read_where_the_joints_follow_them(scale, read):
    named = {"t": LOG.time, **columns("q{k}", LOG.position), **columns("tau{k}", LOG.torque)}
    found = proposed(named | columns("target_q{k}", scale * (LOG.position + 0.001)))
    assert ("command" in found.columns) == read
    assert ("command" in [guess.what for guess in found.guesses]) == read
    assert any("target_q{number} is left out" in note for note in found.notes) != read


def test_rows_of_two_sources_are_refused_as_by_import():
    rows = np.repeat(np.arange(len(LOG.time)), 2)
    position = LOG.position[rows]
    position[1::2] = 0.0  # of another publisher
    named = {"t": LOG.time[rows], **columns("q{k}", position), **columns("i{k}", LOG.current[rows])}
    with pytest.raises(BadTime, match="does not increase at 2000 of 3999 .* Rows of two sources seem mixed"):
        proposed(named)


REPAIRED = {
    "wrapped": lambda t: np.mod(1e6 * t + 2**32 - 7.3e6, 2**32),
    "rounded": lambda t: np.floor(25.0 * t) / 25.0,
    "repeated": lambda t: np.where(np.arange(len(t)) % 7 == 0, np.roll(t, 1), t),
    "float32": lambda t: (1.5e5 + t).astype(np.float32).astype(float),
}
"""Clocks that import repairs."""


@pytest.mark.parametrize("clock", REPAIRED)
@pytest.mark.parametrize("angle", [1.0, np.pi / 180])
def test_a_log_is_read_with_the_repairs_of_import(clock, angle):
    time = REPAIRED[clock](LOG.time)
    named = {"t": time, **columns("q{k}", LOG.position / angle), **columns("i{k}", LOG.current)}
    found = proposed(named)
    assert re.match(r"2000 samples at (100\.0|99\.99) Hz, 19\.99 s", found.notes[0])
    assert found.units[:2] == ("us" if clock == "wrapped" else "s", "rad" if angle == 1.0 else "deg")
    assert any("stamps" in note for note in found.notes)


@pytest.mark.parametrize("turn", [2 * np.pi, 360.0])
def test_turns_that_were_lost_are_no_high_speeds(turn):
    away = (LOG.position + [np.pi, 0.0, 0.0, 0.0]) * turn / (2 * np.pi)  # the first axis is vertical
    wrapped = np.mod(away + turn / 2, turn) - turn / 2
    found = proposed({"t": LOG.time, **columns("q{k}", wrapped), **columns("tau{k}", LOG.torque)})
    assert found.units.position == ("deg" if turn == 360.0 else "rad")
    assert any("the turns are undone" in note for note in found.notes)


def test_signs_and_peaks_that_were_lost_are_repaired_as_by_import():
    current = np.mod(np.round(1e3 * LOG.current), 2.0**16)
    position = np.clip(LOG.position, -np.inf, np.quantile(LOG.position, 0.97, axis=0))
    found = proposed({"t": LOG.time, **columns("q{k}", position), **columns("i{k}", current)})
    notes = " ".join(found.notes)
    assert "the sign is restored" in notes
    assert "it is clipped there; they are left out" in notes


def test_probabilities_sum_to_one_and_decide():
    found = posterior({"a": 0.0, "b": np.log(3.0)})
    assert list(found) == ["b", "a"]
    assert found["b"] == pytest.approx(0.75)
    assert Guess("what", "b", 0.96, "").decided
    assert not Guess("what", "b", 0.94, "").decided


@pytest.mark.parametrize("place", range(5))
@pytest.mark.parametrize("value", [1e308, -1e308, 1e16])
def test_numbers_that_cannot_be_computed_with_are_refused(place, value):
    time, names = np.arange(0.0, 4.0, 0.01), ("t", "q1", "q2", "tau1", "tau2")
    values = np.column_stack([time, np.sin(time), np.cos(time), np.cos(3 * time), np.sin(2 * time)])
    values[-1, place] = abs(value) if place == 0 else value
    expected = rf"column {names[place]} is above 1e\+15 in 1 of 400 rows, first in row 400"
    with pytest.raises(NotFinite, match=expected):
        propose(names, values, Model(two_joints.arm(), ()))
