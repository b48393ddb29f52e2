"""Report: robot, runs, fits, diagnosis and comparisons on one page."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..document.document import (
    Block,
    Chapter,
    Document,
    Heading,
    Paragraph,
    Section,
    Statements,
)
from ..document.html import html
from ..fit.agreement import Agreement
from ..fit.fit import Fit
from ..model import Model
from ..notebook import counted
from ..simulation.comparison import Comparison
from .compared_document import before_and_after, compared_sections, verdict
from .diagnosis_document import detail_sections, verdict_blocks
from .fit_document import fit_sections
from .fit_document import verdict_blocks as fit_verdict_blocks
from .robot_document import robot_sections
from .runs_document import Run, runs_sections
from .shown import Shown


class Fitted(NamedTuple):
    """A fit with its title on the page."""

    title: str  # title, as plain text
    fit: Fit  # the fit, with its predictions of the runs if these were given
    nominal: Fit | None = None  # the same model with nominal values; None if they are unknown
    improved: bool = False  # whether the model contains the findings of a diagnosis


@dataclass(frozen=True, eq=False)
class Material:
    """All results of a report."""

    joints: tuple[str, ...]  # names of the joints, which all results share
    model: Model | None  # the nominal robot; None if unknown
    runs: tuple[Run, ...]  # recorded runs
    fits: tuple[Fitted, ...]  # fits in the order in which they were given, improved ones last
    diagnosis: Shown | None  # the diagnosis; None without one
    comparisons: tuple[Comparison, ...]  # comparisons of simulations with recordings
    files: Mapping[str, str]  # content of each file that was read, in words, such as "fit.json" -> "a fit"


def joined_html(material: Material) -> str:
    """The report as one self-contained HTML page."""
    return html(joined_document(material))


def joined_document(material: Material) -> Document:
    """The document of a report."""
    # The verdict of a fit opens the page.
    fits = [
        (fitted.improved, Chapter(f"fit{place or ''}", fitted.title, fit_sections(fitted.fit)[1:]))
        for place, fitted in enumerate(material.fits)
    ]
    chapters = [
        Chapter("robot", "Nominal robot", robot_sections(material.model) if material.model else ()),
        Chapter("runs", "Runs", runs_sections(material.runs, material.joints, material.model)),
        *(chapter for improved, chapter in fits if not improved),
        Chapter("diagnosis", "Diagnosis", detail_sections(material.diagnosis) if material.diagnosis else ()),
        *(chapter for improved, chapter in fits if improved),
        Chapter("gained", "Before and after", _before_and_after(material)),
    ]
    title = f"{material.model.robot.name}: report" if material.model else "Report"
    note = "; ".join((counted(len(material.joints), "joint"), *material.files.values()))
    return Document(title, note, [Section("verdict", "Verdict", list(_verdict(material)))], chapters)


def _verdict(material: Material) -> Iterator[Block]:
    """Verdicts of fits, diagnosis and comparisons, and the results that the page lacks."""
    for fitted in (fitted for fitted in material.fits if not fitted.improved):
        yield from (Heading("Identified dynamics"), *fit_verdict_blocks(fitted.fit))
    if material.diagnosis is not None:
        yield from (Heading("Missing physics"), *verdict_blocks(material.diagnosis))
    for fitted in (fitted for fitted in material.fits if fitted.improved):
        yield from (Heading("Identified dynamics with the findings"), *fit_verdict_blocks(fitted.fit))
    if material.comparisons:
        lines = [f"{c.simulated} versus {c.recorded}: {verdict(c)[0]}" for c in material.comparisons]
        yield from (Heading("Comparison with simulations"), Statements(lines, "verdict"))
    if lacking := list(_lacking(material)):
        yield from (Heading("Results that this page lacks"), Statements(lacking))


def _lacking(material: Material) -> Iterator[str]:
    """Results that were not given, each with the command that makes it."""
    if not material.fits:
        yield "Parameters: there is no fit. exidyn identify RUN... makes one."
    elif not any(fitted.fit.agreement or fitted.fit.validation for fitted in material.fits):
        yield "Measured and predicted torque: give the recordings beside fit.json."
    if material.diagnosis is None:
        yield "Missing physics: there is no diagnosis. exidyn diagnose robot.toml RUN... makes one."
    elif not material.diagnosis.traces:
        yield "Residuals over time: traces.npz is not beside diagnosis.json."
    if not material.comparisons:
        yield (
            "Simulation: there is none. exidyn simulate fit.json trajectory.toml makes one, and exidyn "
            "compare sim.mcap run.mcap --json compared.json compares it with a run."
        )


def _before_and_after(material: Material) -> list[Section]:
    """Gains of identification, and comparisons with simulations."""
    sections = [
        section for place, fitted in enumerate(material.fits) if (section := _identified(fitted, place))
    ]
    compared = [(comparison, verdict(comparison)) for comparison in material.comparisons]
    return [*sections, *compared_sections(compared)]


def _identified(fitted: Fitted, place: int) -> Section | None:
    """Residual with nominal and with identified values; None without samples."""
    runs = _runs(fitted.fit)
    if fitted.nominal is None or not runs:
        return None
    before, after = (_rms(_runs(fit)) for fit in (fitted.nominal, fitted.fit))
    noise = np.sqrt(np.mean([run.noise**2 for run in runs], axis=0))
    note = (
        "Before: the nominal robot with its drive gains; unstated parameters are zero. After: the same model "
        "with the identified values. Each residual refers to the torque that the drive gains of that model "
        "give for the currents, relative to the noise floor."
    )
    role = "held out" if fitted.fit.validation else "used for the fit"
    remark = ", ".join([*(run.run for run in runs), role])
    table = before_and_after(fitted.fit.model.robot.joints, before / noise, after / noise)
    title = f"Nominal and identified values: residual over noise, {remark}"
    return Section(f"values{place or ''}", title, [Paragraph(note), table])


def _runs(fit: Fit) -> tuple[Agreement, ...]:
    return fit.validation or fit.agreement


def _rms(runs: Sequence[Agreement]) -> np.ndarray:
    return np.sqrt(np.mean([run.residual_rms**2 for run in runs], axis=0))
