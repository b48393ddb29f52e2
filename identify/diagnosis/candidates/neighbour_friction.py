"""Neighbour friction: dry friction that depends on the position of another joint that bends a bearing."""

from collections.abc import Iterator

import numpy as np

from ...effects.smooth_sign import smooth_sign
from ...model import Model
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .parts.rare import by_another

SIGN = 0.003
"""Speed within which dry friction reverses [rad/s]."""


def neighbours(model: Model) -> Iterator[Candidate]:
    """Each joint with each other joint."""

    def torque(run: Driven, joint: int, other: int) -> np.ndarray:
        sign, q = smooth_sign(run.motion.velocity[:, joint], SIGN), run.motion.position[:, other]
        return np.stack([sign * np.cos(q), sign * np.sin(q)], axis=1)

    yield from by_another(model, "neighbour_friction", torque, ("Ncos", "Nsin"))


KIND = Kind(
    sentence="{joint} has friction that depends on the position of joint {other_joint:bare}",
    drawn_against=("time", "velocity"),
    ask=neighbours,
)
