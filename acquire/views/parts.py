"""What every view shares: time line, colours, entities, plots, and the arm drawn as cylinders."""

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
COLOURS = (
    *((86, 180, 233), (230, 159, 0), (0, 158, 115), (240, 228, 66), (204, 121, 167), (70, 110, 255)),
    (213, 94, 0),
)
"""Of the joints, as thin lines on dark ground and on light, for colour-blind readers too; an eighth joint
has the first again."""
GREY = (140, 140, 140)
"""Of what no joint moves, seen on dark ground and on light."""
RED = (255, 90, 60)
"""Of a stop, of limits and of what is beyond them."""
FAINT = 110
"""Opacity of limits and commands, of 255: there, and not in the way."""
FRAMES = 50.0
"""Pictures of the arm a second [Hz]."""
ARM = "arm"
COLUMNS = 64
"""Width of an event's text: what is longer goes on in a row of its own, since a view cuts rows off."""
INDENT = 12 * " "
"""Of such rows."""
LOOKS = {"stop": ("CRITICAL", RED), "late": ("WARN", COLOURS[1]), "warning": ("WARN", COLOURS[1])}
"""What Rerun calls an event of a kind, and its colour; the others are INFO and have the colour of text."""


def joint_colours(dof: int) -> list[tuple[int, int, int]]:
    """One colour a joint."""
    return [COLOURS[joint % len(COLOURS)] for joint in range(dof)]


def entity(*parts: str) -> str:
    """Entity path of parts that may hold any sign."""
    return str(rr.new_entity_path(list(parts)))


def arm_name(run: str) -> str:
    """Name of a run's arm: one part of an entity path, and the prefix of its link frames."""
    return f"arm in {run}"


def style_lines(
    stream: rr.RecordingStream, path: str, names: Sequence[str], colours: Sequence[tuple], width: float = 1.5
) -> None:
    """Names, colours and width [pixels] of the lines of an entity."""
    lines = rr.SeriesLines(names=list(names), colors=list(colours), widths=width)
    stream.log(path, lines, static=True)


def send(stream: rr.RecordingStream, path: str, time: np.ndarray, values: np.ndarray) -> None:
    """Log all samples of an entity at once: time (t,) [s], values (t,) or (t, n)."""
    index = rr.TimeColumn(TIMELINE, duration=time)
    stream.send_columns(path, indexes=[index], columns=rr.Scalars.columns(scalars=values))


def log_lines(
    stream: rr.RecordingStream,
    path: str,
    names: Sequence[str],
    colours: Sequence[tuple],
    time: np.ndarray,
    values: np.ndarray,
    width: float = 1.5,
) -> None:
    """Log lines whole, see `style_lines` and `send`."""
    style_lines(stream, path, names, colours, width)
    send(stream, path, time, values)


def log_markdown(stream: rr.RecordingStream, path: str, text: str) -> None:
    """Log a text without a time."""
    stream.log(path, rr.TextDocument(text, media_type="text/markdown"), static=True)


def log_event(stream: rr.RecordingStream, origin: Sequence[str], time: float, kind: str, text: str) -> None:
    """Log what happened at a time [s], in rows below an entity path, given by its parts."""
    level, colour = LOOKS.get(kind, ("INFO", None))
    stream.set_time(TIMELINE, duration=time)
    # an entity a kind, since one without a colour gets that of the one before
    path = entity(*origin, kind)
    for line in wrap(f"{time:.2f} s  {kind}: {text}", COLUMNS, subsequent_indent=INDENT):
        stream.log(path, rr.TextLog(line, level=level, color=colour))


def event_list(origin: str) -> rrb.TextLogView:
    """What happened; without Rerun's time, whose column is too narrow to be read: the text begins with it."""
    time = rrb.encodings.TimelineColumn(TIMELINE, visible=False)
    columns = rrb.TextLogColumns(timeline_columns=[time], text_log_columns=["loglevel", "body"])
    return rrb.TextLogView(origin=origin, name="events", columns=columns)


def plot(origin: str, name: str, legend: bool = False, **options: Any) -> rrb.TimeSeriesView:
    """A plot of the lines below an entity; the legend in the corner that is least in the way."""
    corner = rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=legend)
    return rrb.TimeSeriesView(origin=origin, name=name, plot_legend=corner, **options)


def screen(
    layout: rrb.Container, play_state: Literal["paused", "following"] | None = "paused"
) -> rrb.Blueprint:
    """The layout alone, without Rerun's panels, which show it to people who build it."""
    panel = rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state=play_state)
    return rrb.Blueprint(layout, panel, collapse_panels=True)


class Arm:
    """An arm that is drawn once, each link in the colour of the joint that moves it or all in one, and moved.

    Its name is one part of an entity path, and the prefix of the link frames.
    """

    def __init__(
        self,
        stream: rr.RecordingStream,
        model: Model,
        name: str = ARM,
        colour: tuple[int, int, int] | None = None,
    ) -> None:
        self._stream, self._kinematics, self._name = stream, model.robot.kinematics, name
        self._frames = link_frames(self._kinematics)
        tree = _urdf_tree(model, name)
        tree.log_urdf_to_recording(stream)
        moved = [frame.child for frame in self._frames]
        colours = dict(zip(moved, joint_colours(len(moved)), strict=True))
        for link in {frame.parent for frame in self._frames} | set(moved):
            solid = rr.Cylinders3D.from_fields(colors=colour or colours.get(link, GREY), fill_mode="solid")
            for path in tree.get_visual_geometry_paths(link):
                stream.log(path, solid, static=True)

    def move(self, time: np.ndarray, position: np.ndarray) -> None:
        """Move it along positions (t, n) at times (t,) [s]; one message for all joints, which spares half."""
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
    """The arm, and others of these names, from a place where all of it is in sight, however it stretches."""
    size = reach(model)
    eye = rrb.EyeControls3D(position=[1.3 * size, -1.1 * size, 0.95 * size], look_target=[0, 0, 0.2 * size])
    ground = rrb.SpatialInformation(target_frame=base_frame(model, name))
    return rrb.Spatial3DView(
        origin="/" if beside else entity(name),
        contents=[f"+ {entity(one)}/**" for one in (name, *beside)],
        name=title,
        spatial_information=ground,
        eye_controls=eye,
    )


def reach(model: Model) -> float:
    """How far the arm reaches at most [m]; 1 where all axes meet."""
    lengths = [np.linalg.norm(place.translation) for place in model.robot.kinematics.jointPlacements]
    return float(np.sum(lengths)) or 1.0


def base_frame(model: Model, name: str = ARM) -> str:
    """Frame on which the arm stands."""
    return f"{name}/{_urdf_tree(model, name).root_link().name}"


def _urdf_tree(model: Model, name: str) -> rerun.urdf.UrdfTree:
    """The arm, its entities and frames apart from those of arms with other names."""
    with tempfile.TemporaryDirectory() as folder:  # Rerun reads URDF from files only
        path = Path(folder) / "arm.urdf"
        path.write_text(urdf_text(model), encoding="utf-8")
        fixed = entity(name, "fixed")
        return rerun.urdf.UrdfTree.from_file_path(
            path, name, frame_prefix=f"{name}/", static_transform_entity_path=fixed
        )
