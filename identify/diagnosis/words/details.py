"""Details of a finding in sentences, for pages: what else it may be, and how to decide."""

from ...text_table import percent
from ..candidates import kind_of
from ..findings.diagnosis import Diagnosis
from ..findings.finding import Finding
from .naming import joined, lower, named
from .verdict import decides, finding_sentence


def details(diagnosis: Diagnosis, finding: Finding, folder: str = "") -> list[str]:
    """The finding, its probability, what is not excluded, the run that decides, and a remark."""
    parts = [finding_sentence(diagnosis, finding)]
    if finding in diagnosis.findings:
        parts.append(f"Probability {percent(finding.probability, 3)}.")
    if finding.alternatives:
        others = [
            f"{named(other.effect, other.joints, diagnosis.joints)} ({percent(other.probability)})"
            for other in finding.alternatives
        ]
        parts.append(f"Not excluded: {lower(joined(others))}. To decide: {decides(finding, folder)}.")
    if remark := kind_of(finding.effect).remark:
        parts.append(f"{remark}.")
    return parts
