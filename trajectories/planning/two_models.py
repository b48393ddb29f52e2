"""The goal of distinguishing two models of one arm, as robot files hold them."""

from collections.abc import Sequence
from itertools import permutations

from exidyn.identify.arm.robot import Limits
from exidyn.identify.errors import RobotError
from exidyn.identify.model import Model

from ..discrimination.discriminate import Discriminate
from ..discrimination.hypothesis import Hypothesis
from ..discrimination.separation import Observation
from .identification_goal import nominal_noise


def two_models(models: Sequence[Model], names: Sequence[str], limits: Limits, rows: float) -> Discriminate:
    """The goal.

    Args:
        models: Each with one explanation and the values of its effects; the first gives the noise.
        names: What people call them.
        limits: Within which the arm moves.
        rows: Independent rows of the run.

    Raises:
        RobotError: What one model has beyond the other has no values, and so explains nothing.
    """
    hypotheses = tuple(Hypothesis.of_priors(name, one) for name, one in zip(names, models, strict=True))
    for hypothesis, other in permutations(hypotheses):
        _require_values(hypothesis, other)
    return Discriminate(hypotheses, Observation(nominal_noise(models[0], limits), rows))


def _require_values(one: Hypothesis, other: Hypothesis) -> None:
    known = set(other.model.names)
    own = {n: v for n, v in zip(one.model.names, one.values, strict=True) if n not in known}
    if own and not any(own.values()):
        raise RobotError(
            f"{one.name}: {', '.join(own)} have no values, so it is the same as {other.name}. Give its "
            "effects the values that a fit found: values = [...] in their [[effect]] rows"
        )
