"""View of a plan: the arm moving beside plots of all joints against their limits."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from scipy.spatial import ConvexHull

from exidyn.identification.document.text import text
from exidyn.identification.model import Model
from exidyn.trajectories.clearances.region import HalfSpace
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_check import Curve, nominal_torque, violations
from exidyn.trajectories.plans.plan_page import plan_curves
from exidyn.trajectories.plans.plan_space import Space
from exidyn.trajectories.plans.plan_summary import plan_document
from exidyn.trajectories.trajectory import unit_of

from .parts import (
    ARM,
    FRAMES,
    RED,
    Arm,
    arm_view,
    base_frame,
    entity,
    joint_colors,
    log_lines,
    log_markdown,
    plot,
    reach,
    screen,
    send,
)
from .viewers import View

LINES = ((86, 180, 233), (230, 159, 0))
"""Colors of the first and the second run."""
PATH = (0, 158, 115)
"""Color of the path of the flange."""


def plan_view(plan: Plan, model: Model, space: Space) -> View:
    """A view of a plan for an arm and its surroundings."""
    torque = nominal_torque(plan, model)
    curves = plan_curves(plan, torque)

    def log(stream: rr.RecordingStream) -> None:
        uses = [curve.use for curve in curves]
        document = plan_document(plan, uses, violations(plan, torque))
        log_markdown(stream, "summary", f"```\n{text(document)}\n```")
        for curve in curves:
            _log_share(stream, plan, curve)
            for joint, name in enumerate(plan.joints):
                _log_joint(stream, curve, joint, name)
        states = plan.trajectory.every(1.0 / FRAMES)
        Arm(stream, model).move(states.time, states.position)
        _log_space(stream, model, space)

    return View("plan", log, _layout(plan, model, curves))


def _layout(plan: Plan, model: Model, curves: list[Curve]) -> rrb.Blueprint:
    """Plots on the left, of all joints together or of each quantity; the arm on the right."""
    shares, quantities = list[rrb.TimeSeriesView](), list[rrb.Grid]()
    for curve in curves:
        name = curve.use.name
        largest = 110.0 * float(np.nanmax(curve.use.share, initial=1.0))  # [%], more than limits and values
        axis = rrb.ScalarAxis(range=(-largest, largest))
        shares.append(plot(entity("share", name), f"{name} [% of limit]", legend=not shares, axis_y=axis))
        joints = [
            plot(entity(name, joint), f"{joint}: {name} [{unit_of(name, unit)}]", legend=place == 0)
            for place, (joint, unit) in enumerate(zip(plan.joints, plan.units, strict=True))
        ]
        quantities.append(rrb.Grid(*joints, grid_columns=2, name=name))
    tabs = rrb.Tabs(rrb.Vertical(*shares, name="all joints"), *quantities, active_tab=0)
    words = rrb.TextDocumentView(origin="summary", name="summary")
    beside = rrb.Vertical(arm_view(model), words, row_shares=[3, 2])
    return screen(rrb.Horizontal(tabs, beside, column_shares=[1, 1]), play_state=None)


def _log_share(stream: rr.RecordingStream, plan: Plan, curve: Curve) -> None:
    """Log all joints on one scale, from -100 % at the lower limit to 100 % at the upper limit."""
    path, time = entity("share", curve.use.name), curve.time
    shares = 100.0 * curve.use.shares(curve.runs[-1][1])
    log_lines(stream, path, plan.joints, joint_colors(len(plan.joints)), time, shares)
    path, limits = entity("share", curve.use.name, "limit"), np.array([[-100.0, 100.0]] * 2)
    log_lines(stream, path, ["limit", "limit"], [RED, RED], time[[0, -1]], limits, 1.0)


def _log_joint(stream: rr.RecordingStream, curve: Curve, joint: int, name: str) -> None:
    """Log the curves of a joint, its limits, and the values beyond them."""
    for color, (run, values) in zip(LINES, curve.runs, strict=False):
        path = entity(curve.use.name, name, run)
        log_lines(stream, path, [run], [color], curve.time, values[:, joint])
        beyond = curve.use.beyond(values[:, joint], joint)
        if np.any(beyond):
            path = entity(curve.use.name, name, f"{run} beyond")
            stream.log(path, rr.SeriesPoints(names="beyond", colors=RED, marker_sizes=3), static=True)
            send(stream, path, curve.time[beyond], values[beyond, joint])
    for side in ("lower", "upper"):
        limit = getattr(curve.use, side)[joint]
        if np.isfinite(limit):
            path = entity(curve.use.name, name, f"{side} limit")
            log_lines(stream, path, ["limit"], [RED], curve.time[[0, -1]], np.full(2, limit), 1.0)


def _log_space(stream: rr.RecordingStream, model: Model, space: Space) -> None:
    """Log the path of the flange as a line, and obstacles and walls as meshes, in the base frame."""
    size = float(np.max(np.abs(space.path), initial=reach(model)))
    meshes = {name: (points, ConvexHull(points).simplices) for name, points in space.solids}
    meshes |= {wall.name: _square(wall, size) for wall in space.walls}
    for name, (points, triangles) in meshes.items():
        solid = name in dict(space.solids)
        mesh = rr.Mesh3D(
            vertex_positions=points, triangle_indices=triangles, albedo_factor=(*RED, 130 if solid else 40)
        )
        _log_at_base(stream, model, name, mesh)
    line = rr.LineStrips3D([space.path], colors=PATH, radii=rr.Radius.ui_points(1.0))
    _log_at_base(stream, model, "path of the flange", line)


def _log_at_base(stream: rr.RecordingStream, model: Model, name: str, content: rr.AsComponents) -> None:
    path = entity(ARM, name)
    stream.log(path, rr.CoordinateFrame(base_frame(model)), static=True)
    stream.log(path, content, static=True)


def _square(wall: HalfSpace, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Corners (4, 3) and triangles of a square on a wall, centered at its point nearest the base."""
    across = np.cross(wall.normal, np.eye(3)[np.argmin(np.abs(wall.normal))])
    across /= np.linalg.norm(across)
    along, middle = np.cross(wall.normal, across), wall.offset * wall.normal
    corners = [middle + size * (a * across + b * along) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return np.array(corners), np.array([[0, 1, 2], [0, 2, 3]])
