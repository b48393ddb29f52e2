"""Report: a fit as one HTML file that needs nothing else."""

import re
from pathlib import Path

from ...fit.fit import Fit
from ...fit.verdict import counted
from ..report_page import page
from .report_sections import SECTIONS


def write_report(fit: Fit, path: Path) -> None:
    """Write a self-contained HTML report: no script, no network, light and dark, fit to print."""
    Path(path).write_text(report_html(fit), encoding="utf-8")


def report_html(fit: Fit) -> str:
    """The report as text."""
    robot = fit.model.robot.name
    effects = ", ".join(_words(type(effect).__name__) for effect in fit.model.effects)
    counts = (counted(fit.model.robot.dof, "joint"), counted(len(fit.runs), "run"))
    note = "; ".join((*counts, fit.estimate.method, effects))
    body = "".join(section(fit) for section in SECTIONS)
    return page(f"{robot}: identified dynamics", robot, note, body)


def _words(name: str) -> str:
    """CoulombFriction -> coulomb friction."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).lower()
