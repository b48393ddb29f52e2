r"""Discriminate: the goal of distinguishing models that all explain the data so far (T-optimality).

Of every ordered pair one is true and the other its rival; the goal is the smallest separation of them all
(see `separation`). Its gradient needs no derivative of the rival's parameters, since these are at a
minimum (envelope theorem): with the residual e at the minimum, :math:`dT = 2 e^T (d\tau_A - d\tau_B)`.
Gradients are therefore one pass of each model over the motion, whatever the number of pairs.
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
from ..search.experiment import loaded_runs, whitening
from ..search.goals import Objective
from ..search.torque_spread import TorqueSpread
from ..search.unknowns import design_model
from .separation import Explanation, Hypothesis, Observation, explain, probability

FLOOR = 1e-6
"""Separation that is added to each, so that it has a logarithm: it is a probability of 50.02 per cent,
as good as none."""
POWER = 8.0
"""Of the sum of inverse separations that stands for the smallest where several are near it: within ten per
cent for two."""

Pair = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Discriminate:
    """To distinguish hypotheses.

    Attributes:
        hypotheses: Two or more of one arm, as the data so far leave them; the first is used where one
            torque must be, for the limits.
        observation: How well torque is seen.
        earlier: Separation that the data so far give, shape (h, h): row is true, column its rival; zero
            unless given.
        spread: What is not known of the torque, for its limits.
    """

    hypotheses: tuple[Hypothesis, ...]
    observation: Observation
    earlier: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    spread: TorqueSpread | None = None

    def __post_init__(self) -> None:
        count = len(self.hypotheses)
        names = [one.name for one in self.hypotheses]
        joints = {one.model.robot.joints for one in self.hypotheses}
        if count < 2 or len(set(names)) < count or len(joints) > 1:
            raise NotComparable(
                f"hypotheses {', '.join(names) or 'none'} on {len(joints)} kinds of arm; "
                "there must be two or more, each with a name of its own, on one arm"
            )
        if self.observation.noise.shape != (self.model.robot.dof,) or not np.all(self.observation.noise > 0):
            raise NotComparable(f"noise {self.observation.noise}: expected one number above 0 a drive [N m]")
        if self.earlier.size == 0:
            object.__setattr__(self, "earlier", np.zeros((count, count)))
        if self.earlier.shape != (count, count):
            raise NotComparable(f"earlier separations {self.earlier.shape} of {count} hypotheses")

    @property
    def model(self) -> Model:
        """The nominal arm."""
        return self.hypotheses[0].model

    @property
    def payloads(self) -> Sequence[str]:
        """Body carried in each run."""
        return self.observation.payloads

    def with_spread(self, spread: TorqueSpread | None) -> "Discriminate":
        return replace(self, spread=spread)

    def objectives(self, limits: Limits, spacing: float) -> Sequence[Objective]:
        def smooth(model: Model) -> Model:
            return design_model(model, limits, spacing)

        goal = replace(self, hypotheses=tuple(one.changed(smooth) for one in self.hypotheses))
        return [Separate(goal, POWER), Separate(goal)]

    def reached(self, value: float) -> float:
        return probability(np.exp(-value) - FLOOR)

    def words(self, value: float) -> str:
        return f"probability of choosing right {100 * self.reached(value):.3g} %"

    def explanations(self, motion: Motion) -> dict[Pair, Explanation]:
        """How every rival explains a run in which another is true; places in `hypotheses` of both."""
        seen = [self.observation.seen(one, motion) for one in self.hypotheses]
        share = self.observation.rows / len(motion)
        return {
            (true, rival): explain(self.hypotheses[rival], seen[rival], seen[true].torque, share)
            for true, rival in permutations(range(len(seen)), 2)
        }


@dataclass(frozen=True, eq=False)
class Separate(Objective):
    """Objective: minus the logarithm of the smallest separation, earlier data's included.

    Attributes:
        goal: Hypotheses as the optimiser sees them.
        power: Exponent of the smooth stand-in for the smallest; infinite for the smallest itself.
    """

    goal: Discriminate
    power: float = np.inf

    def __call__(self, motion: Motion) -> tuple[float, Callable[[], MotionGradient]]:
        found = self.goal.explanations(motion)
        value, by = self._smallest(found)

        def gradient() -> MotionGradient:
            pulls = [self._pull(place, motion, found, by) for place in range(len(self.goal.hypotheses))]
            return sum(pulls, MotionGradient.none(motion.position.shape))

        return value, gradient

    def _smallest(self, found: dict[Pair, Explanation]) -> tuple[float, dict[Pair, float]]:
        """Value, and its derivative by the separation of each pair."""
        total = np.array([self.goal.earlier[pair] + one.separation + FLOOR for pair, one in found.items()])
        logarithms = -np.log(total)
        if np.isinf(self.power):
            value, share = float(logarithms.max()), np.eye(len(total))[int(np.argmax(logarithms))]
        else:
            value = float(logsumexp(self.power * logarithms)) / self.power
            share = np.exp(self.power * (logarithms - value))
        return value, dict(zip(found, -share / total, strict=True))

    def _pull(
        self, place: int, motion: Motion, found: dict[Pair, Explanation], by: dict[Pair, float]
    ) -> MotionGradient:
        """What one hypothesis' torque gains, where it is true and where it is the rival."""
        observation, model = self.goal.observation, self.goal.hypotheses[place].model
        share, white = 2.0 * observation.rows / len(motion), whitening(model, observation.noise)
        weights, known = 0.0, 0.0
        for (true, rival), one in found.items():
            if place not in (true, rival) or by[true, rival] == 0.0:
                continue
            sign = 1.0 if place == true else -1.0
            values = self.goal.hypotheses[true].values if place == true else one.hypothesis.values
            pull = sign * share * by[true, rival] * one.residual @ white
            weights, known = weights + pull[:, :, None] * values, known + pull
        total = MotionGradient.none(motion.position.shape)
        if np.ndim(known) == 0:
            return total
        runs = loaded_runs(model, motion, observation.payloads)
        parts = zip(runs, np.split(weights, len(runs)), np.split(known, len(runs)), strict=True)
        for run, run_weights, run_known in parts:
            total = total + model.motion_gradient(run, run_weights, run_known)
        return total
