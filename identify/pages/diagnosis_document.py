"""What is said of a diagnosis: verdict, where the misfit is, findings, what is left, candidates, runs."""

import numpy as np

from ..diagnosis.findings.finding import Diagnosis
from ..diagnosis.findings.quantities import SLIDING, TURNING
from ..diagnosis.improved.forward import Forward
from ..diagnosis.words.diagnosis_file import array_of, value_of
from ..diagnosis.words.diagnosis_schema import FindingRow, SimulatedTable
from ..diagnosis.words.naming import effect_words, named
from ..diagnosis.words.sentences import direction, span
from ..document.document import (
    Block,
    Cell,
    Document,
    Figure,
    Grid,
    Heading,
    Number,
    Paragraph,
    Section,
    Statements,
    Table,
)
from ..document.html import html
from ..document.text import text
from ..text_table import NORMAL_95, digits, fixed, percent
from .budget import budget_section
from .diagnosed import Diagnosed as Diagnosed
from .diagnosed import moments, name_of_finding
from .diagnosis_plots import (
    bars,
    forward_plot,
    where_and_when,
)
from .finding_plots import NOTE, every_joint, findings_blocks, unexplained_blocks
from .located import located_section

LEAST_CHANGE = 0.1
"""Per cent by which a candidate alone has to lower the squared error to be listed: the last digit printed."""
TOP = 10
"""Candidates that short pages list."""
CHECK = (
    'To check a row: add it to robot.toml ([[effect]], name = "...", joints = ["..."]), run "exidyn identify '
    'RUNS --robot robot.toml --validate OTHER" with it and without, and compare the squares of the residuals '
    "held out. What robot.toml cannot hold (a hose, a supply that sags) cannot be checked this way."
)
HELD_OUT = (
    "held-out score: the decrease of -2 log likelihood on the runs held out; a positive score confirms the "
    "effect."
)


def diagnosis_document(diagnosis: Diagnosed) -> Document:
    """The whole document."""
    file = diagnosis.file
    facts = [
        ("Fitted", ", ".join(file.runs)),
        ("Held out", ", ".join(file.held_out or ()) or "none"),
        ("Took", f"{file.seconds:.1f} s"),
    ]
    verdict = Section("verdict", "Verdict", [*verdict_blocks(diagnosis), *gained_blocks(diagnosis)])
    budget, *below = detail_sections(diagnosis)
    sections = [verdict, located_section(diagnosis), budget, *below, simulation_section(diagnosis)]
    return Document(f"{file.name}: what the model leaves out", "", sections, facts=facts)


def summary(diagnosis: Diagnosis, forward: Forward | None = None, folder: str = "") -> str:
    """The document as text of 80 columns; arguments as of `Diagnosed.of`."""
    return text(diagnosis_document(Diagnosed.of(diagnosis, forward, folder)))


def report_html(diagnosis: Diagnosis, forward: Forward | None = None, folder: str = "") -> str:
    """The document as one HTML page that needs nothing else; arguments as of `Diagnosed.of`."""
    return html(diagnosis_document(Diagnosed.of(diagnosis, forward, folder)))


def detail_sections(diagnosis: Diagnosed) -> list[Section]:
    """All sections below the verdict, the budget first."""
    note = "Each is there; these runs do not decide which. Plots are of the one that was fitted."
    file, first = diagnosis.file, len(diagnosis.file.findings)
    return [
        budget_section(file.budget, diagnosis.names),
        Section("findings", "Findings", findings_blocks(diagnosis, NOTE, file.findings, 0), True),
        Section("undecided", "Undecided", findings_blocks(diagnosis, note, file.undecided, first), True),
        Section("unexplained", "Unexplained", unexplained_blocks(diagnosis), True),
        Section("moments", "When a run differs as at no other time", _moments(diagnosis)),
        Section("candidates", "What each candidate alone would change", _changes(diagnosis)),
        Section("joints", "Every joint", every_joint(diagnosis), True),
        Section("data", "Runs and what limits them", _data(diagnosis), True),
    ]


def verdict_blocks(diagnosis: Diagnosed) -> list[Block]:
    """What is missing, in sentences and numbers."""
    return [Statements(diagnosis.file.verdict, "verdict"), *_findings_table(diagnosis)]


