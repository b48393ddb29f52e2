"""An arm as built: other values than its nominal ones, within what is stated, and always the same."""

import numpy as np
import pytest

from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import MOST, as_built


@pytest.fixture(scope="module")
def nominal():
    return read_model("cobot")


def masses(model):
    return np.array([body.mass for body in model.robot.kinematics.inertias[1:]])


def test_values_are_off_by_their_tolerance_with_and_without_a_payload(nominal):
    built = as_built(nominal)
    for off in (
        built.robot.drive_gain / nominal.robot.drive_gain - 1,
        masses(built) / masses(nominal) - 1,
        np.array([built.stated[n].value / p.value - 1 for n, p in nominal.stated.items() if p.value]),
    ):
        assert np.all(off != 0.0)
        assert np.all(np.abs(off) <= MOST)
        assert len(set(off)) == len(off)
    alone, loaded = (as_built(one) for one in (nominal, nominal + Payload("L", known_parameters(8.0))))
    np.testing.assert_array_equal(alone.robot.drive_gain, loaded.robot.drive_gain)
    np.testing.assert_array_equal(masses(alone), masses(loaded))
    assert alone.stated == loaded.stated
