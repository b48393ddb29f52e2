"""View of a gap: the arm as it was recorded and as MuJoCo simulates it, before and after, in one place."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identification.in_mujoco.gap import Gap
from exidyn.identification.in_mujoco.replay import Run
from exidyn.identification.model import Model

from .parts import (
    FRAMES,
    GREY,
    Arm,
    arm_view,
    base_frame,
    entity,
    log_lines,
    plot,
    screen,
)
from .viewers import View

RECORDED, BEFORE, AFTER = "recorded", "as the file was", "with what was found"
COLOURS = {RECORDED: GREY, BEFORE: (230, 159, 0), AFTER: (86, 180, 233)}
"""Of each arm and its lines, as thin lines on dark ground and on light, for colour-blind readers too."""


def gap_view(found: Gap, model: Model) -> View:
    """A view of the runs that were held out, a tab each."""

    def log(stream: rr.RecordingStream) -> None:
        for number, run in enumerate(found.runs):
            _log_run(stream, found, number, run, model)

    tabs = [_tab(run, found, model) for run in found.runs]
    return View("gap", log, screen(rrb.Tabs(*tabs, active_tab=0) if len(tabs) > 1 else tabs[0]))


def _tab(run: Run, found: Gap, model: Model) -> rrb.Container:
    """A plot of each joint on the left, the arms on the right."""
    names = found.diagnosis.joints
    units = ("mrad" if revolute else "mm" for revolute in model.robot.revolute)
    plots = [
        plot(entity(run.name, name), f"{name}: simulated less recorded [{unit}]", legend=not place)
        for place, (name, unit) in enumerate(zip(names, units, strict=True))
    ]
    title = "recorded grey, as the file was orange, with what was found blue"
    arms = arm_view(model, _arm(run, RECORDED), [_arm(run, BEFORE), _arm(run, AFTER)], title)
    return rrb.Horizontal(rrb.Grid(*plots, grid_columns=2), arms, column_shares=[5, 4], name=run.name)


def _arm(run: Run, which: str) -> str:
    """Name of an arm: one part of an entity path, and the prefix of its link frames."""
    return f"{which} in {run.name}"


def _log_run(stream: rr.RecordingStream, found: Gap, number: int, run: Run, model: Model) -> None:
    traces = {RECORDED: run.position, BEFORE: found.before.traces[number], AFTER: found.after.traces[number]}
    for which, trace in traces.items():
        name, shown = _arm(run, which), _until_it_diverges(trace)
        every = max(1, round(len(run.time) / (FRAMES * (run.time[-1] - run.time[0]))))
        Arm(stream, model, name, COLOURS[which]).move(run.time[::every], shown[::every])
        _stand_in_one_place(stream, model, name, _arm(run, RECORDED))
        if which == RECORDED:
            continue
        for joint, title in enumerate(found.diagnosis.joints):
            apart = 1e3 * (shown[:, joint] - run.position[:, joint])
            log_lines(stream, entity(run.name, title, which), [which], [COLOURS[which]], run.time, apart)


def _until_it_diverges(trace: np.ndarray) -> np.ndarray:
    """A simulation (t, n), which stays where it was once it has diverged."""
    lost = np.flatnonzero(~np.all(np.isfinite(trace), axis=1))
    return trace[np.minimum(np.arange(len(trace)), lost[0] - 1)] if len(lost) else trace


def _stand_in_one_place(stream: rr.RecordingStream, model: Model, name: str, first: str) -> None:
    """Put the base of an arm where that of the first one is."""
    if name == first:
        return
    place = rr.Transform3D(
        translation=[0.0, 0.0, 0.0],
        parent_frame=base_frame(model, first),
        child_frame=base_frame(model, name),
    )
    stream.log(entity(name, "base"), place, static=True)
