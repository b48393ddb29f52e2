"""Report: a fit as one HTML file that needs nothing else."""

import re
from html import escape
from pathlib import Path

from .fit import Fit
from .report_sections import SECTIONS
from .report_style import STYLE
from .verdict import counted

HEADING = re.compile(r'<section id="(\w+)"><h2>(.*?)</h2>')


def write_report(fit: Fit, path: Path) -> None:
    """Write a self-contained HTML report: no script, no network, light and dark, fit to print."""
    Path(path).write_text(report_html(fit), encoding="utf-8")


def report_html(fit: Fit) -> str:
    """The report as text."""
    robot = escape(fit.model.robot.name)
    body = "".join(section(fit) for section in SECTIONS)
    links = "".join(f'<a href="#{anchor}">{title}</a>' for anchor, title in HEADING.findall(body))
    effects = ", ".join(_words(type(effect).__name__) for effect in fit.model.effects)
    counts = (counted(fit.model.robot.dof, "joint"), counted(len(fit.runs), "run"))
    summary = "; ".join((*counts, escape(fit.estimate.method), effects))
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{robot}: identified dynamics</title><style>{STYLE}</style></head>"
        f'<body><h1>{robot}</h1><p class="note">{summary}</p><nav>{links}</nav>{body}</body></html>\n'
    )


def _words(name: str) -> str:
    """CoulombFriction -> coulomb friction."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).lower()
