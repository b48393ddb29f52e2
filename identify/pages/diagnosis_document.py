"""What is said of a diagnosis: verdict, where the misfit is, findings, what is left, candidates, runs."""

import numpy as np

from ..diagnosis.findings.diagnosis import Diagnosis, Simulated
from ..diagnosis.findings.finding import Finding
from ..diagnosis.findings.quantities import SLIDING, TURNING
from ..diagnosis.improved.forward import Forward
from ..diagnosis.words.naming import change_names, effect_words
from ..diagnosis.words.sentences import direction, span
from ..diagnosis.words.size_words import left_out_words, rows_head, size_rows
from ..diagnosis.words.verdict import verdict
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
from .diagnosis_plots import (
    bars,
    forward_plot,
    where_and_when,
)
from .finding_plots import NOTE, every_joint, findings_blocks, unexplained_blocks
from .located import located_section
from .shown import Shown as Shown

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


def diagnosis_document(shown: Shown) -> Document:
    """The whole document."""
    diagnosis = shown.diagnosis
    facts = [
        ("Fitted", ", ".join(diagnosis.runs)),
        ("Held out", ", ".join(diagnosis.held_out) or "none"),
        ("Took", f"{diagnosis.seconds:.1f} s"),
    ]
    opening = Section("verdict", "Verdict", [*verdict_blocks(shown), *gained_blocks(shown)])
    budget, *below = detail_sections(shown)
    sections = [opening, located_section(shown), budget, *below, simulation_section(shown)]
    return Document(f"{diagnosis.name}: what the model leaves out", "", sections, facts=facts)


def summary(diagnosis: Diagnosis, forward: Forward | None = None, folder: str = "") -> str:
    """The document as text of 80 columns; arguments as of `Shown.of`."""
    return text(diagnosis_document(Shown.of(diagnosis, folder, forward)))


def report_html(diagnosis: Diagnosis, forward: Forward | None = None, folder: str = "") -> str:
    """The document as one HTML page that needs nothing else; arguments as of `Shown.of`."""
    return html(diagnosis_document(Shown.of(diagnosis, folder, forward)))


def detail_sections(shown: Shown) -> list[Section]:
    """All sections below the verdict, the budget first."""
    note = "Each is there; these runs do not decide which. Plots are of the one that was fitted."
    diagnosis, first = shown.diagnosis, len(shown.diagnosis.findings)
    return [
        budget_section(shown),
        Section("findings", "Findings", findings_blocks(shown, NOTE, diagnosis.findings, 0), True),
        Section("undecided", "Undecided", findings_blocks(shown, note, diagnosis.undecided, first), True),
        Section("unexplained", "Unexplained", unexplained_blocks(shown), True),
        Section("moments", "When a run differs as at no other time", _moments(shown)),
        Section("candidates", "What each candidate alone would change", _changes(shown)),
        Section("joints", "Every joint", every_joint(shown), True),
        Section("data", "Runs and what limits them", _data(shown), True),
    ]


def verdict_blocks(shown: Shown) -> list[Block]:
    """What is missing, in sentences and numbers."""
    return [Statements(verdict(shown.diagnosis, shown.folder), "verdict"), *_findings_table(shown)]


def gained_blocks(shown: Shown) -> list[Block]:
    """Residual held out before and after, by joint, and where and when it is; nothing without such runs."""
    if (residuals := shown.residuals) is None:
        return []
    before, after = residuals
    runs = ", ".join(shown.diagnosis.held_out)
    title = "Held-out residual over noise" if shown.over_noise else "Held-out residual"
    picture = _bars(shown, before, after, shown.noise, "residual")
    remark = f"before: the model fitted within its tolerances, without findings; {runs}"
    return [
        Heading("Residual held out by joint, root mean square"),
        _joint_table(shown, before, after),
        Grid([Figure(title, remark, picture), *_map(shown)]),
    ]


