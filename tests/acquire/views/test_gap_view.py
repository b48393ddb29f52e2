"""View of a gap: arms in one place, lines of what is simulated less what was recorded."""

from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.acquire.views import viewers
from exidyn.acquire.views.gap_view import AFTER, BEFORE, RECORDED, gap_view
from exidyn.acquire.views.live_view import Targets
from exidyn.identification.in_mujoco.replay import Run

from ...parts.pages.rerun_viewer import numbers, require_drawn, require_poses, saved, seconds
from ...parts.small import two_joints

pytestmark = pytest.mark.slow

MODEL = two_joints.model()
TIME = np.arange(0.0, 4.0, 0.01)
PLACE = np.column_stack([np.sin(TIME), np.cos(2 * TIME)])
LOST = 300
"""Sample from which the first simulation has diverged."""


@pytest.fixture(scope="module")
def gap():
    """What the view reads of a gap: two runs, of which the first diverges in the simulation of the file."""
    runs = tuple(
        Run(name, TIME, PLACE, 0 * PLACE, 0 * PLACE, False, None, np.zeros(2)) for name in ("one", "two")
    )
    diverged = np.where(np.arange(len(TIME))[:, None] < LOST, PLACE + 0.2, np.inf)
    before = SimpleNamespace(traces=(diverged, PLACE + 0.1))
    after = SimpleNamespace(traces=(PLACE + 0.001, PLACE + 0.002))
    joints = SimpleNamespace(joints=MODEL.robot.joints)
    attached = SimpleNamespace(distances=after)
    return SimpleNamespace(runs=runs, original=before, attached=attached, diagnosis=joints)


@pytest.fixture(scope="module")
def chunks(gap, tmp_path_factory):
    return saved(gap_view(gap, MODEL), tmp_path_factory.mktemp("view") / "gap.rrd")


def test_lines_are_simulated_less_recorded(chunks):
    np.testing.assert_allclose(numbers(chunks, f"/two/elbow/{BEFORE}"), 100.0)
    np.testing.assert_allclose(numbers(chunks, f"/one/shoulder/{AFTER}"), 1.0)
    lost = numbers(chunks, f"/one/shoulder/{BEFORE}")
    np.testing.assert_allclose(lost[:LOST], 200.0)
    np.testing.assert_allclose(lost[LOST:], 1e3 * (PLACE[LOST - 1, 0] + 0.2 - PLACE[LOST:, 0]))


@pytest.mark.parametrize(("which", "away"), [(RECORDED, 0.0), (BEFORE, 0.1), (AFTER, 0.002)])
def test_each_arm_moves_as_it_did(chunks, which, away):
    entity = f"/{which} in two/moves"
    at = np.searchsorted(TIME, seconds(chunks, entity)[::2] - 1e-6)
    require_poses(chunks, entity, MODEL.robot.kinematics, PLACE[at] + away)


def test_viewer_shows_every_view_without_complaint(gap, monkeypatch):
    """Two joints and the arms, in each of two runs."""
    require_drawn(lambda: viewers.show(gap_view(gap, MODEL), Targets(view=True)), TIME[-1], 6, monkeypatch)
