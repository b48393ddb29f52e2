"""Cross-talk: a current sensor that also reads another joint's current."""

from collections.abc import Iterator

import numpy as np

from ...model import Model
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .parts.rare import by_another


def crosstalks(model: Model) -> Iterator[Candidate]:
    """Each sensor with each other joint."""

    def torque(run: Driven, joint: int, other: int) -> np.ndarray:
        return run.torque[:, other]

    yield from by_another(model, "current_crosstalk", torque, ("leak",))


KIND = Kind(
    sentence="{joint} reads {leak:size %} of the current of joint {other_joint:bare} as well",
    drawn_against=("time", "torque"),
    ask=crosstalks,
)
