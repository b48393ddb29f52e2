"""Drive gains that init proposes: known ones, rough ones, and the number that settles the others."""

import numpy as np
import pytest

from exidyn.identification.plausible.gains import UNDECIDED, Gain, gain_guesses
from exidyn.identification.plausible.proposal import Proposal
from exidyn.identification.plausible.proposal_text import robot_toml
from exidyn.identification.plausible.units import Units
from exidyn.identification.robot_files.robot_file import parse_model, read_model

from ...parts.small import two_joints

JOINTS = ("shoulder", "elbow")
KNOWN, ROUGH = Gain(12.0, 0.2, 0.9999), Gain(-8.0, 0.5, 0.0001)
OPEN = Gain(90.0, 2.0, 0.999)


def proposed(*drives):
    guesses = tuple(gain_guesses(JOINTS, drives))
    return Proposal({}, Units("s", "rad", ""), tuple(drives), False, guesses, (), (), False)


def test_a_rough_gain_is_open_and_has_its_likeliest_size():
    known, rough = gain_guesses(JOINTS, (KNOWN, ROUGH))
    assert known.decided
    assert not rough.decided
    assert rough.value == "-8.000 N m within a factor of 2, by the described masses"
    assert 0.8 < rough.probability < 0.9


def test_gains_without_any_size_name_the_number_on_the_data_sheet():
    [guess] = gain_guesses(JOINTS, (OPEN, Gain()))
    assert guess.what == "gain of shoulder, elbow"
    assert "torque constant of the motor [N m/A] times the gear ratio" in guess.option


@pytest.mark.parametrize(("other", "size"), [(OPEN, 8.0), (Gain(), -8.0)])
def test_rough_gains_are_written_with_their_tolerance_and_the_others_have_their_mean(other, size):
    model = two_joints.model(gain=np.ones(2))
    robot = parse_model(robot_toml(proposed(ROUGH, other), model, "", "log.csv")).robot
    assert robot.drive_gain[0] == -8.0
    assert robot.drive_gain[1] == size
    np.testing.assert_array_equal(robot.drive_gain_tolerance, [0.5, UNDECIDED])


def test_without_a_size_no_gain_is_written(tmp_path):
    text = robot_toml(proposed(OPEN, Gain()), two_joints.model(gain=np.ones(2)), "", "log.csv")
    assert "?" not in text
    path = tmp_path / "robot.toml"
    path.write_text(text)
    np.testing.assert_array_equal(read_model(path).robot.drive_gain, [1.0, 1.0])
