"""Saturation of a drive gain: a motor that takes more and more current for its torque, from a knee on."""

from collections.abc import Iterator, Mapping

import numpy as np

from ...effects import Shape
from ...model import Model
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .parts.motors import on_joint, require_current

KNEES = (0.3, 0.5, 0.7)
"""Torque over the largest of all runs from which on a motor gives less per ampere [-]."""


def saturations(model: Model) -> Iterator[Candidate]:
    """Each drive in turn."""
    for joint in range(model.robot.dof):
        for knee in KNEES:
            yield _saturation(joint, knee)


def _saturation(joint: int, knee: float) -> Candidate:
    def columns(run: Driven) -> np.ndarray:
        require_current(run)
        torque = run.torque[:, joint]
        most = run.most[joint]
        beyond = np.maximum(np.abs(torque) - knee * most, 0.0)
        return on_joint(run, joint, np.sign(torque) * beyond**2 / max(most, 1e-12))

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return _saturation(joint, given["knee"])

    bounds = {"knee": Shape("1", 0.05, 0.9)}
    return Candidate(
        "drive_gain_saturation", (joint,), columns, ("curvature",), ("1",), (0.0,), {"knee": knee}, bounds,
        reshaped, rows=(joint,), loaded=True,
    )  # fmt: skip


KIND = Kind(
    sentence="{joint} has a drive gain that falls at high torque[, from {knee:%} of the largest torque on]",
    drawn_against=("torque", "velocity"),
    ask=saturations,
    sensor=True,
    mistaken_for=("current_clipping", "nonlinear_viscous_friction"),
    settled_by="a faster run with a body of known mass on the flange",
)