def gained_blocks(diagnosis: Diagnosed) -> list[Block]:
    """Residual held out before and after, by joint, and where and when it is; nothing without such runs."""
    if (residuals := diagnosis.residuals) is None:
        return []
    before, after = residuals
    runs = ", ".join(diagnosis.file.held_out or ())
    title = "Held-out residual over noise" if diagnosis.over_noise else "Held-out residual"
    picture = _bars(diagnosis, before, after, diagnosis.noise, "residual")
    remark = f"before: the model fitted within its tolerances, without findings; {runs}"
    return [
        Heading("Residual held out by joint, root mean square"),
        _joint_table(diagnosis, before, after),
        Grid([Figure(title, remark, picture), *_map(diagnosis)]),
    ]


def _joint_table(diagnosis: Diagnosed, before: np.ndarray, after: np.ndarray) -> Table:
    """Of one definition each: nominal values, fitted before findings, fitted with findings, simulated."""
    file, columns = diagnosis.file, dict[str, np.ndarray]()
    if diagnosis.over_noise:
        columns["noise"] = array_of(file.noise)
    if file.budget is not None and file.torque_rms_before is not None:
        columns["nominal values"] = array_of(file.torque_rms_before)
    columns |= {"before": before, "after": after}
    if diagnosis.over_noise:
        columns |= {"before/ noise": before / columns["noise"], "after/ noise": after / columns["noise"]}
    if file.simulated is not None:
        columns["simulated before"] = array_of(file.simulated.torque_rms_before)
        columns["simulated after"] = array_of(file.simulated.torque_rms_after)
    rows = zip(diagnosis.names, file.units, *columns.values(), strict=True)
    cells: list[list[Cell]] = [[name, unit, *map(Number, values)] for name, unit, *values in rows]
    return Table(["joint", "unit", *columns], cells, words=(1,))


def _bars(diagnosis: Diagnosed, before: np.ndarray, after: np.ndarray, noise: np.ndarray, label: str) -> str:
    """Bars over noise where that was measured, else in units."""
    if not diagnosis.over_noise or not len(noise):
        return bars(before, after, diagnosis.names, label, diagnosis.file.units)
    return bars(before / noise, after / noise, diagnosis.names, f"{label} over noise")


def _map(diagnosis: Diagnosed) -> list[Block]:
    """Where and when a run held out is not explained, by nominal values and with findings."""
    if not diagnosis.traces:
        return []
    trace = diagnosis.judged[0]
    level, what = diagnosis.noise, "noise"
    if not diagnosis.over_noise:
        squares = np.sum(trace.after**2 * trace.weight, axis=0) / np.maximum(trace.weight.sum(axis=0), 1.0)
        level, what = np.maximum(np.sqrt(squares), 1e-300), "the joint's root mean square after"
    remark = f"{trace.name}; white is {what}, full color is four times as much"
    return [
        Figure(f"Where and when: {title}", remark, where_and_when(trace, level, diagnosis.names, which))
        for which, title in (("before", "nominal values"), ("after", "with findings"))
    ]


def _findings_table(diagnosis: Diagnosed) -> list[Block]:
    """A row a parameter that is determined, undecided findings last; nothing without findings."""
    rows: list[list[Cell]] = []
    for finding in diagnosis.file.every:
        mark = "" if finding in diagnosis.file.findings else ", undecided"
        rows += [[f"{name_of_finding(diagnosis, finding)}{mark}"], [f"  {_sure(finding)}{_gain(finding)}"]]
        rows += _numbers(finding)
    if not rows:
        return []
    why = [
        f"{name_of_finding(diagnosis, finding)}: {words}"
        for finding in diagnosis.file.every
        for words in finding.left_out.values()
        if words
    ]
    table = Table(["parameter", "value", "± 95 %", "unit"], rows, words=(3,))
    return [table, *([Statements(why)] if why else []), Paragraph(HELD_OUT)]


def _numbers(finding: FindingRow) -> list[list[Cell]]:
    """Its parameters; where some are not determined, what is known of its torque beside the others."""
    rows: list[list[Cell]] = []
    for name, one in finding.parameters.items():
        value, half = value_of(one.value), NORMAL_95 * value_of(one.std)
        if name not in finding.left_out:
            rows.append([f"  {name}", Number(value), Number(half, 2), "" if one.unit == "1" else one.unit])
    if (size := finding.size) is not None and finding.left_out:
        rows.append([f"  {size.head}"])
        rows += [
            [f"    {one.words}", Number(one.torque), Number(NORMAL_95 * one.std, 2), size.unit]
            for one in size.rows
        ]
    return rows


def _sure(finding: FindingRow) -> str:
    return f"probability {percent(finding.probability, 3)}"


