"""Consistency between the fields of a diagnosis, which an edited file may violate."""

import math
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any

from ...schema import check, check_different, check_joints, check_length
from .axes import AXES
from .size import Point, Size

if TYPE_CHECKING:
    from .diagnosis import Diagnosis

PER_JOINT = (
    "torque_units noise torque_rms torque_rms_before torque_rms_after before_rms after_rms percent"
).split()
"""Fields with one value for each joint, in any row."""


def check_diagnosis(diagnosis: "Diagnosis") -> None:
    """Check lengths, joint numbers and indices of findings.

    Raises:
        Disagreement: A field does not agree with the others; the message names it.
    """
    check(len(diagnosis.joints) > 0, "joints", (), "the names of the joints")
    check_different(diagnosis.joints, "joints")
    for place, noise in enumerate(diagnosis.noise):
        check(bool(noise > 0.0), f"noise[{place}]", float(noise), "a number above 0")
    _check_row(diagnosis, "", len(diagnosis.joints))
    if diagnosis.budget is not None:
        check(bool(diagnosis.budget.shares), "budget.shares", [], "at least one part")
        findings = len(diagnosis.all_findings)
        for place, share in enumerate(diagnosis.budget.shares):
            where, wanted = (
                f"budget.shares[{place}].finding",
                f"the place of one of {findings} findings, from 0",
            )
            check(share.finding is None or share.finding < findings, where, share.finding, wanted)


def _check_row(row: Any, where: str, count: int) -> None:
    """Check joints and lengths of a row and of its nested rows."""
    for name in (field.name for field in fields(row)):
        value, place = getattr(row, name), f"{where}{name}"
        if name in PER_JOINT:
            check_length(value, place, count, "one per joint")
        elif name == "joint" or (name == "joints" and where):
            check_joints([joint + 1 for joint in (value if name == "joints" else [value])], place, count)
        elif is_dataclass(value):
            _check_row(value, f"{place}.", count)
        elif isinstance(value, tuple):
            for number, inner in enumerate(value):
                if is_dataclass(inner):
                    _check_row(inner, f"{place}[{number}].", count)
    if isinstance(row, Size):
        over = AXES if row.points or row.curve else ("", *AXES)
        check(row.over in over, f"{where}over", row.over, f"one of {', '.join(AXES)}")
    if isinstance(row, Point):
        finite = math.isfinite(row.at) and math.isfinite(row.torque) and math.isfinite(row.std)
        check(finite, where.removesuffix("."), None, "three numbers")
