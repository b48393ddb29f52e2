"""Saturation of a drive gain: a motor that takes more and more current for its torque.

Where magnets bias the iron, from a knee on: beyond it every further newton metre takes up to 1 + `loss` times
the current. Where nothing does, the gain is the same for either sign of the current, so that it falls with
the square of the torque x over a ceiling, which no current exceeds: current over torque is
1 + `loss` x² / (1 - x²).
"""

from collections.abc import Callable, Iterator, Mapping

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
"""Torque beyond the knee, over the largest, at which three quarters of that loss are there [-]: soon, or
beyond what was run."""
CEILINGS = (1.1, 1.5)
"""Torque over the largest of all runs that no current exceeds [-]: near what was run, or beyond it, where the
current lost grows with the cube of the torque."""

Excess = Callable[[np.ndarray], np.ndarray]
"""Current that is lost at a torque, both over those of the largest torque and not below zero [-]."""


def saturations(model: Model) -> Iterator[Candidate]:
    """Each drive in turn."""
    for joint in range(model.robot.dof):
        for knee in KNEES:
            for width in WIDTHS:
                yield _from_a_knee(joint, {"knee": knee, "width": width})
        for ceiling in CEILINGS:
            yield _below_a_ceiling(joint, {"ceiling": ceiling})


def _from_a_knee(joint: int, shape: Mapping[str, float]) -> Candidate:
    def excess(torque: np.ndarray) -> np.ndarray:
        beyond = np.maximum(torque - shape["knee"], 0.0)
        return beyond**2 / (beyond + shape["width"])

    bounds = {"knee": Shape("1", 0.05, 0.9), "width": Shape("1", 0.02, 5.0)}
    return _saturation(joint, excess, shape, bounds, lambda given: _from_a_knee(joint, given))


def _below_a_ceiling(joint: int, shape: Mapping[str, float]) -> Candidate:
    def excess(torque: np.ndarray) -> np.ndarray:
        square = (torque / shape["ceiling"]) ** 2
        return torque * square / (1.0 - square)

    bounds = {"ceiling": Shape("1", 1.03, 4.0)}
    return _saturation(joint, excess, shape, bounds, lambda given: _below_a_ceiling(joint, given))


def _saturation(
    joint: int,
    excess: Excess,
    shape: Mapping[str, float],
    bounds: Mapping[str, Shape],
    reshaped: Callable[[Mapping[str, float]], Candidate],
) -> Candidate:
    def columns(run: Driven) -> np.ndarray:
        require_current(run)
        most = max(float(run.most[joint]), 1e-12)
        torque = run.torque[:, joint] / most
        return on_joint(run, joint, most * np.sign(torque) * excess(np.abs(torque)))

    return Candidate(
        "drive_gain_saturation", (joint,), columns, ("loss",), ("1",), (0.0,), dict(shape), bounds, reshaped,
        rows=(joint,), loaded=True,
    )  # fmt: skip


KIND = Kind(
    sentence="{joint} has a drive gain that falls at high torque[, from {knee:%} of the largest torque on][, "
    "below a ceiling of {ceiling:%} of the largest torque]",
    drawn_against=("torque", "velocity"),
    ask=saturations,
    sensor=True,
    mistaken_for=("current_clipping", "nonlinear_viscous_friction"),
    settled_by="a faster run with a body of known mass on the flange",
)
