"""The gap between a MuJoCo simulation and the real arm: how wide, and what each finding closes of it."""

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

AS_IT_WAS = "the file as it was"
LONGEST = 20.0
"""Seconds of a whole run that are drawn, so that they can be read by eye."""
MILLI = {"rad": "mrad", "m": "mm"}


def gap_document(gap: Gap, written: str = "") -> Document:
    """The whole document; `written` is the file with what was found, empty if there is none."""
    robot = gap.diagnosis.evidence.model.robot if gap.diagnosis.evidence else None
    units = [MILLI[one] for one in robot.units("rad")] if robot else ["mrad"] * len(gap.diagnosis.joints)
    facts = [
        (
            "Commanded",
            "positions, by the file's servos" if gap.commands == POSITION else "torque as measured",
        ),
        ("Judged by", ", ".join(run.name for run in gap.runs)),
        ("Starts", f"{len(gap.before.ends)} from which both begin alike"),
    ]
    sections = [
        Section("verdict", "Verdict", [Statements(verdict(gap, written), "verdict")]),
        Section("stages", "What each finding gains", [_stages(gap)]),
        Section("joints", "Joints and tool point, root mean square", [_joints(gap, units)]),
        Section("runs", "Whole runs", [Grid(_plots(gap, robot))] if robot else [], detail=True),
        Section("beside", "Beside the arm", [Statements(_beside(gap))] if _beside(gap) else []),
    ]
    title = f"{gap.diagnosis.name}: simulation and real arm"
    return Document(title, "", sections, facts=facts)


def gap_text(gap: Gap, written: str = "") -> str:
    """The document as text of 80 columns."""
    return text(gap_document(gap, written))


def gap_html(gap: Gap, written: str = "") -> str:
    """The document as one HTML page."""
    return html(gap_document(gap, written))


class Compared(NamedTuple):
    """What of the arm is compared in one number.

    Attributes:
        name: In a sentence.
        short: In the head of a table.
        unit: "mm" or "mrad".
        joint: The joint; None for the tool point.
    """

    name: str
    short: str
    unit: str
    joint: int | None

    @classmethod
    def of(cls, gap: Gap) -> "Compared":
        """The tool point; where that lies on the axis of all joints, the joint that is farthest off."""
        if np.any(gap.before.tools > ON_AXIS):
            return cls("the tool point", "tool", "mm", None)
        joint = int(np.argmax(gap.before.joints[-1]))
        name = gap.diagnosis.joints[joint]
        return cls(f"joint {name}", name, "mrad", joint)

    def values(self, found: Distances) -> list[float]:
        """After each horizon, and of whole runs."""
        if self.joint is None:
            return [*found.tool, found.whole_tool]
        return [*found.joints[:, self.joint], found.whole[self.joint]]

    def far(self, found: Distances) -> str:
        """After the longest horizon, in words."""
        value = self.values(found)[-2]
        return f"{digits(1e3 * value, 3)} {self.unit}" if np.isfinite(value) else "without bound"


ON_AXIS = 1e-9
"""Distance of tool points that is none [m]: rounding."""


def verdict(gap: Gap, written: str = "") -> list[str]:
    """What was gained, in sentences."""
    compared = Compared.of(gap)
    longest = f"After {gap.horizons[-1]:g} s {compared.name} of the simulation"
    before, after = compared.far(gap.before), compared.far(gap.after)
    if gap.kept is None and all(stage.distances is None for stage in gap.stages):
        why = "; ".join(dict.fromkeys(stage.reason for stage in gap.stages))
        return [f"{longest} is {before} from the real one. Nothing was written: {why}"]
    if gap.kept is None:
        return [
            f"{longest} is {before} from the real one. Nothing was written: all that was found makes a joint "
            "worse"
        ]
    first = f"{longest} was {before} from the real one, now {after}"
    kept = [stage for stage in gap.stages[1:] if not stage.reason]
    said = [first] if kept else [first, "Numbers of the file alone are others"]
    for words, gains in (("Found and kept", True), ("Found, and of no difference in these runs", False)):
        names = [stage.name for stage in kept if bool(stage.nearer) == gains]
        said += [f"{words}: {joined(names)}"] if names else []
    if written:
        attached = "; from exidyn.mujoco import attach adds what MJCF cannot hold" if gap.kept.left else ""
        said.append(f"Written: {written}{attached}")
    return said


