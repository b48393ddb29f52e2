"""Joined: robot, runs, fits, diagnosis and comparisons as one page that needs nothing else."""

from ...fit.verdict import counted
from ..diagnosis import sections as diagnosis_sections
from ..fit.report_sections import SECTIONS, verdict_section
from ..report_page import Chapter, page
from .before_after import before_and_after
from .material import Compared as Compared
from .material import Fitted as Fitted
from .material import Material as Material
from .material import Run as Run
from .robot import robot_sections
from .runs import runs_sections
from .verdict import opening


def joined_html(material: Material) -> str:
    """The page as text: no script, no network, light and dark, fit to print."""
    fits = [
        (fitted.improved, Chapter(f"fit{place or ''}", fitted.title, "".join(one(fitted.fit) for one in FIT)))
        for place, fitted in enumerate(material.fits)
    ]
    chapters = [
        Chapter("robot", "Nominal robot", robot_sections(material.model) if material.model else ""),
        Chapter("runs", "Runs", runs_sections(material)),
        *(chapter for improved, chapter in fits if not improved),
        Chapter("diagnosis", "Diagnosis", _diagnosis(material)),
        *(chapter for improved, chapter in fits if improved),
        Chapter("gained", "Before and after", before_and_after(material)),
    ]
    title = f"{material.model.robot.name}: report" if material.model else "Report"
    note = "; ".join((counted(len(material.joints), "joint"), *material.files.values()))
    return page(title, title, note, opening(material), chapters)


FIT = tuple(section for section in SECTIONS if section is not verdict_section)
"""Sections of a fit below its verdict, which opens the page."""


def _diagnosis(material: Material) -> str:
    if material.diagnosis is None:
        return ""
    return "".join(section(material.diagnosis) for section in diagnosis_sections.DETAILS)
