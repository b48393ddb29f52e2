"""View: a fit as a Rerun recording. The one module that knows Rerun.

Every run has its own tab with one plot a joint, the arm as it moved, and all residuals over their noise;
beside them stand the verdict, the parameters as a table, and their intervals as a bar chart.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
import rerun.urdf

from .errors import UnknownJoint
from .fit import Agreement, Fit
from .report_plots import measured_unit
from .robot import Robot
from .urdf_text import urdf_text
from .verdict import NORMAL_95
from .view_text import parameters_markdown, verdict_markdown

TIMELINE = "time"
LINES = {"measured": (3.5, 230, 159, 0), "predicted": (1.2, 86, 180, 233), "residual": (1.0, 213, 94, 0)}
"""Width in pixels and colour of each line: Okabe and Ito's, on Rerun's dark ground."""
JOINTS = ((86, 180, 233), (230, 159, 0), (0, 158, 115), (240, 228, 66), (204, 121, 167), (213, 94, 0))
"""Colours by which colour-blind readers, too, tell the joints apart; a seventh joint is white."""
WHITE = (240, 240, 240)
CAPPED = 100.0
"""Per cent at which a bar ends: beyond it not even the sign is known, and others would look like none."""


def save_rerun(fit: Fit, path: Path) -> None:
    """Save measured, predicted and residual torque, parameters and the moving arm as an .rrd file."""
    recording = rr.RecordingStream("exidyn_fit")
    recording.save(str(path), default_blueprint=blueprint(fit))
    log_fit(recording, fit)
    recording.disconnect()  # writes the footer, without which readers complain


def open_rerun(fit: Fit) -> "subprocess.Popen[bytes]":
    """Show a fit in Rerun's viewer, which lives on after this process.

    The viewer gets a file in the temporary folder rather than a stream, and listens on this machine
    only: by default it would take data from anyone on the network.
    """
    path = Path(tempfile.mkdtemp(prefix="exidyn_")) / "fit.rrd"
    save_rerun(fit, path)
    return subprocess.Popen([sys.executable, "-m", "rerun", "--bind", "127.0.0.1", str(path)])


def log_fit(recording: rr.RecordingStream, fit: Fit) -> None:
    """Write everything to an open recording."""
    recording.log("verdict", rr.TextDocument(verdict_markdown(fit), media_type="text/markdown"), static=True)
    recording.log(
        "parameters/table", rr.TextDocument(parameters_markdown(fit), media_type="text/markdown"), static=True
    )
    recording.log("parameters/interval", _interval_bars(fit), static=True)
    for run in _runs(fit):
        _log_run(recording, fit.model.robot, run)
        _log_arm(recording, fit, run)


def blueprint(fit: Fit) -> rrb.Blueprint:
    """One screen: a tab a run on the left, what was found on the right."""
    found = rrb.Vertical(
        rrb.TextDocumentView(origin="verdict", name="verdict"),
        rrb.Tabs(
            rrb.TextDocumentView(origin="parameters/table", name="parameters"),
            rrb.BarChartView(origin="parameters/interval", name="95 % interval [% of value]"),
        ),
        row_shares=[2, 3],
    )
    runs = [_run_tab(fit, run) for run in _runs(fit)]
    layout = rrb.Horizontal(rrb.Tabs(*runs, active_tab=0), found, column_shares=[3, 1]) if runs else found
    return rrb.Blueprint(layout, rrb.TimePanel(state="collapsed", timeline=TIMELINE), collapse_panels=True)


def _run_tab(fit: Fit, run: Agreement) -> rrb.Container:
    plots = [
        rrb.TimeSeriesView(
            origin=_entity(run, "torque", joint),
            name=f"{joint}: torque [{measured_unit(fit, index)}]",
            plot_legend=rrb.PlotLegend(visible=index == 0),
        )
        for index, joint in enumerate(fit.model.robot.joints)
    ]
    ratio = rrb.TimeSeriesView(origin=_entity(run, "over_noise"), name="residual / noise")
    content = rrb.Grid(*plots, grid_columns=2)
    if run.position is None:
        return rrb.Vertical(content, ratio, row_shares=[3, 1], name=run.run)
    beside = rrb.Vertical(_arm_view(fit, run), ratio, row_shares=[3, 2])
    return rrb.Horizontal(content, beside, column_shares=[2, 1], name=run.run)


def _arm_view(fit: Fit, run: Agreement) -> rrb.Spatial3DView:
    """The arm from a place where all of it is in sight, however it stretches."""
    lengths = [np.linalg.norm(place.translation) for place in fit.model.robot.kinematics.jointPlacements]
    reach = float(np.sum(lengths)) or 1.0
    eye = rrb.EyeControls3D(
        position=[1.1 * reach, -0.9 * reach, 0.8 * reach], look_target=[0, 0, 0.3 * reach]
    )
    ground = rrb.SpatialInformation(target_frame=f"{_arm_name(run)}/{_arm(fit, run).root_link().name}")
    origin = rr.new_entity_path([_arm_name(run)])
    return rrb.Spatial3DView(origin=origin, name="arm", spatial_information=ground, eye_controls=eye)


def _runs(fit: Fit) -> list[Agreement]:
    """Runs held out first: they are the ones that judge."""
    return [*fit.validation, *fit.agreement]


def _entity(run: Agreement, *parts: str) -> str:
    """Entity path below a run, whose own name may hold any sign."""
    return str(rr.new_entity_path(["runs", run.run, *parts]))


def _arm_name(run: Agreement) -> str:
    """Name of a run's arm: one part of an entity path, and the prefix of its link frames."""
    return f"arm in {run.run}"


