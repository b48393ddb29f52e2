"""The runs: a table, and the motion of each joint in each run."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..document.document import Figure, Grid, Number, Paragraph, Row, Section, Statements, Table
from ..model import Model
from ..recordings.recording import SIGNALS
from ..text_table import digits
from .svg import Panel, Span, label, picture, text, ticks

LEFT, WIDTH, GAP = 112.0, 320.0, 62.0
"""Least left margin, width of a strip, and gap between the two columns [pixels]."""
LETTER, SCALE = 6.5, 46.0
"""Width of a letter of a joint name, and of the labels of a scale [pixels]."""
HEIGHT, STEP, TOP = 34.0, 38.0, 20.0
"""Height of a strip, vertical spacing of strips, and top margin [pixels]."""
COLUMNS = 160
"""Number of stretches of a line whose extremes are drawn: a strip shows shapes, not samples."""


class Run(NamedTuple):
    """The parts of a recorded run that a report shows."""

    name: str  # name of the run
    role: str  # purpose of the run, in words; empty if unknown
    payload: str  # payload on the flange, in words; empty if unknown
    rate: float  # sampling rate [Hz]
    time: np.ndarray  # time of the positions, shape (t,) [s]
    position: np.ndarray  # joint positions, shape (t, n) [rad]
    effort_time: np.ndarray  # time of the currents or torques, shape (s,) [s]
    effort: np.ndarray  # motor currents or joint torques, shape (s, n) [A] or [N m]
    quantity: str  # "current" or "torque"
    warnings: tuple[str, ...] = ()  # warnings about the recording, in sentences


def runs_sections(runs: Sequence[Run], joints: Sequence[str], model: Model | None) -> list[Section]:
    """Table and plots of the runs of a robot; empty without runs."""
    if not runs:
        return []
    note = (
        "Position and current (or torque) of every joint over time. Each plot has its own scale, with the "
        "smallest and largest value on its left."
    )
    figures = [Figure(run.name, run.role, _strips(run, joints, model)) for run in runs]
    warnings = [f"{run.name}: {warning}" for run in runs for warning in run.warnings]
    return [
        Section("table", "Recorded runs", [_table(runs), Statements(warnings)]),
        Section("motion", "Motion of the arm", [Paragraph(note, "plot"), Grid(figures)]),
    ]


def _table(runs: Sequence[Run]) -> Table:
    head = ["run", "role", "duration [s]", "rate [Hz]", "effort signal", "payload"]
    rows: list[Row] = [
        [
            run.name,
            run.role or "-",
            Number(np.ptp(run.time), 4),
            Number(run.rate, 3),
            run.quantity,
            run.payload or "-",
        ]
        for run in runs
    ]
    return Table(head, rows, words=(1, 4, 5))


def _strips(run: Run, joints: Sequence[str], model: Model | None) -> str:
    """Plots of a run in two columns, with one row per joint."""
    across = Span.around(run.time, margin=0.0)
    margin = max(LEFT, LETTER * max(map(len, joints)) + SCALE)
    parts = []
    for column, (name, time, values) in enumerate(
        (("position", run.time, run.position), (run.quantity, run.effort_time, run.effort))
    ):
        x0 = margin + column * (WIDTH + GAP)
        units = model.robot.units(SIGNALS[name]) if model else (SIGNALS[name],)
        parts.append(text(x0, 13, f"{name} [{', '.join(dict.fromkeys(units))}]", "axis"))
        for joint, words in enumerate(joints):
            panel = Panel(across, Span.around(values[:, joint]), x0, TOP + STEP * joint, WIDTH, HEIGHT)
            parts.append(_strip(panel, time, values[:, joint]))
            if column == 0:
                parts.append(text(4, panel.top + HEIGHT / 2 + 4, words, "name"))
        bottom = TOP + STEP * len(joints)
        for value in ticks(across, 5):
            place = x0 + WIDTH * (value - across.low) / across.size
            parts.append(text(place, bottom + 10, label(value, across), "tick middle"))
        parts.append(text(x0 + WIDTH, bottom + 23, "time [s]", "axis end"))
    size = margin + 2 * WIDTH + GAP + 10
    return picture(size, bottom + 28, f"{run.name}: motion of each joint", "".join(parts))


def _strip(panel: Panel, time: np.ndarray, values: np.ndarray) -> str:
    """A line in a frame, with the ends of its scale on the left."""
    known = np.isfinite(values)
    if not np.any(known):
        return panel.frame + text(panel.left + 6, panel.top + panel.height / 2 + 4, "not measured", "tick")
    ends = (float(np.min(values[known])), panel.height - 1), (float(np.max(values[known])), 10)
    scale = "".join(text(panel.left - 4, panel.top + y, digits(value, 3), "tick end") for value, y in ends)
    return panel.frame + scale + panel.line(time[known], values[known], "after thin", COLUMNS)
