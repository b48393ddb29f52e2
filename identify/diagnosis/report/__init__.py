"""Report: a diagnosis as one HTML file that needs nothing else."""

import re
from html import escape

from ...report_style import STYLE
from ...verdict import counted
from ..finding import Diagnosis
from ..forward import Forward
from .sections import SECTIONS
from .style import MORE_STYLE

HEADING = re.compile(r'<section id="(\w+)"><h2>(.*?)</h2>')


def report_html(diagnosis: Diagnosis, forward: Forward | None = None, folder: str = "") -> str:
    """The report as text: no script, no network, light and dark, fit to print.

    Args:
        diagnosis: With its evidence; without, there are words and tables only.
        forward: How simulations of a run compare with it; None if there are none.
        folder: Where models of findings and rivals are written; empty if they are not.
    """
    name = escape(diagnosis.name)
    body = "".join(section(diagnosis, forward, folder) for section in SECTIONS)
    links = "".join(f'<a href="#{anchor}">{title}</a>' for anchor, title in HEADING.findall(body))
    held_out = diagnosis.improvement.runs if diagnosis.improvement else ()
    summary = "; ".join(
        (
            counted(len(diagnosis.joints), "joint"),
            f"{counted(len(diagnosis.runs), 'run')} fitted",
            f"{len(held_out)} held out",
            f"{diagnosis.seconds:.0f} s",
        )
    )
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{name}: what the model leaves out</title><style>{STYLE}{MORE_STYLE}</style></head>"
        f'<body><h1>{name}: what the model leaves out</h1><p class="note">{summary}</p>'
        f"<nav>{links}</nav>{body}</body></html>\n"
    )
