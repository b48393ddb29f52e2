"""Parts that all views share: timeline, colors, entities, plots, and the arm drawn as cylinders."""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any, Literal

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
import rerun.urdf

from exidyn.identification.arm.newton_euler import link_frames, link_poses
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_text import urdf_text

TIMELINE = "time"
COLORS = (
    *((86, 180, 233), (230, 159, 0), (0, 158, 115), (240, 228, 66), (204, 121, 167), (70, 110, 255)),
    (213, 94, 0),
)
"""Colors of the joints, readable as thin lines on any background and by color-blind people; an eighth joint
has the first color again."""
GRAY = (140, 140, 140)
"""Color of fixed links and of commands, visible on any background."""
RED = (255, 90, 60)
"""Color of stops, of limits and of values beyond them."""
FAINT = 110
"""Opacity of limits and commands, out of 255: visible but unobtrusive."""
FRAMES = 50.0
"""Frame rate of the arm [Hz]."""
ARM = "arm"
COLUMNS = 64
"""Width of an event's text [characters]; longer texts are wrapped, since a view cuts rows off."""
INDENT = 12 * " "
"""Indentation of wrapped rows."""
EVENT_STYLES = {"stop": ("CRITICAL", RED), "late": ("WARN", COLORS[1]), "warning": ("WARN", COLORS[1])}
"""Rerun's level and color by kind of event; other kinds are INFO in the color of text."""


def joint_colors(dof: int) -> list[tuple[int, int, int]]:
    """One color per joint."""
    return [COLORS[joint % len(COLORS)] for joint in range(dof)]


def entity(*parts: str) -> str:
    """Entity path from parts that may contain any character."""
    return str(rr.new_entity_path(list(parts)))


def arm_name(run: str) -> str:
    """Name of a run's arm: a part of its entity path, and the prefix of its link frames."""
    return f"arm in {run}"


def style_lines(
    stream: rr.RecordingStream, path: str, names: Sequence[str], colors: Sequence[tuple], width: float = 1.5
) -> None:
    """Log names, colors and width [pixels] of the lines of an entity."""
    lines = rr.SeriesLines(names=list(names), colors=list(colors), widths=width)
    stream.log(path, lines, static=True)


def send(stream: rr.RecordingStream, path: str, time: np.ndarray, values: np.ndarray) -> None:
    """Log all samples of an entity at once: time (t,) [s], values (t,) or (t, n)."""
    index = rr.TimeColumn(TIMELINE, duration=time)
    stream.send_columns(path, indexes=[index], columns=rr.Scalars.columns(scalars=values))


def log_lines(
    stream: rr.RecordingStream,
    path: str,
    names: Sequence[str],
    colors: Sequence[tuple],
    time: np.ndarray,
    values: np.ndarray,
    width: float = 1.5,
) -> None:
    """Log lines with their style; see `style_lines` and `send`."""
    style_lines(stream, path, names, colors, width)
    send(stream, path, time, values)


def log_markdown(stream: rr.RecordingStream, path: str, text: str) -> None:
    """Log a text that has no time."""
    stream.log(path, rr.TextDocument(text, media_type="text/markdown"), static=True)


def log_event(stream: rr.RecordingStream, origin: Sequence[str], time: float, kind: str, text: str) -> None:
    """Log an event at a time [s], as rows below an entity path given by its parts."""
    level, color = EVENT_STYLES.get(kind, ("INFO", None))
    stream.set_time(TIMELINE, duration=time)
    # one entity per kind, since an event without a color would get that of the previous event
    path = entity(*origin, kind)
    for line in wrap(f"{time:.2f} s  {kind}: {text}", COLUMNS, subsequent_indent=INDENT):
        stream.log(path, rr.TextLog(line, level=level, color=color))


def event_list(origin: str) -> rrb.TextLogView:
    """A list of events, whose texts start with the time; Rerun's time column is too narrow to read."""
    time = rrb.encodings.TimelineColumn(TIMELINE, visible=False)
    columns = rrb.TextLogColumns(timeline_columns=[time], text_log_columns=["loglevel", "body"])
    return rrb.TextLogView(origin=origin, name="events", columns=columns)


