"""The gap between a MuJoCo simulation and the real arm: its size, and how much of it each finding closes."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..diagnosis.words.naming import joined
from ..document.document import (
    Block,
    Cell,
    Document,
    Figure,
    Grid,
    Marked,
    Number,
    Paragraph,
    Section,
    Statements,
    Table,
)
from ..in_mujoco.distances import ON_AXIS, Distances, Gain
from ..in_mujoco.gap import Gap
from ..in_mujoco.replay import POSITION
from ..text_table import digits
from .diagnosis_plots import KEYS
from .gap_numbers import UNDETERMINED, changed_numbers, drive_gains, servos
from .svg import Panel, Span

AS_IT_WAS = "original file"
LONGEST = 20.0
"""Longest part of a run that is drawn, so that the plot can be read by eye [s]."""
MILLI = {"rad": "mrad", "m": "mm"}


class Written(NamedTuple):
    """Paths of the files that were written; empty if a file was not."""

    file: str = ""  # the best file by itself
    attached: str = ""  # the file whose effects are attached
    effects: str = ""  # robot file with these effects


NOTHING = Written()
"""No file was written."""


def gap_document(gap: Gap, written: Written = NOTHING) -> Document:
    """The document; `written` names the files of both answers."""
    robot = gap.diagnosis.evidence.model.robot if gap.diagnosis.evidence else None
    units = [MILLI[unit] for unit in robot.units("rad")] if robot else ["mrad"] * len(gap.diagnosis.joints)
    positions = "positions, through the servos of the file" + ", held from sample to sample" * gap.held
    facts = [
        ("Commanded", positions if gap.commands == POSITION else "the measured torque"),
        ("Validation runs", ", ".join(run.name for run in gap.runs)),
        ("Starts", f"{len(gap.original.ends)} instants at which the simulation is set to the recorded state"),
    ]
    plots = [
        Figure(name, gap.runs[0].name, _trace_plot(gap, joint, units[joint]))
        for joint, name in enumerate(gap.diagnosis.joints)
        if robot
    ]
    said, answers = Statements(verdict(gap, written), "verdict"), _answers(gap)
    sections = [
        Section("verdict", "Verdict", [said]),
        Section("answers", "Distance between simulation and real arm", [answers, Paragraph(OPTIMISTIC)]),
        Section("gains", "Drive gains", drive_gains(gap)),
        Section("servos", "Servos", servos(gap)),
        Section("numbers", "Changed numbers of the file", changed_numbers(gap)),
        Section("stages", "Gain by stage", [_stages(gap), *_reasons(gap)]),
        Section("joints", "Joint errors, root mean square", [_joints(gap, units)]),
        Section("runs", "Whole runs", [Grid(plots)] if plots else [], detail=True),
        Section("beside", "Findings outside the file", [Statements(_beside(gap))] if _beside(gap) else []),
    ]
    title = f"{gap.diagnosis.name}: simulation versus real arm"
    return Document(title, "", sections, facts, [said, answers])


class Compared(NamedTuple):
    """The quantity that summarizes the gap: the tool point or one joint."""

    name: str  # name within a sentence
    short: str  # name in the header of a table
    unit: str  # "mm" or "mrad"
    joint: int | None  # index of the joint, from 0; None for the tool point

    @classmethod
    def of(cls, gap: Gap) -> "Compared":
        """The tool point; if it lies on all joint axes, the joint with the largest error."""
        if np.any(gap.original.tools > ON_AXIS):
            return cls("the tool point", "tool", "mm", None)
        joint = int(np.argmax(gap.original.joints[-1]))
        name = gap.diagnosis.joints[joint]
        return cls(f"joint {name}", name, "mrad", joint)

    def values(self, distances: Distances) -> list[float]:
        """Distance after each horizon, and over whole runs."""
        if self.joint is None:
            return [*distances.tool, distances.whole_tool]
        return [*distances.joints[:, self.joint], distances.whole_run[self.joint]]

    def far(self, distances: Distances) -> str:
        """Distance after the longest horizon, in words."""
        value = self.values(distances)[-2]
        return f"{digits(1e3 * value, 3)} {self.unit}" if np.isfinite(value) else "an unbounded amount"


def verdict(gap: Gap, written: Written = NOTHING) -> list[str]:
    """Sentences on the gap: with the original file, with the file by itself, and with attached effects."""
    compared = Compared.of(gap)
    longest = f"After {gap.horizons[-1]:g} s, {compared.name} of the simulation"
    original = f"{longest} deviates by {compared.far(gap.original)} from the real arm with the original file"
    uncertain = ", ".join(gap.diagnosis.joints[joint] for joint in gap.undetermined)
    doubts = [UNDETERMINED.format(uncertain)] if uncertain else []
    if not gap.changed:
        return [original, _why_nothing(gap, compared), *doubts]
    statements = [f"{original}, by {compared.far(gap.file.distances)} with the improved file by itself"]
    if gap.attached.attaches:
        statements.append(
            f"With the findings attached, it deviates by {compared.far(gap.attached.distances)}"
        )
    effects = {"Reduce the gap": Gain.BETTER, "Included, without a difference in these runs": Gain.SAME}
    for words, gain in effects.items():
        names = [stage.name for stage in gap.stages if stage.gain is gain and not stage.reason]
        statements += [f"{words}: {joined(names)}"] if names else []
    statements += doubts
    statements += [f"{name} keeps an error of {error}, {ratio:.0f} times the others, which nothing explains"
                   for name, error, ratio in _unexplained(gap)]  # fmt: skip
    if written.file:
        statements.append(f"Written: {written.file}, for any simulator that reads MJCF")
    if written.attached:
        statements.append(f"Written: {written.attached}, for exidyn.mujoco.attach with {written.effects}")
    return statements


def _why_nothing(gap: Gap, compared: Compared) -> str:
    """Why no file was written."""
    nearer = [stage.name for stage in gap.stages if stage.gain is Gain.BETTER and not stage.reason]
    if not nearer:
        return "Nothing that was identified brings it nearer, so no file was written"
    return (
        f"With the identified {joined(nearer)}, it deviates by {compared.far(gap.file.distances)}. No number "
        "of the file brings it nearer, so no file was written"
    )


OPTIMISTIC = (
    "The validation runs also chose between versions of the file, so these errors are slightly optimistic. "
    "On very different motions, compare again before you rely on them."
)
UNEXPLAINED = 10.0
"""Ratio of a joint's remaining error to the median of the others above which it is pointed out."""


