"""Importance of findings, their shares of the residual, and the residual before and after them."""

from typing import NamedTuple

import numpy as np

from ..findings.diagnosis import Diagnosis
from ..findings.finding import Finding
from ..results.budget import LEAST

MOST = 0.5
"""Share beyond which a finding explains most of a joint's squared residual [-]."""


def shares(diagnosis: Diagnosis, finding: Finding) -> np.ndarray:
    """Share of each joint's squared residual that a finding explains, shape (n,) [-].

    It is zero where the finding does not act, and NaN where the budget does not contain the finding.
    """
    place = diagnosis.all_findings.index(finding)
    parts = diagnosis.budget.shares if diagnosis.budget is not None else ()
    known = next((part.percent / 100.0 for part in parts if part.finding == place), None)
    return np.where(finding.torque_rms > 0.0, np.nan if known is None else known, 0.0)


def clearest_joint(diagnosis: Diagnosis, finding: Finding) -> int:
    """Index of the joint on which a finding explains most; if that is unknown, the joint with most torque."""
    explained = shares(diagnosis, finding)
    if np.any(explained > 0.0):
        return int(np.nanargmax(explained))
    return int(np.argmax(finding.torque_rms / diagnosis.noise))


def important(diagnosis: Diagnosis) -> list[Finding]:
    """Findings that explain a part of any joint's residual, decided or not, the most important first.

    Certain names and families come first; among these, those that explain most of a joint's residual, then
    those with more power over noise. Findings that the budget does not contain come last.
    """
    before = np.zeros(len(diagnosis.joints)) if diagnosis.budget is None else diagnosis.budget.before_rms

    def importance(finding: Finding) -> tuple[bool, bool, float, float]:
        certain = finding in diagnosis.findings or bool(finding.family)
        explained = np.nan_to_num(shares(diagnosis, finding))
        powers = np.array([explained * before**2, finding.torque_rms**2]) / diagnosis.noise**2
        power, torque = map(float, np.max(powers, axis=1))
        return certain, bool(np.max(explained) > MOST), power, torque

    explaining = [f for f in diagnosis.all_findings if not np.max(shares(diagnosis, f)) < LEAST]
    return sorted(explaining, key=importance, reverse=True)


class Residuals(NamedTuple):
    """Residual of each joint without and with findings."""

    before: np.ndarray  # residual of the baseline, shape (n,) [N m]
    after: np.ndarray  # residual with findings, shape (n,) [N m]
    held_out: bool  # whether they are those of held-out runs, otherwise of left-out blocks


def residuals(diagnosis: Diagnosis) -> Residuals | None:
    """Residuals of held-out runs if there are any; None for a diagnosis with neither these nor a budget."""
    budget, before, after = diagnosis.budget, diagnosis.torque_rms_before, diagnosis.torque_rms_after
    if budget is not None and (budget.held_out or before is None):
        return Residuals(budget.before_rms, budget.after_rms, bool(budget.held_out))
    return None if before is None or after is None else Residuals(before, after, True)