def plot(origin: str, name: str, legend: bool = False, **options: Any) -> rrb.TimeSeriesView:
    """A plot of the lines below an entity, with the legend in the top left corner."""
    corner = rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=legend)
    return rrb.TimeSeriesView(origin=origin, name=name, plot_legend=corner, **options)


def screen(
    layout: rrb.Container, play_state: Literal["paused", "following"] | None = "paused"
) -> rrb.Blueprint:
    """A blueprint of the layout alone, without Rerun's side panels."""
    panel = rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state=play_state)
    return rrb.Blueprint(layout, panel, collapse_panels=True)


class Arm:
    """An arm that is drawn once and then moved; each link has the color of its joint, or all have one color.

    Its name is a part of its entity path, and the prefix of its link frames.
    """

    def __init__(
        self,
        stream: rr.RecordingStream,
        model: Model,
        name: str = ARM,
        color: tuple[int, int, int] | None = None,
    ) -> None:
        self._stream, self._kinematics, self._name = stream, model.robot.kinematics, name
        self._frames = link_frames(self._kinematics)
        tree = _urdf_tree(model, name)
        tree.log_urdf_to_recording(stream)
        moving = [frame.child for frame in self._frames]
        colors = dict(zip(moving, joint_colors(len(moving)), strict=True))
        for link in {frame.parent for frame in self._frames} | set(moving):
            solid = rr.Cylinders3D.from_fields(colors=color or colors.get(link, GRAY), fill_mode="solid")
            for path in tree.get_visual_geometry_paths(link):
                stream.log(path, solid, static=True)

    def move(self, time: np.ndarray, position: np.ndarray) -> None:
        """Move the arm along positions (t, n) at times (t,) [s]; a message for all joints halves the size."""
        poses = link_poses(self._kinematics, position).reshape(-1, 7)
        columns = rr.Transform3D.columns(
            translation=poses[:, :3],
            quaternion=poses[:, 3:],
            parent_frame=[f"{self._name}/{frame.parent}" for frame in self._frames] * len(time),
            child_frame=[f"{self._name}/{frame.child}" for frame in self._frames] * len(time),
        )
        index = rr.TimeColumn(TIMELINE, duration=np.repeat(time, len(self._frames)))
        self._stream.send_columns(entity(self._name, "moves"), indexes=[index], columns=columns)


def arm_view(
    model: Model, name: str = ARM, beside: Sequence[str] = (), title: str = "arm"
) -> rrb.Spatial3DView:
    """The arm, and others with the given names, from where it is in sight in any pose."""
    size = reach(model)
    eye = rrb.EyeControls3D(position=[1.3 * size, -1.1 * size, 0.95 * size], look_target=[0, 0, 0.2 * size])
    ground = rrb.SpatialInformation(target_frame=base_frame(model, name))
    return rrb.Spatial3DView(
        origin="/" if beside else entity(name),
        contents=[f"+ {entity(arm)}/**" for arm in (name, *beside)],
        name=title,
        spatial_information=ground,
        eye_controls=eye,
    )


def reach(model: Model) -> float:
    """Maximum reach of the arm [m]; 1 if all axes intersect."""
    lengths = [np.linalg.norm(place.translation) for place in model.robot.kinematics.jointPlacements]
    return float(np.sum(lengths)) or 1.0


def base_frame(model: Model, name: str = ARM) -> str:
    """Name of the base frame of the arm."""
    return f"{name}/{_urdf_tree(model, name).root_link().name}"


def _urdf_tree(model: Model, name: str) -> rerun.urdf.UrdfTree:
    """The arm as URDF, with entities and frames that differ from those of other arms."""
    with tempfile.TemporaryDirectory() as folder:  # Rerun reads URDF from files only
        path = Path(folder) / "arm.urdf"
        path.write_text(urdf_text(model), encoding="utf-8")
        fixed = entity(name, "fixed")
        return rerun.urdf.UrdfTree.from_file_path(
            path, name, frame_prefix=f"{name}/", static_transform_entity_path=fixed
        )
