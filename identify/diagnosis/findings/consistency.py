"""Consistency between the fields of a diagnosis, which an edited file may violate."""

import math
from typing import TYPE_CHECKING

from ...schema import check, check_different, check_joints, check_length
from .axes import AXES

if TYPE_CHECKING:
    from .diagnosis import Diagnosis

PER_JOINT = ("torque_units", "noise", "torque_rms_before", "torque_rms_after")
ROWS = ("findings", "undecided", "remainders", "moments")


def check_diagnosis(diagnosis: "Diagnosis") -> None:
    """Check lengths, joint numbers and indices of findings.

    Raises:
        Disagreement: A field does not agree with the others; the message names it.
    """
    count = len(diagnosis.joints)
    check(count > 0, "joints", (), "the names of the joints")
    check_different(diagnosis.joints, "joints")
    _check_lengths(diagnosis, PER_JOINT, "", count)
    for place, noise in enumerate(diagnosis.noise):
        check(bool(noise > 0.0), f"noise[{place}]", float(noise), "a number above 0")
    for rows in ROWS:
        for place, row in enumerate(getattr(diagnosis, rows)):
            _check_row(row, f"{rows}[{place}]", count)
    _check_budget(diagnosis, count)


def _check_lengths(value: object, names: tuple[str, ...], where: str, count: int) -> None:
    for name in names:
        check_length(getattr(value, name, None), f"{where}{name}", count, "one per joint")


def _check_row(row: object, where: str, count: int) -> None:
    """Check joints and lengths of a row and of its nested rows."""
    joints = [row.joint] if hasattr(row, "joint") else []
    check_joints([joint + 1 for joint in joints], f"{where}.joint", count)
    check_joints([joint + 1 for joint in getattr(row, "joints", ())], f"{where}.joints", count)
    _check_lengths(row, ("torque_rms",), f"{where}.", count)
    if (size := getattr(row, "size", None)) is not None:
        _check_row(size, f"{where}.size", count)
        over = AXES if size.points or size.curve else ("", *AXES)
        check(size.over in over, f"{where}.size.over", size.over, f"one of {', '.join(AXES)}")
        for name in ("points", "curve"):
            for place, point in enumerate(getattr(size, name)):
                finite = math.isfinite(point.at) and math.isfinite(point.torque) and math.isfinite(point.std)
                check(finite, f"{where}.size.{name}[{place}]", None, "three numbers")
    for place, other in enumerate(getattr(row, "alternatives", ())):
        _check_row(other, f"{where}.alternatives[{place}]", count)


def _check_budget(diagnosis: "Diagnosis", count: int) -> None:
    if (budget := diagnosis.budget) is None:
        return
    _check_lengths(budget, ("before_rms", "after_rms"), "budget.", count)
    check(bool(budget.shares), "budget.shares", [], "at least one part")
    findings = len(diagnosis.all_findings)
    for place, share in enumerate(budget.shares):
        where = f"budget.shares[{place}]"
        _check_lengths(share, ("percent",), f"{where}.", count)
        exists = share.finding is None or share.finding < findings
        check(exists, f"{where}.finding", share.finding, f"the place of one of {findings} findings, from 0")