def _unexplained(gap: Gap) -> list[tuple[str, str, float]]:
    """Joints that keep much larger errors than the others: name, error, ratio."""
    errors = gap.attached.distances.joints[-1]
    if len(errors) < 3 or not np.all(np.isfinite(errors)):
        return []
    others = [float(np.median(np.delete(errors, joint))) for joint in range(len(errors))]
    return [
        (name, f"{digits(1e3 * float(error), 3)} mrad", float(error / other))
        for name, error, other in zip(gap.diagnosis.joints, errors, others, strict=True)
        if error > UNEXPLAINED * other > 0.0
    ]


def _answers(gap: Gap) -> Table:
    """Distances with the original file, the file by itself, and with attached effects if there are any."""
    compared = Compared.of(gap)
    answers = [(AS_IT_WAS, gap.original), ("improved file by itself", gap.file.distances)]
    if gap.attached.attaches:
        answers += [("with findings attached", gap.attached.distances)]
    rows: list[list[Cell]] = [[name, *_distances(compared, distances)] for name, distances in answers]
    return Table(["simulation", *_head(gap, compared)], rows)


def _head(gap: Gap, compared: Compared) -> list[str]:
    """Headers of the distances after each horizon and over whole runs."""
    times = [f"{compared.short} {horizon:g} s [{compared.unit}]" for horizon in gap.horizons]
    return [*times, f"whole run [{compared.unit}]"]


