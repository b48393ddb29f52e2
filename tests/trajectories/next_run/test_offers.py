"""Runs on offer: what is asked of a person, and motions for an arm that carries a body."""

import numpy as np

from exidyn.identification.effects import known_parameters
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.trajectories.limits.usable_limits import Margins
from exidyn.trajectories.next_run.offers import _narrower, _request, for_robot, kinds_of_run
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan import robot_differences

from ...parts.small import small_diagnosis


def test_a_body_is_asked_for_with_its_centre_of_mass():
    body = KnownPayload("L", known_parameters(5.0, (0.1, 0.0, -0.04)))
    assert "payload of 5 kg" in _request(body)
    assert "(0.1, 0, -0.04) m along the flange's x" in _request(body)
    assert _request(KnownPayload("L", known_parameters(5.0))) == "Mount the payload of 5 kg on the flange"


def test_a_narrower_arm_has_the_same_middle_and_its_motion_is_one_for_the_whole_arm():
    model = small_diagnosis.nominal_model()
    limits, half = model.robot.limits, _narrower(model, 0.5).robot.limits
    assert np.allclose(
        half.position_upper - half.position_lower, 0.5 * (limits.position_upper - limits.position_lower)
    )
    [(_, planned), *_] = kinds_of_run(_narrower(model, 0.5), Wishes(margins=Margins()), print, 1)
    assert robot_differences(planned, model.robot)
    assert robot_differences(for_robot(planned, model), model.robot) == []
    assert np.ptp(planned.trajectory.every(0.01).position[:, 0]) < 1e-9
