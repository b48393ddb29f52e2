"""Clipping: a recorded current that ends while the torque goes on."""

from collections.abc import Iterator, Mapping

import numpy as np

from ...effects import Shape
from ...model import Model
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .parts.motors import on_joint

CLIPS = (0.6, 0.8, 0.9, 0.97)
"""Torque over the largest of all runs at which a current ends [-]."""
ENDS = 0.15
"""By how much that which lies beyond may be more or less than all that is missing [-]: the torque is known so
well."""


def clips(model: Model) -> Iterator[Candidate]:
    """Each drive in turn."""
    for joint in range(model.robot.dof):
        for level in CLIPS:
            yield _clip(joint, level)


def _clip(joint: int, level: float) -> Candidate:
    def columns(run: Driven) -> np.ndarray:
        torque = run.torque[:, joint]
        beyond = np.maximum(np.abs(torque) - level * run.most[joint], 0.0)
        return on_joint(run, joint, -np.sign(torque) * beyond)

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return _clip(joint, given["level"])

    bounds = {"level": Shape("1", 0.3, 0.999)}
    return Candidate(
        "current_clipping", (joint,), columns, ("slope",), ("1",), (0.0,), {"level": level}, bounds, reshaped,
        rows=(joint,), expected=((1.0, ENDS),), loaded=True, reloads=True,
    )  # fmt: skip


KIND = Kind(
    sentence="{joint} has a recorded current that is clipped[ at {level:%} of its largest torque] while "
    "the torque goes on rising",
    drawn_against=("torque", "time"),
    ask=clips,
    sensor=True,
    mistaken_for=("drive_gain_saturation",),
    settled_by="a run at half the speed, in which no current reaches its end",
)
