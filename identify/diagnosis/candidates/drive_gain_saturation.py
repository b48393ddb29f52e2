"""Saturation of a drive gain: a motor that takes more and more current for its torque, from a knee on.

From 1 at the knee the torque per ampere falls to 1 - `loss`: never below zero, as no motor gives less torque
for more current.
"""

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
WIDTHS = (0.2, 2.0)
"""Torque beyond the knee, over the largest, at which three quarters of the loss per ampere are there [-]:
soon, or beyond what was run, where the torque lost grows with the square."""


def saturations(model: Model) -> Iterator[Candidate]:
    """Each drive in turn."""
    for joint in range(model.robot.dof):
        yield _saturation(joint, 0.0, WIDTHS[-1], 3.0)
        for knee in KNEES:
            for width in WIDTHS:
                yield _saturation(joint, knee, width, 2.0)


def _saturation(joint: int, knee: float, width: float, power: float) -> Candidate:
    def columns(run: Driven) -> np.ndarray:
        require_current(run)
        torque = run.torque[:, joint]
        most = run.most[joint]
        beyond = np.maximum(np.abs(torque) - knee * most, 0.0)
        return on_joint(run, joint, np.sign(torque) * beyond**power / (beyond + max(width * most, 1e-12)) ** (power - 1.0))

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return _saturation(joint, given["knee"], given["width"], given["power"])

    bounds = {"knee": Shape("1", 0.0, 0.9), "width": Shape("1", 0.02, 5.0), "power": Shape("1", 2.0, 3.0)}
    return Candidate(
        "drive_gain_saturation", (joint,), columns, ("loss",), ("1",), (0.0,), {"knee": knee, "width": width, "power": power},
        bounds, reshaped, rows=(joint,), loaded=True,
    )  # fmt: skip


KIND = Kind(
    sentence="{joint} has a drive gain that falls at high torque[, from {knee:%} of the largest torque on]",
    drawn_against=("torque", "velocity"),
    ask=saturations,
    sensor=True,
    mistaken_for=("current_clipping", "nonlinear_viscous_friction"),
    settled_by="a faster run with a body of known mass on the flange",
)
