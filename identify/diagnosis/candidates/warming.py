"""Warming: friction that falls during each run, of a joint whose temperature was not recorded.

Grease thins as the motor warms up. From a cold start, the temperature rises by a share 1 - exp(-t / tau) of
its final rise, and friction falls with it to that of the model. All runs are taken to begin equally cold.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from ...effects import Shape
from ...effects.smooth_sign import smooth_sign
from ...errors import NotRecorded
from ...model import Model
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .parts import RARE, on_joint

WARMING = "warming_friction"
TIMES = (5.0, 20.0, 80.0)
"""Time constants that are tried [s], a factor of four apart: of windings up to small motors. In a short run,
the longest stand for friction that falls steadily."""


def warming(model: Model) -> Iterator[Candidate]:
    """On each joint, viscous friction that falls from the start of a run, with and without dry friction."""
    for joint in range(model.robot.dof):
        for count in (1, 2):
            yield from (_warming(joint, constant, count) for constant in TIMES)


def _warming(joint: int, constant: float, count: int) -> Candidate:
    """Friction of a joint that falls with a time constant [s]: viscous, and with a count of 2 also dry."""

    def columns(run: Driven) -> np.ndarray:
        motion = run.motion
        if np.all(np.isfinite(motion.temperature[:, joint])):
            raise NotRecorded("the temperature was recorded, which tells more")
        cold = np.exp(-(motion.time - motion.time[0]) / constant)
        velocity = motion.velocity[:, joint]
        friction = np.stack([velocity, smooth_sign(velocity)], axis=1)
        return on_joint(run, joint, cold[:, None] * friction[:, :count])

    def reshaped(shape: Mapping[str, float]) -> Candidate:
        return _warming(joint, shape["time"], count)

    names, units = ("Fvw", "Fcw")[:count], ("N m s/rad", "N m")[:count]
    return Candidate(
        WARMING, (joint,), columns, names, units, (0.0,) * count, {"time": constant},
        {"time": Shape("s", 0.5 * TIMES[0], 2.0 * TIMES[-1])}, reshaped, rows=(joint,), prior=RARE,
        listed=False,
    )  # fmt: skip


KINDS = {
    WARMING: Kind(
        sentence="{joint} has friction that falls during a run, as of grease that warms up: viscous friction "
        "by {Fvw}[ and Coulomb friction by {Fcw}][, most of it within {time}]",
        drawn_against=("time", "velocity"),
        ask=warming,
        held=lambda arm, finding: None,
        settled_by="the same run with the motors' temperatures recorded",
    )
}