def _gain(finding: FindingRow) -> str:
    return "" if finding.held_out is None else f", held-out score {digits(finding.held_out, 3)}"


def _moments(diagnosis: Diagnosed) -> list[Block]:
    rows: list[list[Cell]] = [
        [
            one.run,
            span(one),
            ", ".join(str(joint + 1) for joint in one.joints),
            Number(one.force, 3),
            direction(one),
        ]
        for one in moments(diagnosis.file)
    ]
    if not rows:
        return []
    note = (
        "Windows in which a run, those held out included, differs from the model as at no other time, and "
        "the force on the flange that explains most of it, in the base's axes; one joint alone shows none."
    )
    head = ["run", "time", "joints", "force [N]", "direction"]
    return [Paragraph(note), Table(head, rows, words=(1, 2, 4))]


def _changes(diagnosis: Diagnosed) -> list[Block]:
    """All candidates that alone would lower the error; nothing without."""
    rows: list[list[Cell]] = [
        [
            one.name or named(one.effect, [j - 1 for j in one.joints], diagnosis.file.joints),
            diagnosis.names[one.joint - 1],
            fixed(value_of(one.squared_error_percent), 1),
            fixed(value_of(one.std_percent), 1),
        ]
        for one in diagnosis.file.changes
        if value_of(one.squared_error_percent) < -LEAST_CHANGE
    ]
    if not rows:
        return []
    data = "runs held out" if diagnosis.residuals else "fitted runs, each block predicted by the others"
    note = (
        f"Change of the squared prediction error of {data} when only this candidate is added, on the joint "
        f"that improves most (negative is better); std: standard deviation over time blocks. {CHECK}"
    )
    head = ["candidate, alone", "joint improved most", "squared error, %", "std, %"]
    return [Table(head, rows, words=(1,), first=TOP), Paragraph(note)]


def simulation_section(diagnosis: Diagnosed) -> Section:
    """The arm in simulation, before and after; empty where nothing was simulated."""
    found = diagnosis.file.simulated
    blocks = [] if found is None else _simulation(diagnosis, found)
    return Section("simulation", "Simulation", blocks)


def _simulation(diagnosis: Diagnosed, found: SimulatedTable) -> list[Block]:
    before, after = array_of(found.torque_rms_before), array_of(found.torque_rms_after)
    note = (
        f"{found.run}, simulated in closed loop: an arm with drives of its own follows the recorded "
        "motion, and the torque of its motors is compared with the recorded one."
    )
    over = diagnosis.over_noise and len(diagnosis.noise)
    remark = f"simulated less recorded torque, root mean square{' over noise' if over else ''}"
    drawn = _bars(diagnosis, before, after, diagnosis.noise, "simulated less recorded")
    figures = [Figure("All joints", remark, drawn)]
    if not np.all(np.isfinite([before, after])):
        note += " It diverged: where it did, there is no number."
    if (samples := diagnosis.forward) is not None:
        missed = 1e3 * float(np.max(samples.missed))
        if np.isfinite(missed):
            size = f"{digits(missed, 2)} {_small(diagnosis)}"
            note += f" Its motors miss the recorded positions by {size} at most, root mean square."
        gained = _gained(before, after, diagnosis.noise)
        plot = forward_plot(samples, gained, diagnosis.file.units[gained])
        figures.append(Figure(diagnosis.names[gained], found.run, plot))
    if found.left_out:
        note += f" Not simulated: {', '.join(effect_words(one) for one in found.left_out)}."
    return [Paragraph(note), Grid(figures)]


def _gained(before: np.ndarray, after: np.ndarray, noise: np.ndarray) -> int:
    """The joint that gains most; where a simulation diverged there is no gain."""
    with np.errstate(over="ignore", invalid="ignore"):
        gains = (before**2 - after**2) / (noise**2 if len(noise) else 1.0)
    return int(np.argmax(np.nan_to_num(gains, nan=-np.inf)))


def _small(diagnosis: Diagnosed) -> str:
    """Unit of a thousandth of a joint's way."""
    kinds = [name for name, unit in (("mrad", TURNING), ("mm", SLIDING)) if unit in diagnosis.file.units]
    return " or ".join(kinds)


def _data(diagnosis: Diagnosed) -> list[Block]:
    file = diagnosis.file
    runs = f"Fitted: {', '.join(file.runs)}; held out: {', '.join(file.held_out or ()) or 'none'}."
    return [
        Paragraph(runs),
        Statements(file.limits or ("Nothing about the recordings limits the result.",)),
    ]
