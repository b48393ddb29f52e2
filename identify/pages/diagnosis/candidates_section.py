"""What each candidate alone would change, and when a run differs as at no other time."""

from ...diagnosis.words.changes_words import CHECK, shown
from ...diagnosis.words.moments_words import direction, span
from ...diagnosis.words.naming import joint_words, named
from ..report_html import MINUS, number, paragraph, section, table
from .page_data import PageData


def changes_section(diagnosis: PageData) -> str:
    """All candidates that alone would lower the error; nothing without."""
    if not diagnosis.changes:
        return ""
    rows = [
        [
            named(one.effect, one.joints, diagnosis.joints),
            joint_words(one.joint, diagnosis.joints),
            shown(one).replace("+-", "±").replace("-", MINUS),
        ]
        for one in diagnosis.changes
    ]
    data = "runs held out" if diagnosis.improvement else "fitted runs, each block predicted by the others"
    note = (
        f"Change of the squared prediction error of {data}, with one candidate in the model and nothing "
        f"else, on the joint that gains most; ± one standard deviation over blocks. {CHECK}"
    )
    head = ["candidate, alone", "gains most", "squared error, %"]
    return section(
        "candidates",
        "What each candidate alone would change",
        paragraph(note),
        table(head, rows, words=(0, 1)),
    )


def moments_section(diagnosis: PageData) -> str:
    """Times at which runs differ as at no other; nothing without."""
    if not diagnosis.moments:
        return ""
    rows = [
        [
            one.run,
            span(one),
            ", ".join(joint_words(joint, diagnosis.joints) for joint in one.joints),
            number(one.force, 3),
            direction(one).replace("-", MINUS),
        ]
        for one in diagnosis.moments
    ]
    note = (
        "Windows in which a run, those held out included, differs from the model as at no other time, and "
        "the force on the flange that explains most of it, in the base's axes. They are marked in plots over "
        "time."
    )
    head = ["run", "time", "joints", "force [N]", "direction"]
    return section(
        "moments",
        "When a run differs as at no other time",
        paragraph(note),
        table(head, rows, words=(0, 1, 2, 4)),
    )