def _stages(gap: Gap) -> Table:
    """What is compared by each arm, and whether it is kept."""
    compared = Compared.of(gap)
    times = [f"{compared.short} {one:g} s [{compared.unit}]" for one in gap.horizons]
    head = ["added", *times, f"whole run [{compared.unit}]", "written"]

    def numbers(found: Distances) -> list[Cell]:
        return [Number(1e3 * float(value), 3) for value in compared.values(found)]

    rows: list[list[Cell]] = [[AS_IT_WAS, *numbers(gap.before), ""]]
    for stage in gap.stages:
        tried = f"no: {stage.reason}" if stage.distances else "no: could not be made"
        gained = Marked("yes", "good") if stage.nearer else "yes, makes no difference here"
        written = gained if not stage.reason else tried
        none: list[Cell] = [Number(np.nan)] * (len(gap.horizons) + 1)
        rows.append([stage.name, *(numbers(stage.distances) if stage.distances else none), written])
    return Table(head, rows, words=(len(head) - 1,))


def _joints(gap: Gap, units: Sequence[str]) -> Table:
    """Each joint by the file as it was and with what is kept."""
    head = ["joint", "unit"]
    for one in (*(f"{horizon:g} s" for horizon in gap.horizons), "whole run"):
        head += [f"{one} before", "after"]
    rows: list[list[Cell]] = []
    every = [np.vstack([found.joints, found.whole]) for found in (gap.before, gap.after)]
    for joint, name in enumerate(gap.diagnosis.joints):
        cells: list[Cell] = [name, units[joint]]
        for before, after in zip(every[0][:, joint], every[1][:, joint], strict=True):
            cells += [Number(1e3 * float(before), 3), Number(1e3 * float(after), 3)]
        rows.append(cells)
    return Table(head, rows, words=(1,))


def _plots(gap: Gap, robot: Robot) -> list[Figure]:
    names, units = gap.diagnosis.joints, [MILLI[one] for one in robot.units("rad")]
    last, (before, after) = (
        f"after {gap.horizons[-1]:g} s",
        (one.joints[-1] for one in (gap.before, gap.after)),
    )
    picture_ = bars(1e3 * before, 1e3 * after, names, f"missed {last}", units)
    found = [Figure(f"Missed {last}", "root mean square over all starts", picture_)]
    return found + [
        Figure(name, gap.runs[0].name, _trace_plot(gap, joint, units[joint]))
        for joint, name in enumerate(names)
    ]


def _trace_plot(gap: Gap, joint: int, unit: str) -> str:
    """One joint of the first run held out: simulated less recorded, before and after."""
    run = gap.runs[0]
    shown = slice(0, int(np.searchsorted(run.time, run.time[0] + LONGEST)))
    time, real = run.time[shown], run.position[shown, joint]
    reach = 1e3 * float(np.ptp(real)) or 1e3  # what diverges leaves the picture
    lines = [
        np.clip(1e3 * (found.traces[0][shown, joint] - real), -reach, reach)
        for found in (gap.before, gap.after)
    ]
    panel = Panel(Span.around(time, margin=0.0), Span.around(*lines), 64, 24, 400, 190)
    content = legend(64, 14, [(style, style) for style in ("before", "after")])
    content += panel.axes("time [s]", f"simulated less recorded [{unit}]")
    for line, style in zip(lines, ("before thin", "after thin"), strict=True):
        content += panel.line(time, line, style)
    return picture(472, 246, f"{run.name}, {gap.diagnosis.joints[joint]}: simulated less recorded", content)


def _beside(gap: Gap) -> list[str]:
    """What was found and is no part of the file."""
    said = [f"{one}: taken out of the recordings" for one in gap.taken_out]
    said += [f"{one}: neither MJCF's numbers nor exidyn.mujoco hold it" for one in gap.beyond]
    left = gap.kept.left if gap.kept else ()
    return said + [f"not in the file as it was found: {one}" for one in left]
