"""View: a plan as a Rerun recording, the arm moving beside its plots."""

import subprocess
from functools import partial
from pathlib import Path

import numpy as np
import pinocchio as pin
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identify.arm.robot import Robot
from exidyn.identify.model import Model
from exidyn.identify.pages.views.view_arm import arm_tree, arm_view, log_arm
from exidyn.identify.pages.views.view_parts import JOINTS, TIMELINE, WHITE, open_viewer, send

from ..trajectory import unit_of
from .plan import Plan
from .plan_check import nominal_torque, violations
from .plan_plots import Curve, plan_curves
from .plan_summary import summary

ARM = "arm"
FRAMES = 60.0
"""Pictures of the arm a second [Hz]."""
LINES = ((86, 180, 233), (230, 159, 0))
"""Colours of the first run and of the second."""
RED = (255, 90, 60)
"""Of limits and of what is beyond them."""
PATH = (0, 158, 115)
"""Of the way that the flange takes."""


def save_rerun(plan: Plan, model: Model, path: Path) -> None:
    """Save plots of all joints against their limits, and the moving arm, as an .rrd file."""
    curves = _curves(plan, model)
    recording = rr.RecordingStream("exidyn_plan")
    recording.save(str(path), default_blueprint=blueprint(plan, model, curves))
    log_plan(recording, plan, model, curves)
    recording.disconnect()  # writes the footer, without which readers complain


def open_rerun(plan: Plan, model: Model) -> "subprocess.Popen[bytes]":
    """Show a plan in Rerun's viewer, which lives on after this process."""
    return open_viewer(partial(save_rerun, plan, model), "plan")


def _curves(plan: Plan, model: Model) -> list[Curve]:
    return plan_curves(plan, nominal_torque(plan, model))


def log_plan(recording: rr.RecordingStream, plan: Plan, model: Model, curves: list[Curve]) -> None:
    """Write everything to an open recording."""
    uses = [curve.use for curve in curves]
    words = f"```\n{summary(plan, uses, violations(plan, nominal_torque(plan, model)))}\n```"
    recording.log("summary", rr.TextDocument(words, media_type="text/markdown"), static=True)
    for curve in curves:
        _log_share(recording, plan, curve)
        for joint, name in enumerate(plan.joints):
            _log_joint(recording, curve, joint, name)
    states = plan.trajectory.every(1.0 / FRAMES)
    log_arm(recording, model, ARM, states.time, states.position)
    _log_path(recording, model, states.position)


def blueprint(plan: Plan, model: Model, curves: list[Curve]) -> rrb.Blueprint:
    """One screen: plots on the left, of all joints together or of each quantity; the arm on the right."""
    together = rrb.Vertical(
        *(
            rrb.TimeSeriesView(
                origin=_entity("share", curve.use.name),
                name=f"{curve.use.name} [% of limit]",
                plot_legend=rrb.PlotLegend(visible=place == 0),
                axis_y=rrb.ScalarAxis(range=_percents(curve)),
            )
            for place, curve in enumerate(curves)
        ),
        name="all joints",
    )
    tabs = rrb.Tabs(together, *(_quantity_tab(plan, curve) for curve in curves), active_tab=0)
    beside = rrb.Vertical(
        arm_view(model, ARM), rrb.TextDocumentView(origin="summary", name="summary"), row_shares=[3, 2]
    )
    layout = rrb.Horizontal(tabs, beside, column_shares=[1, 1])
    return rrb.Blueprint(layout, rrb.TimePanel(state="collapsed", timeline=TIMELINE), collapse_panels=True)


def _percents(curve: Curve) -> tuple[float, float]:
    """Both limits, and all that is beyond them."""
    largest = float(np.nanmax(curve.use.share, initial=1.0))
    return -110.0 * largest, 110.0 * largest


def _quantity_tab(plan: Plan, curve: Curve) -> rrb.Container:
    views = [
        rrb.TimeSeriesView(
            origin=_entity(curve.use.name, joint),
            name=f"{joint}: {curve.use.name} [{unit_of(curve.use.name, unit)}]",
            plot_legend=rrb.PlotLegend(visible=place == 0),
        )
        for place, (joint, unit) in enumerate(zip(plan.joints, plan.units, strict=True))
    ]
    return rrb.Grid(*views, grid_columns=2, name=curve.use.name)


def _entity(*parts: str) -> str:
    """Entity path of parts that may hold any sign."""
    return str(rr.new_entity_path(list(parts)))


def _log_share(recording: rr.RecordingStream, plan: Plan, curve: Curve) -> None:
    """All joints on one scale: from -100 % at the lower limit to 100 % at the upper one."""
    entity = _entity("share", curve.use.name)
    colours = [*JOINTS, *[WHITE] * len(plan.joints)][: len(plan.joints)]
    recording.log(entity, rr.SeriesLines(names=list(plan.joints), colors=colours), static=True)
    send(recording, entity, curve.time, 100.0 * curve.use.shares(curve.runs[-1][1]))
    entity = _entity("share", curve.use.name, "limit")
    recording.log(
        entity, rr.SeriesLines(names=["limit", "limit"], colors=[RED, RED], widths=1.0), static=True
    )
    send(recording, entity, curve.time[[0, -1]], np.array([[-100.0, 100.0]] * 2))


def _log_joint(recording: rr.RecordingStream, curve: Curve, joint: int, name: str) -> None:
    """A joint's curve of each run, its limits, and where it is beyond them."""
    ends = curve.time[[0, -1]]
    for colour, (run, values) in zip(LINES, curve.runs, strict=False):
        entity = _entity(curve.use.name, name, run)
        recording.log(entity, rr.SeriesLines(names=run, colors=colour, widths=1.5), static=True)
        send(recording, entity, curve.time, values[:, joint])
        beyond = curve.use.beyond(values[:, joint], joint)
        if np.any(beyond):
            entity = _entity(curve.use.name, name, f"{run} beyond")
            recording.log(entity, rr.SeriesPoints(names="beyond", colors=RED, marker_sizes=3), static=True)
            send(recording, entity, curve.time[beyond], values[beyond, joint])
    for side in ("lower", "upper"):
        limit = getattr(curve.use, side)[joint]
        if np.isfinite(limit):
            entity = _entity(curve.use.name, name, f"{side} limit")
            recording.log(entity, rr.SeriesLines(names="limit", colors=RED, widths=1.0), static=True)
            send(recording, entity, ends, np.full(2, limit))


def _log_path(recording: rr.RecordingStream, model: Model, position: np.ndarray) -> None:
    """The way of the flange, as a line in the frame of the base."""
    entity = _entity(ARM, "path of the flange")
    frame = f"{ARM}/{arm_tree(model, ARM).root_link().name}"
    recording.log(entity, rr.CoordinateFrame(frame), static=True)
    way = flange_path(model.robot, position)
    recording.log(entity, rr.LineStrips3D([way], colors=PATH, radii=rr.Radius.ui_points(1.0)), static=True)


def flange_path(robot: Robot, position: np.ndarray) -> np.ndarray:
    """Where the flange is, in the frame of the base, shape (t, 3) [m]."""
    data = robot.kinematics.createData()
    way = np.empty((len(position), 3))
    for row, pose in enumerate(position):
        pin.forwardKinematics(robot.kinematics, data, pose)
        way[row] = (data.oMi[robot.dof] * robot.flange).translation
    return way
