"""View of a fit: what it predicts of recordings, or of a fit alone its parameters beside the arm."""

from collections.abc import Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identify.fit.fit import Fit
from exidyn.identify.pages.views.view import blueprint, log_fit
from exidyn.identify.pages.views.view_arm import arm_view
from exidyn.identify.recordings.recording import Recording
from exidyn.identify.simulation.predicted import predicted

from ..live.live_arm import ARM, LiveArm
from ..live.live_log import COLOURS
from .screen import View


def fit_view(fit: Fit, recordings: Sequence[Recording]) -> View:
    """A view of a fit.

    Args:
        fit: As read from its file, which has no samples.
        recordings: What it is asked to predict.

    Raises:
        DifferentRobot: Of other joints.
        RecordingError: One that is too short for the fit's filters.
    """
    fit = predicted(fit, recordings)
    if not recordings:
        return View("fit", lambda stream: _log_alone(stream, fit), _layout_alone(fit))
    return View("fit", lambda stream: log_fit(stream, fit), blueprint(fit))


def _log_alone(stream: rr.RecordingStream, fit: Fit) -> None:
    """The fit, and the arm with all joints at zero."""
    log_fit(stream, fit)
    dof = fit.model.robot.dof
    arm = LiveArm(stream, fit.model, [COLOURS[joint % len(COLOURS)] for joint in range(dof)])
    arm.move(np.zeros(1), np.zeros((1, dof)))


def _layout_alone(fit: Fit) -> rrb.Blueprint:
    intervals = rrb.BarChartView(origin="parameters/interval", name="95 % interval [% of value]")
    layout = rrb.Horizontal(
        rrb.Vertical(arm_view(fit.model, ARM), intervals, row_shares=[3, 2]),
        rrb.TextDocumentView(origin="parameters/table", name="parameters"),
        rrb.TextDocumentView(origin="verdict", name="verdict"),
    )
    return rrb.Blueprint(layout, rrb.TimePanel(state="hidden"), collapse_panels=True)
