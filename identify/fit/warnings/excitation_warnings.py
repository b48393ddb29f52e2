"""Warnings about motions that are too poor, though something could be computed from them."""

from collections.abc import Sequence

import numpy as np

from ...preparation.prepare import Prepared

SMALLEST = 0.05
"""Range of a joint over all runs [rad] or [m] below which it counts as not moved: three degrees change
gravity by at most a twentieth, and friction acts in them for too short to be distinguished from an offset."""

WORST = 1000.0
"""Condition number from which a motion is poor: some combination of parameters is then seen a thousand
times more weakly than the best, and a torque error of a thousandth is all of it. Good ones are near 100."""


def excitation_warnings(joints: Sequence[str], runs: Sequence[Prepared], condition: float) -> tuple[str, ...]:
    """What the user should know of the motions used, in sentences; empty if they will do."""
    lower = np.min([run.motion.position.min(axis=0) for run in runs], axis=0)
    upper = np.max([run.motion.position.max(axis=0) for run in runs], axis=0)
    warnings = [
        f"{joint} moves by only {reach:.2g} rad or m in all runs used (under {SMALLEST}): its friction and "
        "inertia cannot be found; add a run in which it moves"
        for joint, reach in zip(joints, upper - lower, strict=True)
        if reach < SMALLEST
    ]
    if not condition < WORST:
        warnings.append(
            f"the motion is poor: condition number {condition:.3g} (good ones are near 100, the limit is "
            f"{WORST:g}); values may be wrong by more than their deviations. "
            "Move all joints, farther and faster"
        )
    return tuple(warnings)
