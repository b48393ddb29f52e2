"""Table of a diagnosis: residual, findings, their sizes, probabilities and gains, joint by joint."""

from collections.abc import Iterator

import numpy as np

from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.findings.evidence import UNCERTAIN
from ..diagnosis.findings.finding import Finding
from ..diagnosis.findings.quantities import with_interval
from ..diagnosis.results.budget import LEAST
from ..diagnosis.words.importance import clearest_joint, residuals, shares
from ..diagnosis.words.naming import effect_words
from ..diagnosis.words.sentences import hypotheses_words, main_number, reservations
from ..document.document import Cell, Number, Numbers, Table
from ..text_table import percent

SHORT = 10
"""Length of the longest name of a joint that a column of the table holds; longer ones are numbers."""
SMALL = 0.05
"""Share of a joint's squared residual below which the short table leaves out an undecided finding [-]: the
residual changes by less than its fortieth part."""
GAIN = "{}: part of the joint's squared residual that the finding explains."


def findings_table(diagnosis: Diagnosis, brief: bool = False) -> Table:
    """One row for each finding and unexplained residual of a joint; joints without any have one row.

    The short table has one row for all undecided findings that explain little.
    """
    rows, listed, least = list[list[Cell]](), set[int](), SMALL if brief else 0.0
    for joint, name in enumerate(joint_names(diagnosis)):
        shown = list(_of_findings(diagnosis, joint, least))
        listed |= {id(finding) for finding, _ in shown}
        found = [*(cells for _, cells in shown), *_unexplained(diagnosis, joint)] or [("-", "", "")]
        starts = [(name, _residual(diagnosis, joint)), *[("", "")] * (len(found) - 1)]
        rows += [[*start, *cells] for start, cells in zip(starts, found, strict=True)]
    left_out = [f for f in diagnosis.all_findings if joints_listed(diagnosis, f) and id(f) not in listed]
    if left_out:
        rows.append(["", "", f"{len(left_out)} smaller undecided: --full", "", ""])
    unit = f" [{_unit}]" if (_unit := _shared_unit(diagnosis)) else ""
    return Table(
        ["joint", f"residual{unit}", "finding: size", "probability", gain_title(diagnosis)], rows, (2,)
    )


def gain_title(diagnosis: Diagnosis) -> str:
    """Title of the column of gains."""
    known = residuals(diagnosis)
    return "held-out gain" if known is not None and known.held_out else "gain"


def joint_names(diagnosis: Diagnosis) -> list[str]:
    """Names of the joints if all are short, else their numbers, which lines of text have room for."""
    names = list(diagnosis.joints)
    return names if max(map(len, names)) <= SHORT else [str(place + 1) for place in range(len(names))]


def _shared_unit(diagnosis: Diagnosis) -> str:
    return diagnosis.torque_units[0] if len(set(diagnosis.torque_units)) == 1 else ""


def _residual(diagnosis: Diagnosis, joint: int) -> Cell:
    if (known := residuals(diagnosis)) is None:
        return "-"
    unit = "" if _shared_unit(diagnosis) else diagnosis.torque_units[joint]
    return Numbers("{} -> {}", (Number(known.before[joint], 3), Number(known.after[joint], 3, unit)))


def _of_findings(
    diagnosis: Diagnosis, joint: int, least: float
) -> Iterator[tuple[Finding, tuple[str, str, str]]]:
    """Findings that explain a part of a joint's residual, with their cells, the largest part first."""
    explained = [(shares(diagnosis, finding)[joint], finding) for finding in diagnosis.all_findings]
    for part, finding in sorted(explained, key=lambda pair: -np.nan_to_num(pair[0])):
        joints = joints_listed(diagnosis, finding, least)
        gain = "" if np.isnan(part) else _short(float(part), 2) if part >= LEAST else "none"
        if joint in joints[:1]:
            words, probability = _finding_words(diagnosis, finding), _probability(diagnosis, finding)
            yield finding, (words, probability, gain)
        elif joint in joints:
            name = "undecided" if finding in diagnosis.undecided else effect_words(finding.effect)
            where = joint_names(diagnosis)[joints[0]]
            yield finding, (f"{name}, as on {f'joint {where}' if where.isdigit() else where}", "", gain)


def joints_listed(diagnosis: Diagnosis, finding: Finding, least: float = 0.0) -> list[int]:
    """Joints of which a finding explains a part; if it explains none, the one that shows a named one best.

    Of an undecided finding, the part is at least `least`.
    """
    explained, named = shares(diagnosis, finding), finding in diagnosis.findings
    enough = LEAST if named else max(LEAST, least)
    joints = [int(joint) for joint in np.flatnonzero(explained >= enough)]
    shown = named or bool(np.any(np.isnan(explained)))
    return joints or ([clearest_joint(diagnosis, finding)] if shown else [])


def _finding_words(diagnosis: Diagnosis, finding: Finding) -> str:
    """Name and size of a finding; hypotheses of an undecided one, and why it is undecided."""
    if _withheld(diagnosis, finding):
        return f"candidate: {hypotheses_words(finding, diagnosis.joints, probable=False)}"
    if finding in diagnosis.undecided:
        return f"undecided: {hypotheses_words(finding, diagnosis.joints)}{reservations(finding)}"
    number = main_number(finding) or _torque(diagnosis, finding)
    beliefs = diagnosis.beliefs
    conditional = beliefs is not None and diagnosis.all_findings.index(finding) in beliefs.conditional
    condition = " (bodies as described)" if conditional else ""
    return effect_words(finding.effect) + (f": {number}" if number else "") + condition


def _withheld(diagnosis: Diagnosis, finding: Finding) -> bool:
    """Whether a finding has no name because its joints do not fit as correct recordings do."""
    return diagnosis.adequacy is not None and diagnosis.adequacy.fails(finding.joints)


def _torque(diagnosis: Diagnosis, finding: Finding) -> str:
    """Largest torque of a finding whose parameters are not determined; empty if it may be zero."""
    if (size := finding.size) is None or not size.known:
        return ""
    most = max(size.points, key=lambda point: abs(point.torque))
    return f"{with_interval(most.torque, most.std)} {diagnosis.torque_units[size.joint]}"


def _probability(diagnosis: Diagnosis, finding: Finding) -> str:
    """Probability of a finding, or of the family of an undecided one; empty without a family."""
    probability = finding.probability
    if finding in diagnosis.undecided or _withheld(diagnosis, finding):
        probability = finding.family_probability
    return "" if np.isnan(probability) else _short(probability)


def _unexplained(diagnosis: Diagnosis, joint: int) -> Iterator[tuple[str, str, str]]:
    for remainder in diagnosis.remainders:
        if remainder.joint == joint and remainder.depends_on != UNCERTAIN:
            yield f"unexplained, depends on {remainder.depends_on}", _short(remainder.probability), ""


def _short(share: float, significant: int = 3) -> str:
    return percent(share, significant).replace("above", ">").replace("below", "<")
