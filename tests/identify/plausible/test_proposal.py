"""Units, order, signs and sizes that a log shows, on one whose truth is known."""

import numpy as np
import pytest

from exidyn.identification.errors import BadTime, RecordingError
from exidyn.identification.plausible.proposal import propose
from exidyn.identification.plausible.search import posterior
from exidyn.identification.plausible.suspicion import Guess

from ...parts.runs.logs import columns, short_arm, short_log

LOG = short_log()
ROBOT = LOG.model.robot


def proposed(named, model=LOG.model):
    return propose(list(named), np.column_stack(list(named.values())), model)


def probability(found, what):
    return next(guess.probability for guess in found.guesses if guess.what == what)


@pytest.mark.parametrize(
    ("second", "time", "angle"),
    [(1.0, "s", "deg"), (1e3, "ms", "rad"), (1e9, "ns", "deg")],
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
    assert "1 gap, the longest 210.0 ms" in notes
    assert "1 of 1981 rows lack a number, or repeat" in notes
    assert "joint3 goes" in notes
    named = {"t": 0.0 * LOG.time, **columns("q{k}", LOG.position), **columns("i{k}", LOG.current)}
    with pytest.raises(BadTime, match="column t does not increase at all; .*--rate HZ"):
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


@pytest.mark.parametrize("second", [False, True])
def test_a_column_of_time_that_does_not_increase_is_named(second):
    rows = np.repeat(np.arange(len(LOG.time)), 2 if second else 1)
    time, position = LOG.time[rows].copy(), LOG.position[rows].copy()
    if second:
        position[1::2] = 0.0  # of another publisher
    else:
        time[7::7] = time[6::7][: len(time[7::7])]
    named = {"t": time, **columns("q{k}", position), **columns("i{k}", LOG.current[rows])}
    with pytest.raises(BadTime, match="^column t does not increase at .* in row") as raised:
        proposed(named)
    assert ("Rows of two sources seem mixed" in str(raised.value)) == second
    assert ("Sort the rows by time" in str(raised.value)) != second


def test_probabilities_sum_to_one_and_decide():
    found = posterior({"a": 0.0, "b": np.log(3.0)})
    assert list(found) == ["b", "a"]
    assert found["b"] == pytest.approx(0.75)
    assert Guess("what", "b", 0.96, "").decided
    assert not Guess("what", "b", 0.94, "").decided