def _joint_table(shown: Shown, before: np.ndarray, after: np.ndarray) -> Table:
    """Of one definition each: nominal values, fitted before findings, fitted with findings, simulated."""
    diagnosis, columns = shown.diagnosis, dict[str, np.ndarray]()
    if shown.over_noise:
        columns["noise"] = diagnosis.noise
    if diagnosis.budget is not None and diagnosis.torque_rms_before is not None:
        columns["nominal values"] = diagnosis.torque_rms_before
    columns |= {"before": before, "after": after}
    if shown.over_noise:
        columns |= {"before/ noise": before / columns["noise"], "after/ noise": after / columns["noise"]}
    if diagnosis.simulated is not None:
        columns["simulated before"] = diagnosis.simulated.torque_rms_before
        columns["simulated after"] = diagnosis.simulated.torque_rms_after
    rows = zip(shown.names, diagnosis.torque_units, *columns.values(), strict=True)
    cells: list[list[Cell]] = [[name, unit, *map(Number, values)] for name, unit, *values in rows]
    return Table(["joint", "unit", *columns], cells, words=(1,))


def _bars(shown: Shown, before: np.ndarray, after: np.ndarray, noise: np.ndarray, label: str) -> str:
    """Bars over noise where that was measured, else in units."""
    if not shown.over_noise:
        return bars(before, after, shown.names, label, shown.diagnosis.torque_units)
    return bars(before / noise, after / noise, shown.names, f"{label} over noise")


def _map(shown: Shown) -> list[Block]:
    """Where and when a run held out is not explained, by nominal values and with findings."""
    if not shown.traces:
        return []
    trace = shown.judged[0]
    level, what = shown.noise, "noise"
    if not shown.over_noise:
        squares = np.sum(trace.after**2 * trace.weight, axis=0) / np.maximum(trace.weight.sum(axis=0), 1.0)
        level, what = np.maximum(np.sqrt(squares), 1e-300), "the joint's root mean square after"
    remark = f"{trace.name}; white is {what}, full color is four times as much"
    return [
        Figure(f"Where and when: {title}", remark, where_and_when(trace, level, shown.names, which))
        for which, title in (("before", "nominal values"), ("after", "with findings"))
    ]


def _findings_table(shown: Shown) -> list[Block]:
    """A row a parameter that is determined, undecided findings last; nothing without findings."""
    rows: list[list[Cell]] = []
    reasons: list[str] = []
    findings = shown.diagnosis.findings
    for name, finding in zip(shown.finding_names, shown.diagnosis.all_findings, strict=True):
        mark = "" if finding in findings else ", undecided"
        rows += [[f"{name}{mark}"], [f"  {_sure(finding)}{_gain(finding)}"], *_numbers(shown, finding)]
        reasons += [f"{name}: {words}" for words in left_out_words(finding.left_out).values() if words]
    if not rows:
        return []
    table = Table(["parameter", "value", "± 95 %", "unit"], rows, words=(3,))
    return [table, *([Statements(reasons)] if reasons else []), Paragraph(HELD_OUT)]


def _numbers(shown: Shown, finding: Finding) -> list[list[Cell]]:
    """Its determined parameters, and its torque where some are not determined."""
    rows: list[list[Cell]] = [
        [f"  {name}", Number(q.value), Number(NORMAL_95 * q.std, 2), "" if q.unit == "1" else q.unit]
        for name, q in finding.determined.items()
    ]
    if (size := finding.size) is not None and finding.left_out:
        unit = shown.diagnosis.torque_units[size.joint]
        rows.append([f"  {rows_head(size, shown.diagnosis)}"])
        rows += [
            [f"    {words}", Number(torque), Number(NORMAL_95 * std, 2), unit]
            for words, torque, std in size_rows(size, shown.diagnosis)
        ]
    return rows


def _sure(finding: Finding) -> str:
    return f"probability {percent(finding.probability, 3)}"


def _gain(finding: Finding) -> str:
    return "" if np.isnan(finding.held_out) else f", held-out score {digits(finding.held_out, 3)}"


