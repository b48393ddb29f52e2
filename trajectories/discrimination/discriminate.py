r"""Discriminate: the goal of distinguishing models that all explain the data so far (T-optimality).

In every ordered pair one hypothesis is true and the other is its rival; the goal is to maximize the smallest
separation of all pairs (see `separation`). Its gradient needs no derivative of the rival's parameters, since
these are at a minimum (envelope theorem): with the residual e at the minimum,
:math:`dT = 2 e^T (d\tau_A - d\tau_B)`. The gradient therefore takes one pass of each model over the motion,
regardless of the number of pairs.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import permutations

import numpy as np
from scipy.special import logsumexp

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import MotionGradient
from exidyn.identification.model import Model

from ..errors import NotComparable
from ..search.experiment import design_model, loaded_runs, whitening
from ..search.goals import Goal, Objective
from .separation import Explanation, Hypothesis, Observation, explain, probability

FLOOR = 1e-6
"""Separation added to each pair, so that its logarithm exists: a negligible probability of 50.02 %."""
POWER = 8.0
"""Exponent of the smooth minimum of the separations: within ten percent of the minimum for two equal ones."""

Pair = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Discriminate(Goal):
    """The goal to distinguish hypotheses."""

    # Two or more hypotheses on one arm, given the data so far; the first one's torque is compared with the
    # torque limits.
    hypotheses: tuple[Hypothesis, ...]
    observation: Observation  # how precisely torque is observed
    # Separation from the data so far, shape (h, h), with the true hypothesis in the row and its rival in the
    # column; zero by default.
    earlier: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))

    def __post_init__(self) -> None:
        count = len(self.hypotheses)
        names = [hypothesis.name for hypothesis in self.hypotheses]
        joints = {hypothesis.model.robot.joints for hypothesis in self.hypotheses}
        if count < 2 or len(set(names)) < count or len(joints) > 1:
            raise NotComparable(
                f"hypotheses {', '.join(names) or 'none'} on {len(joints)} kinds of arm; "
                "there must be two or more with unique names, on one arm"
            )
        if self.observation.noise.shape != (self.model.robot.dof,) or not np.all(self.observation.noise > 0):
            raise NotComparable(
                f"noise {self.observation.noise}: expected one number above 0 per drive [N m]"
            )
        if self.earlier.size == 0:
            object.__setattr__(self, "earlier", np.zeros((count, count)))
        if self.earlier.shape != (count, count):
            raise NotComparable(
                f"earlier separations of shape {self.earlier.shape}; expected ({count}, {count}), "
                "one for each pair of hypotheses"
            )

    @property
    def model(self) -> Model:
        return self.hypotheses[0].model

    @property
    def payloads(self) -> Sequence[str]:
        return self.observation.payloads

    def objectives(self, limits: Limits, spacing: float) -> Sequence[Objective]:
        def smooth(model: Model) -> Model:
            return design_model(model, limits, spacing)

        goal = replace(self, hypotheses=tuple(hypothesis.changed(smooth) for hypothesis in self.hypotheses))
        return [Separate(goal, POWER), Separate(goal)]

    def reached(self, value: float) -> float:
        return probability(np.exp(-value) - FLOOR)

    def words(self, value: float) -> str:
        return f"probability of choosing right {100 * self.reached(value):.3g} %"

    def explanations(self, motion: Motion) -> dict[Pair, Explanation]:
        """How each rival explains a run in which another hypothesis is true, by the indices of both."""
        seen = [self.observation.seen(hypothesis, motion) for hypothesis in self.hypotheses]
        share = self.observation.rows / len(motion)
        return {
            (true, rival): explain(self.hypotheses[rival], seen[rival], seen[true].torque, share)
            for true, rival in permutations(range(len(seen)), 2)
        }


@dataclass(frozen=True, eq=False)
class Separate(Objective):
    """Objective: minus the logarithm of the smallest separation, including that from earlier data."""

    goal: Discriminate  # goal with the hypotheses that the optimizer uses
    power: float = np.inf  # exponent of the smooth minimum; infinite for the minimum itself

    def __call__(self, motion: Motion) -> tuple[float, Callable[[], MotionGradient]]:
        explanations = self.goal.explanations(motion)
        value, by = self._smallest(explanations)

        def gradient() -> MotionGradient:
            pulls = [
                self._pull(place, motion, explanations, by) for place in range(len(self.goal.hypotheses))
            ]
            return sum(pulls, MotionGradient.none(motion.position.shape))

        return value, gradient

    def _smallest(self, explanations: dict[Pair, Explanation]) -> tuple[float, dict[Pair, float]]:
        """The objective, and its derivative by the separation of each pair."""
        total = np.array(
            [
                self.goal.earlier[pair] + explanation.separation + FLOOR
                for pair, explanation in explanations.items()
            ]
        )
        logarithms = -np.log(total)
        if np.isinf(self.power):
            value, share = float(logarithms.max()), np.eye(len(total))[int(np.argmax(logarithms))]
        else:
            value = float(logsumexp(self.power * logarithms)) / self.power
            share = np.exp(self.power * (logarithms - value))
        return value, dict(zip(explanations, -share / total, strict=True))

    def _pull(
        self, place: int, motion: Motion, explanations: dict[Pair, Explanation], by: dict[Pair, float]
    ) -> MotionGradient:
        """Gradient through the torque of one hypothesis, both as the true one and as the rival."""
        observation, model = self.goal.observation, self.goal.hypotheses[place].model
        share, white = 2.0 * observation.rows / len(motion), whitening(model, observation.noise)
        weights, known = 0.0, 0.0
        for (true, rival), explanation in explanations.items():
            if place not in (true, rival) or by[true, rival] == 0.0:
                continue
            sign = 1.0 if place == true else -1.0
            values = self.goal.hypotheses[true].values if place == true else explanation.hypothesis.values
            pull = sign * share * by[true, rival] * explanation.residual @ white
            weights, known = weights + pull[:, :, None] * values, known + pull
        total = MotionGradient.none(motion.position.shape)
        if np.ndim(known) == 0:
            return total
        runs = loaded_runs(model, motion, observation.payloads)
        parts = zip(runs, np.split(weights, len(runs)), np.split(known, len(runs)), strict=True)
        for run, run_weights, run_known in parts:
            total = total + model.motion_gradient(run, run_weights, run_known)
        return total