def _log_run(recording: rr.RecordingStream, robot: Robot, run: Agreement) -> None:
    for index, joint in enumerate(robot.joints):
        for name, (width, *colour) in LINES.items():
            entity = _entity(run, "torque", joint, name)
            recording.log(entity, rr.SeriesLines(names=name, colors=colour, widths=width), static=True)
            _send(recording, entity, run.time, getattr(run, name)[:, index])
    entity = _entity(run, "over_noise")
    colours = [*JOINTS, *[WHITE] * robot.dof][: robot.dof]
    recording.log(entity, rr.SeriesLines(names=list(robot.joints), colors=colours), static=True)
    _send(recording, entity, run.time, run.residual / run.noise)


def _send(recording: rr.RecordingStream, entity: str, time: np.ndarray, values: np.ndarray) -> None:
    """All samples of an entity at once, values (r,) or (r, n)."""
    index = rr.TimeColumn(TIMELINE, duration=time)
    recording.send_columns(entity, indexes=[index], columns=rr.Scalars.columns(scalars=values))


def _log_arm(recording: rr.RecordingStream, fit: Fit, run: Agreement) -> None:
    """The arm as cylinders, moving as it did in the run."""
    if run.position is None:
        return
    tree = _arm(fit, run)
    tree.log_urdf_to_recording(recording)
    index = rr.TimeColumn(TIMELINE, duration=run.time)
    for place, name in enumerate(fit.model.robot.joints):
        joint = tree.get_joint_by_name(name)
        if joint is None:
            raise UnknownJoint(name, "the robot as drawn", [drawn.name for drawn in tree.joints()])
        columns = joint.compute_transform_columns(run.position[:, place].tolist(), clamp=False)
        recording.send_columns(
            rr.new_entity_path([_arm_name(run), "moves", name]), indexes=[index], columns=columns
        )


def _arm(fit: Fit, run: Agreement) -> rerun.urdf.UrdfTree:
    """The arm of one run, its entities and frames apart from those of other runs."""
    with tempfile.TemporaryDirectory() as folder:  # Rerun reads URDF from files only
        path = Path(folder) / "arm.urdf"
        path.write_text(urdf_text(fit.model), encoding="utf-8")
        return rerun.urdf.UrdfTree.from_file_path(
            path,
            _arm_name(run),
            frame_prefix=f"{_arm_name(run)}/",
            static_transform_entity_path=rr.new_entity_path([_arm_name(run), "fixed"]),
        )


def _interval_bars(fit: Fit) -> rr.BarChart:
    """Half-width of each 95 % interval in per cent of the value, in the order of the table."""
    size = np.maximum(np.abs(fit.estimate.values), np.finfo(float).tiny)
    return rr.BarChart(np.minimum(100.0 * NORMAL_95 * fit.estimate.std / size, CAPPED))