def _distances(compared: Compared, distances: Distances) -> list[Cell]:
    return [Number(1e3 * float(value), 3) for value in compared.values(distances)]


def _stages(gap: Gap) -> Table:
    """One row per stage: distances with it and all kept before it, and whether it is kept."""
    compared, unchanged = Compared.of(gap), "yes, no gain"
    head = ["added", *_head(gap, compared), "kept"]
    rows: list[list[Cell]] = [[AS_IT_WAS, *_distances(compared, gap.original), ""]]
    for stage in gap.stages:
        gained = Marked("yes", "good") if stage.gain is Gain.BETTER else unchanged
        unknown: list[Cell] = [Number(np.nan)] * (len(head) - 2)
        numbers = _distances(compared, stage.distances) if stage.distances else unknown
        rows.append([stage.name, *numbers, "no" if stage.reason else gained])
    return Table(head, rows, words=(len(head) - 1,))


def _reasons(gap: Gap) -> list[Block]:
    """Why stages are not kept: a sentence for each reason, as their words are too long for the table."""
    reasons = dict.fromkeys(stage.reason for stage in gap.stages if stage.reason)
    names = {reason: [stage.name for stage in gap.stages if stage.reason == reason] for reason in reasons}
    return [Statements([f"No to {joined(names[reason])}: {reason}" for reason in reasons])] if names else []


def _joints(gap: Gap, units: Sequence[str]) -> Table:
    """Error of each joint with the original file and with the findings attached."""
    head = ["joint", "unit"]
    for title in (*(f"{horizon:g} s" for horizon in gap.horizons), "whole run"):
        head += [f"{title} before", "after"]
    rows: list[list[Cell]] = []
    errors = [
        np.vstack([distances.joints, distances.whole_run])
        for distances in (gap.original, gap.attached.distances)
    ]
    for joint, name in enumerate(gap.diagnosis.joints):
        cells: list[Cell] = [name, units[joint]]
        for before, after in zip(errors[0][:, joint], errors[1][:, joint], strict=True):
            cells += [Number(1e3 * float(before), 3), Number(1e3 * float(after), 3)]
        rows.append(cells)
    return Table(head, rows, words=(1,))


def _trace_plot(gap: Gap, joint: int, unit: str) -> str:
    """Simulated minus recorded position of a joint in the first held-out run, before and after."""
    run = gap.runs[0]
    shown = slice(0, int(np.searchsorted(run.time, run.time[0] + LONGEST)))
    time, real = run.time[shown], run.position[shown, joint]
    simulated = [distances.traces[0][shown, joint] for distances in (gap.original, gap.attached.distances)]
    errors = [1e3 * (trace - real) for trace in simulated]
    # A diverging line is cut off, but none within the motion, nor the nearer of the two.
    nearer = min(float(np.max(np.abs(each))) for each in errors)
    reach = max(1e3 * float(np.ptp(real)), 2.0 * nearer if np.isfinite(nearer) else 0.0) or 1e3
    lines = [np.clip(each, -reach, reach) for each in errors]
    panel = Panel.single(Span.around(time, margin=0.0), Span.around(*lines))
    title = f"{run.name}, {gap.diagnosis.joints[joint]}: simulated minus recorded"
    drawn = [panel.line(time, line, f"{style} thin") for line, (style, _) in zip(lines, KEYS, strict=True)]
    return panel.plot(title, ("time [s]", f"simulated minus recorded [{unit}]"), KEYS, *drawn)


def _beside(gap: Gap) -> list[str]:
    """Findings that are not part of the file, each with the reason."""
    statements = [f"{name}: removed from the recordings" for name in gap.taken_out]
    statements += [f"{name}: neither MJCF nor exidyn.mujoco can represent it" for name in gap.beyond]
    approximated = gap.attached.left_out
    return statements + [f"not in the file in its exact form: {words}" for words in approximated]
