"""A base that leans: which way is which, and how far."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
from exidyn.identify.diagnosis.candidates.bodies import tilts
from exidyn.identify.diagnosis.scene import Scene
from exidyn.identify.model import Model

from .small_diagnosis import believed
from .small_search import names, record, scene, searched


def leaning(model: Model, x: float, y: float) -> Model:
    """The model with gravity that has a part along the base's axes."""
    kinematics = model.robot.kinematics.copy()
    down = kinematics.gravity.linear
    size = np.linalg.norm(down)
    kinematics.gravity = pin.Motion(down + size * np.array([x, y, 0.0]), np.zeros(3))
    return replace(model, robot=replace(model.robot, kinematics=kinematics))


def test_columns_are_what_gravity_adds_along_each_axis():
    at: Scene = scene(record(roles=("identify",)))
    run = at.runs[0]
    [candidate] = tilts(at.model)
    columns = candidate.columns(run)
    assert candidate.names == ("tilt_x", "tilt_y")
    values = at.model.believed_values
    for place, lean in enumerate(((1e-3, 0.0), (0.0, 1e-3))):
        turned = leaning(at.model, *lean)
        more = turned.torque(run.motion, values) - at.model.torque(run.motion, values)
        np.testing.assert_allclose(columns[:, :, place], more / 1e-3, atol=1e-6)
    # Both joints turn about the base's y axis.
    assert np.max(np.abs(columns[:, :, 0])) > 10.0
    assert np.max(np.abs(columns[:, :, 1])) < 1e-9


def test_a_base_that_leans_is_told_with_its_angle():
    nominal = believed()
    upright = nominal.robot.kinematics
    runs = []
    for role, run in record(model=leaning(nominal, 0.03, 0.0)):
        level = replace(run.model, robot=replace(run.model.robot, kinematics=upright))
        runs.append((role, replace(run, model=level)))
    found = searched(runs)
    # All joints of this arm turn about one direction: the first one's zero leans it as well.
    [one] = found.found
    every = {other.candidate.key[:2]: other for other in (one.answer, *(other for other, _ in one.others))}
    assert set(names(found)) <= {("base_tilt", ()), ("encoder_offset", (0,))}
    tilt, zero = every["base_tilt", ()], every["encoder_offset", (0,)]
    assert abs(tilt.values[0] - 0.03) < 2e-3
    assert abs(abs(zero.values[0]) - 0.03) < 2e-3
