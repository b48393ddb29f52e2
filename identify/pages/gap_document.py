"""The gap between a MuJoCo simulation and the real arm: its size, and how much of it each finding closes."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..diagnosis.words.naming import joined
from ..document.document import (
    Cell,
    Document,
    Figure,
    Grid,
    Marked,
    Number,
    Section,
    Statements,
    Table,
)
from ..document.html import html
from ..document.text import text
from ..in_mujoco.distances import Distances
from ..in_mujoco.gap import Gap
from ..in_mujoco.replay import POSITION
from ..text_table import digits
from .diagnosis_plots import bars
from .svg import Panel, Span, legend, picture

AS_IT_WAS = "original file"
LONGEST = 20.0
"""Longest part of a run that is drawn, so that the plot can be read by eye [s]."""
MILLI = {"rad": "mrad", "m": "mm"}


def gap_document(gap: Gap, written: str = "") -> Document:
    """The document; `written` is the file with the findings, empty if none was written."""
    robot = gap.diagnosis.evidence.model.robot if gap.diagnosis.evidence else None
    units = [MILLI[unit] for unit in robot.units("rad")] if robot else ["mrad"] * len(gap.diagnosis.joints)
    facts = [
        (
            "Commanded",
            "positions, through the servos of the file"
            if gap.commands == POSITION
            else "the measured torque",
        ),
        ("Validation runs", ", ".join(run.name for run in gap.runs)),
        ("Starts", f"{len(gap.before.ends)} instants at which the simulation is set to the recorded state"),
    ]
    sections = [
        Section("verdict", "Verdict", [Statements(verdict(gap, written), "verdict")]),
        Section("stages", "Gain by finding", [_stages(gap)]),
        Section("joints", "Joint errors, root mean square", [_joints(gap, units)]),
        Section("runs", "Whole runs", [Grid(_plots(gap, robot))] if robot else [], detail=True),
        Section("beside", "Findings outside the file", [Statements(_beside(gap))] if _beside(gap) else []),
    ]
    title = f"{gap.diagnosis.name}: simulation versus real arm"
    return Document(title, "", sections, facts=facts)


def gap_text(gap: Gap, written: str = "") -> str:
    """The document as text with 80 columns."""
    return text(gap_document(gap, written))


def gap_html(gap: Gap, written: str = "") -> str:
    """The document as one HTML page."""
    return html(gap_document(gap, written))


class Compared(NamedTuple):
    """The quantity that summarizes the gap: the tool point or one joint.

    Attributes:
        name: Name within a sentence.
        short: Name in the header of a table.
        unit: "mm" or "mrad".
        joint: Index of the joint, from 0; None for the tool point.
    """

    name: str
    short: str
    unit: str
    joint: int | None

    @classmethod
    def of(cls, gap: Gap) -> "Compared":
        """The tool point; if it lies on all joint axes, the joint with the largest error."""
        if np.any(gap.before.tools > ON_AXIS):
            return cls("the tool point", "tool", "mm", None)
        joint = int(np.argmax(gap.before.joints[-1]))
        name = gap.diagnosis.joints[joint]
        return cls(f"joint {name}", name, "mrad", joint)

    def values(self, distances: Distances) -> list[float]:
        """Distance after each horizon, and over whole runs."""
        if self.joint is None:
            return [*distances.tool, distances.whole_tool]
        return [*distances.joints[:, self.joint], distances.whole[self.joint]]

    def far(self, distances: Distances) -> str:
        """Distance after the longest horizon, in words."""
        value = self.values(distances)[-2]
        return f"{digits(1e3 * value, 3)} {self.unit}" if np.isfinite(value) else "an unbounded amount"


ON_AXIS = 1e-9
"""Distance of tool points that is only rounding [m]."""


def verdict(gap: Gap, written: str = "") -> list[str]:
    """Sentences on how much the findings reduce the gap."""
    compared = Compared.of(gap)
    longest = f"After {gap.horizons[-1]:g} s, {compared.name} of the simulation"
    before, after = compared.far(gap.before), compared.far(gap.after)
    if gap.kept is None and all(stage.distances is None for stage in gap.stages):
        why = "; ".join(dict.fromkeys(stage.reason for stage in gap.stages))
        return [f"{longest} deviates by {before} from the real arm. No file was written: {why}"]
    if gap.kept is None:
        return [
            f"{longest} deviates by {before} from the real arm. No file was written: every finding makes a "
            "joint worse"
        ]
    first = f"{longest} deviated by {before} from the real arm; with the findings, by {after}"
    included = [stage for stage in gap.stages[1:] if not stage.reason]
    statements = [first] if included else [first, "Only numbers that the file already states have changed"]
    for words, gains in (("Reduce the gap", True), ("Included, without a difference in these runs", False)):
        names = [stage.name for stage in included if bool(stage.nearer) == gains]
        statements += [f"{words}: {joined(names)}"] if names else []
    if written:
        attached = "; from exidyn.mujoco import attach adds what MJCF cannot hold" if gap.kept.left else ""
        statements.append(f"Written: {written}{attached}")
    return statements


def _stages(gap: Gap) -> Table:
    """One row per added finding: distances with it, and whether it was written."""
    compared = Compared.of(gap)
    times = [f"{compared.short} {horizon:g} s [{compared.unit}]" for horizon in gap.horizons]
    head = ["added", *times, f"whole run [{compared.unit}]", "written"]

    def numbers(distances: Distances) -> list[Cell]:
        return [Number(1e3 * float(value), 3) for value in compared.values(distances)]

    rows: list[list[Cell]] = [[AS_IT_WAS, *numbers(gap.before), ""]]
    for stage in gap.stages:
        tried = f"no: {stage.reason}" if stage.distances else "no: cannot be modeled"
        gained = Marked("yes", "good") if stage.nearer else "yes, makes no difference here"
        written = gained if not stage.reason else tried
        none: list[Cell] = [Number(np.nan)] * (len(gap.horizons) + 1)
        rows.append([stage.name, *(numbers(stage.distances) if stage.distances else none), written])
    return Table(head, rows, words=(len(head) - 1,))


def _joints(gap: Gap, units: Sequence[str]) -> Table:
    """Error of each joint with the original file and with the written findings."""
    head = ["joint", "unit"]
    for title in (*(f"{horizon:g} s" for horizon in gap.horizons), "whole run"):
        head += [f"{title} before", "after"]
    rows: list[list[Cell]] = []
    errors = [np.vstack([distances.joints, distances.whole]) for distances in (gap.before, gap.after)]
    for joint, name in enumerate(gap.diagnosis.joints):
        cells: list[Cell] = [name, units[joint]]
        for before, after in zip(errors[0][:, joint], errors[1][:, joint], strict=True):
            cells += [Number(1e3 * float(before), 3), Number(1e3 * float(after), 3)]
        rows.append(cells)
    return Table(head, rows, words=(1,))


def _plots(gap: Gap, robot: Robot) -> list[Figure]:
    names, units = gap.diagnosis.joints, [MILLI[unit] for unit in robot.units("rad")]
    last, (before, after) = (
        f"after {gap.horizons[-1]:g} s",
        (distances.joints[-1] for distances in (gap.before, gap.after)),
    )
    picture_ = bars(1e3 * before, 1e3 * after, names, f"joint error {last}", units)
    figures = [Figure(f"Joint error {last}", "root mean square over all starts", picture_)]
    return figures + [
        Figure(name, gap.runs[0].name, _trace_plot(gap, joint, units[joint]))
        for joint, name in enumerate(names)
    ]


def _trace_plot(gap: Gap, joint: int, unit: str) -> str:
    """Simulated minus recorded position of a joint in the first held-out run, before and after."""
    run = gap.runs[0]
    shown = slice(0, int(np.searchsorted(run.time, run.time[0] + LONGEST)))
    time, real = run.time[shown], run.position[shown, joint]
    reach = 1e3 * float(np.ptp(real)) or 1e3  # a diverging line is cut off
    lines = [
        np.clip(1e3 * (distances.traces[0][shown, joint] - real), -reach, reach)
        for distances in (gap.before, gap.after)
    ]
    panel = Panel(Span.around(time, margin=0.0), Span.around(*lines), 64, 24, 400, 190)
    content = legend(64, 14, [(style, style) for style in ("before", "after")])
    content += panel.axes("time [s]", f"simulated minus recorded [{unit}]")
    for line, style in zip(lines, ("before thin", "after thin"), strict=True):
        content += panel.line(time, line, style)
    return picture(472, 246, f"{run.name}, {gap.diagnosis.joints[joint]}: simulated minus recorded", content)


def _beside(gap: Gap) -> list[str]:
    """Findings that are not part of the file, each with the reason."""
    statements = [f"{name}: removed from the recordings" for name in gap.taken_out]
    statements += [f"{name}: neither MJCF nor exidyn.mujoco can represent it" for name in gap.beyond]
    approximated = gap.kept.left if gap.kept else ()
    return statements + [f"not in the file in its exact form: {words}" for words in approximated]