def _moments(shown: Shown) -> list[Block]:
    rows: list[list[Cell]] = [
        [
            moment.run,
            span(moment),
            ", ".join(str(joint + 1) for joint in moment.joints),
            Number(moment.force, 3),
            direction(moment),
        ]
        for moment in shown.diagnosis.moments
    ]
    if not rows:
        return []
    note = (
        "Windows in which a run, held-out runs included, differs from the model as at no other time, and "
        "the force on the flange that explains most of it, in the base's axes; one joint alone shows none."
    )
    head = ["run", "time", "joints", "force [N]", "direction"]
    return [Paragraph(note), Table(head, rows, words=(1, 2, 4))]


def _changes(shown: Shown) -> list[Block]:
    """All candidates that alone would lower the error; nothing without."""
    named_changes = zip(change_names(shown.diagnosis), shown.diagnosis.changes, strict=True)
    rows: list[list[Cell]] = [
        [
            name,
            shown.names[change.joint],
            fixed(change.squared_error_percent, 1),
            fixed(change.std_percent, 1),
        ]
        for name, change in named_changes
        if change.squared_error_percent < -LEAST_CHANGE
    ]
    if not rows:
        return []
    data = "held-out runs" if shown.residuals else "fitted runs, each block predicted by the others"
    note = (
        f"Change of the squared prediction error of {data} when only this candidate is added, on the joint "
        f"that improves most (negative is better); std: standard deviation over time blocks. {CHECK}"
    )
    head = ["candidate, alone", "joint improved most", "squared error, %", "std, %"]
    return [Table(head, rows, words=(1,), first=TOP), Paragraph(note)]


def simulation_section(shown: Shown) -> Section:
    """The arm in simulation, before and after; empty where nothing was simulated."""
    simulated = shown.diagnosis.simulated
    blocks = [] if simulated is None else _simulation(shown, simulated)
    return Section("simulation", "Simulation", blocks)


def _simulation(shown: Shown, simulated: Simulated) -> list[Block]:
    before, after = simulated.torque_rms_before, simulated.torque_rms_after
    note = (
        f"{simulated.run}, simulated in closed loop: an arm with drives of its own follows the recorded "
        "motion, and the torque of its motors is compared with the recorded one."
    )
    over = shown.over_noise
    remark = f"simulated less recorded torque, root mean square{' over noise' if over else ''}"
    drawn = _bars(shown, before, after, shown.noise, "simulated less recorded")
    figures = [Figure("All joints", remark, drawn)]
    if not np.all(np.isfinite([before, after])):
        note += " It diverged: where it did, there is no number."
    if (samples := shown.forward) is not None:
        missed = 1e3 * float(np.max(samples.missed))
        if np.isfinite(missed):
            size = f"{digits(missed, 2)} {_small(shown)}"
            note += f" Its motors miss the recorded positions by {size} at most, root mean square."
        gained = _gained(before, after, shown.noise)
        plot = forward_plot(samples, gained, shown.diagnosis.torque_units[gained])
        figures.append(Figure(shown.names[gained], simulated.run, plot))
    if simulated.left_out:
        note += f" Not simulated: {', '.join(effect_words(effect) for effect in simulated.left_out)}."
    return [Paragraph(note), Grid(figures)]


def _gained(before: np.ndarray, after: np.ndarray, noise: np.ndarray) -> int:
    """The joint that gains most; where a simulation diverged there is no gain."""
    with np.errstate(over="ignore", invalid="ignore"):
        gains = (before**2 - after**2) / noise**2
    return int(np.argmax(np.nan_to_num(gains, nan=-np.inf)))


def _small(shown: Shown) -> str:
    """Unit of a thousandth of a joint's way."""
    kinds = [
        name for name, unit in (("mrad", TURNING), ("mm", SLIDING)) if unit in shown.diagnosis.torque_units
    ]
    return " or ".join(kinds)


def _data(shown: Shown) -> list[Block]:
    diagnosis = shown.diagnosis
    runs = f"Fitted: {', '.join(diagnosis.runs)}; held out: {', '.join(diagnosis.held_out) or 'none'}."
    return [
        Paragraph(runs),
        Statements(diagnosis.warnings or ("Nothing about the recordings limits the result.",)),
    ]
