"""View of a gap: the recorded arm and its MuJoCo simulations with the nominal model and with findings."""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from exidyn.identification.in_mujoco.gap import Gap
from exidyn.identification.in_mujoco.replay import Run
from exidyn.identification.model import Model

from .parts import FRAMES, GRAY, Arm, arm_view, base_frame, entity, log_lines, plot, screen
from .viewers import View

RECORDED, BEFORE, AFTER = "recorded", "nominal model", "with findings"
COLORS = {RECORDED: GRAY, BEFORE: (230, 159, 0), AFTER: (86, 180, 233)}
"""Colors of each arm and its lines: thin lines are readable on any background and by color-blind people."""


def gap_view(gap: Gap, model: Model) -> View:
    """A view of a gap, with one tab per held-out run."""

    def log(stream: rr.RecordingStream) -> None:
        for number, run in enumerate(gap.runs):
            _log_run(stream, gap, number, run, model)

    tabs = [_tab(run, gap, model) for run in gap.runs]
    return View("gap", log, screen(rrb.Tabs(*tabs, active_tab=0) if len(tabs) > 1 else tabs[0]))


def _tab(run: Run, gap: Gap, model: Model) -> rrb.Container:
    """One plot per joint on the left, the arms on the right."""
    names = gap.diagnosis.joints
    units = ("mrad" if revolute else "mm" for revolute in model.robot.revolute)
    plots = [
        plot(entity(run.name, name), f"{name}: simulated minus recorded [{unit}]", legend=not place)
        for place, (name, unit) in enumerate(zip(names, units, strict=True))
    ]
    title = "recorded gray, nominal model orange, with findings blue"
    arms = arm_view(model, _arm(run, RECORDED), [_arm(run, BEFORE), _arm(run, AFTER)], title)
    return rrb.Horizontal(rrb.Grid(*plots, grid_columns=2), arms, column_shares=[5, 4], name=run.name)


def _arm(run: Run, variant: str) -> str:
    """Name of an arm: a part of its entity path, and the prefix of its link frames."""
    return f"{variant} in {run.name}"


def _log_run(stream: rr.RecordingStream, gap: Gap, number: int, run: Run, model: Model) -> None:
    traces = {
        RECORDED: run.position,
        BEFORE: gap.original.traces[number],
        AFTER: gap.attached.distances.traces[number],
    }
    for variant, trace in traces.items():
        name, shown = _arm(run, variant), _frozen_if_diverged(trace)
        stride = max(1, round(len(run.time) / (FRAMES * (run.time[-1] - run.time[0]))))
        Arm(stream, model, name, COLORS[variant]).move(run.time[::stride], shown[::stride])
        if variant == RECORDED:
            continue
        # its base is at the base of the recorded arm
        parent, child = base_frame(model, _arm(run, RECORDED)), base_frame(model, name)
        pose = rr.Transform3D(translation=[0.0, 0.0, 0.0], parent_frame=parent, child_frame=child)
        stream.log(entity(name, "base"), pose, static=True)
        for joint, title in enumerate(gap.diagnosis.joints):
            difference = 1e3 * (shown[:, joint] - run.position[:, joint])
            path = entity(run.name, title, variant)
            log_lines(stream, path, [variant], [COLORS[variant]], run.time, difference)


def _frozen_if_diverged(trace: np.ndarray) -> np.ndarray:
    """A simulation (t, n), frozen at its last finite position if it diverges."""
    diverged = np.flatnonzero(~np.all(np.isfinite(trace), axis=1))
    return trace[np.minimum(np.arange(len(trace)), diverged[0] - 1)] if len(diverged) else trace
