"""View of contact: torques between their thresholds, an arrow at the flange, and the contacts as events."""

import numpy as np
import pytest

from exidyn.acquire.views import viewers
from exidyn.acquire.views.contact_view import EXTERNAL, FORCE, LONGEST, contact_view
from exidyn.acquire.views.live_view import Targets
from exidyn.acquire.views.parts import ARM, reach
from exidyn.identification.arm.newton_euler import flange_position
from exidyn.identification.contact.contact import Contact
from exidyn.identification.contact.observer import Estimates
from exidyn.identification.contact.threshold import Alarm

from ...parts.pages.rerun_viewer import numbers, numbers_nested, require_drawn, saved, seconds
from ...parts.small import small_fit, two_joints

pytestmark = pytest.mark.slow

MODEL = two_joints.model()
TIME = np.arange(0.0, 4.0, 0.01)
TORQUE = np.column_stack([np.sin(TIME), 2.0 * np.cos(TIME)])


class Threshold:
    """A threshold of 1.5 N m and 3 N m."""

    def torque(self, estimates):
        return np.array([1.5, 3.0]) * np.ones((len(estimates), 2))


@pytest.fixture(scope="module")
def result():
    position = np.column_stack([0.3 * TIME, -0.2 * TIME])
    estimates = Estimates(TIME, TORQUE, position, 0 * position, 0 * position)
    force = np.zeros((len(TIME), 6))
    force[:, 2] = np.where(TIME < 2.0, 0.0, -40.0)
    force[:10] = np.nan
    alarm = Alarm(1.0, 1.5, 1, TORQUE[100], np.zeros(2), np.ones(2), 1.4)
    return Contact(small_fit.fit(), "run", estimates, force, Threshold(), (alarm,))


@pytest.fixture(scope="module")
def chunks(result, tmp_path_factory):
    return saved(contact_view(result, "N m"), tmp_path_factory.mktemp("view") / "contact.rrd")


def test_torques_lie_between_their_thresholds(chunks):
    np.testing.assert_allclose(numbers(chunks, f"/{EXTERNAL}/elbow/torque"), TORQUE[:, 1])
    limits = numbers(chunks, f"/{EXTERNAL}/elbow/threshold").reshape(-1, 2)
    np.testing.assert_allclose(limits, [[3.0, -3.0]] * len(TIME))


def test_the_force_is_plotted(chunks, result):
    np.testing.assert_array_equal(numbers(chunks, f"/{FORCE}").reshape(-1, 3), result.wrench[:, :3])


def test_the_arrow_stands_at_the_flange_along_the_force(chunks):
    time = seconds(chunks, f"/{ARM}/{FORCE}")
    arrows = numbers_nested(chunks, f"/{ARM}/{FORCE}", "Arrows3D:vectors", 3)
    origins = numbers_nested(chunks, f"/{ARM}/{FORCE}", "Arrows3D:origins", 3)
    assert time[0] >= TIME[10]
    np.testing.assert_allclose(arrows[time < 1.99], 0.0)
    down = arrows[time > 2.01]
    np.testing.assert_allclose(down, np.tile([0.0, 0.0, -LONGEST * reach(MODEL)], (len(down), 1)), rtol=1e-6)
    robot, last = MODEL.robot, np.array([0.3, -0.2]) * time[-1]
    np.testing.assert_allclose(origins[-1], flange_position(robot.kinematics, robot.flange, last), atol=1e-6)


def test_viewer_shows_the_view_without_complaint(result, monkeypatch):
    """Two joints, the force, the arm, and the contacts."""
    view = contact_view(result, "N m")
    require_drawn(lambda: viewers.show(view, Targets(view=True)), TIME[-1], 5, monkeypatch)
