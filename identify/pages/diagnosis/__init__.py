"""Report: a diagnosis as one HTML file that needs nothing else."""

from ...diagnosis.findings.finding import Diagnosis
from ...diagnosis.improved.forward import Forward
from ...fit.verdict import counted
from ..report_page import page
from .page_data import PageData, page_data
from .sections import SECTIONS


def report_html(diagnosis: Diagnosis, forward: Forward | None = None, folder: str = "") -> str:
    """The report as text: no script, no network, light and dark, fit to print.

    Args:
        diagnosis: With its evidence; without, there are words and tables only.
        forward: How simulations of a run compare with it; None if there are none.
        folder: Where models of findings and rivals are written; empty if they are not.
    """
    return _page(page_data(diagnosis, forward, folder))


def _page(diagnosis: PageData) -> str:
    title = f"{diagnosis.name}: what the model leaves out"
    held_out = diagnosis.improvement.runs if diagnosis.improvement else ()
    note = "; ".join(
        (
            counted(len(diagnosis.joints), "joint"),
            f"{counted(len(diagnosis.runs), 'run')} fitted",
            f"{len(held_out)} held out",
            f"diagnosed in {diagnosis.seconds:.0f} s",
        )
    )
    return page(title, title, note, "".join(section(diagnosis) for section in SECTIONS))
