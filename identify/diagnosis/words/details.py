"""Details of a finding in sentences, for pages: what else it is not, and how to decide."""

from ...text_table import percent
from ..candidates import kind_of, kinds
from ..findings.diagnosis import Diagnosis
from ..findings.finding import Finding, Hypothesis
from ..search.selected import EXCLUDED
from .naming import effect_words, joined, lower, named
from .verdict import decides, finding_sentence


def details(diagnosis: Diagnosis, finding: Finding, folder: str = "") -> list[str]:
    """The finding, its probability, excluded effects, the run that decides, and a remark."""
    parts = [finding_sentence(diagnosis, finding)]
    if finding in diagnosis.findings:
        parts += [f"Probability {percent(finding.probability, 3)}.", _excluded(diagnosis, finding)]
    if finding.alternatives:
        others = [
            f"{named(other.effect, other.joints, diagnosis.joints)} ({percent(other.probability)})"
            for other in finding.alternatives
        ]
        parts.append(f"Not excluded: {lower(joined(others))}. To decide: {decides(finding, folder)}.")
    if remark := kind_of(finding.effect).remark:
        parts.append(f"{remark}.")
    return [part for part in parts if part]


def _excluded(diagnosis: Diagnosis, finding: Finding) -> str:
    """Sentence on similar effects that the data exclude."""
    hypotheses: list[Hypothesis] = [*diagnosis.all_findings]
    hypotheses += [other for each in diagnosis.all_findings for other in each.alternatives]
    present = {hypothesis.effect for hypothesis in hypotheses}
    tried, similar = diagnosis.tried or kinds(), kind_of(finding.effect).mistaken_for
    names = [effect_words(name) for name in similar if name in tried and name not in present]
    return f"Excluded (each less than {100 * EXCLUDED:.0f} % probable): {', '.join(names)}." if names else ""
