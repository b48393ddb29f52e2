"""Layout of the live view: one screen, one plot a quantity, one colour a joint, limits that were stated."""

from typing import NamedTuple

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identify.arm.robot import Robot
from exidyn.identify.model import Model
from exidyn.identify.pages.views.view_arm import arm_view
from exidyn.identify.pages.views.view_parts import TIMELINE

from .live_arm import ARM

SHOWN = 15.0
"""Seconds of the past that the plots show."""


EVENT_COLUMNS = rrb.TextLogColumns(
    timeline_columns=[rrb.encodings.TimelineColumn(TIMELINE, visible=False)],
    text_log_columns=["loglevel", "body"],
)
"""Without Rerun's time, whose column is too narrow to be read; the text begins with it."""


def layout(model: Model, effort: str, delay: float) -> rrb.Blueprint:
    """Plots on the left, the arm and what happened on the right.

    Args:
        model: What the arm looks like.
        effort: What the controller measures of it: "current" or "torque".
        delay: Age of velocity and residual [s].
    """
    revolute = bool(model.robot.revolute.all())
    angle, small = ("rad", "mrad") if revolute else ("rad, m", "mrad, mm")
    torque = "/".join(dict.fromkeys(model.robot.units("N m")))
    old = f"{1e3 * delay:.0f} ms old"
    plots = rrb.Grid(
        _plot("position", f"position, commanded in grey [{angle}]"),
        _plot("tracking_error", f"tracking error [{small}]", legend=True),
        _plot("velocity", f"velocity, {old} [{angle}/s]"),
        _plot(effort, f"{effort} [{'A' if effort == 'current' else torque}]"),
        _plot("residual", f"residual torque, {old} [{torque}]"),
        _plot("lateness", "lateness of cycles [ms]", legend=True),
        grid_columns=2,
    )
    beside = rrb.Vertical(
        arm_view(model, ARM),
        rrb.TextLogView(origin="events", name="events", columns=EVENT_COLUMNS),
        row_shares=[3, 2],
    )
    return rrb.Blueprint(
        rrb.Horizontal(plots, beside, column_shares=[5, 3]),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="following"),
        collapse_panels=True,
    )


def _plot(origin: str, name: str, legend: bool = False) -> rrb.TimeSeriesView:
    past = rr.VisibleTimeRange(
        TIMELINE,
        start=rr.TimeRangeBoundary.cursor_relative(seconds=-SHOWN),
        end=rr.TimeRangeBoundary.cursor_relative(),
    )
    return rrb.TimeSeriesView(
        origin=origin,
        name=name,
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=legend),
        time_ranges=[past],
    )


class DrawnLimits(NamedTuple):
    """Limits of one quantity that are finite, the lower ones before the upper.

    Attributes:
        joints: Which joint each belongs to, shape (k,).
        values: Shape (k,) in the unit of the quantity.
    """

    joints: np.ndarray
    values: np.ndarray

    @classmethod
    def of(cls, lower: np.ndarray, upper: np.ndarray) -> "DrawnLimits":
        """Those that are finite of two per joint, each (n,)."""
        both = np.concatenate([lower, upper])
        finite = np.flatnonzero(np.isfinite(both))
        return cls(finite % len(lower), both[finite])


def finite_limits(robot: Robot, effort: str) -> dict[str, DrawnLimits]:
    """Limits that are drawn, by quantity; without those that are not given.

    Args:
        robot: The arm.
        effort: "torque", or "current" for those that make the largest torque.
    """
    limits = robot.limits
    largest = limits.torque / np.abs(robot.drive_gain) if effort == "current" else limits.torque
    found = {
        "position": DrawnLimits.of(limits.position_lower, limits.position_upper),
        "velocity": DrawnLimits.of(limits.velocity_lower, limits.velocity),
        effort: DrawnLimits.of(-largest, largest),
    }
    return {quantity: some for quantity, some in found.items() if len(some.joints)}
