"""Finding: one effect that the model lacks, with its parameters and alternatives."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...effects import Effect
from ...quantity import Quantity
from ...result_file import NOT_IN_FILE
from ...schema import EffectName, Probability, Real
from .size import LeftOut, Size


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Hypothesis:
    """One effect on certain joints, with its numbers."""

    effect: EffectName  # name in the vocabulary
    joints: tuple[int, ...]  # where it acts, from 0; empty where it has no joint
    parameters: Mapping[str, Quantity]  # coefficients and shape by name
    probability: Probability  # probability that the missing physics is this effect
    kind: str = ""  # variant that distinguishes it from other hypotheses of its effect, such as "gradual"
    which: str = ""  # variant or shape in words, such as "harmonic 7"
    listed: bool = True  # whether the vocabulary has a name for it
    geared: bool = False  # whether its joint has a gear ratio, so that "per turn" refers to the motor
    ambiguous: bool = False  # whether another effect has exactly the same torque
    # The effect as a model holds it; None where no single effect of a model does.
    term: Effect | None = field(default=None, metadata=NOT_IN_FILE)
    file: str = ""  # file of the model in which this alternative replaces its finding; empty if there is none

    @property
    def numbers(self) -> dict[str, float]:
        """Values of the parameters by name."""
        return {name: quantity.value for name, quantity in self.parameters.items()}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Finding(Hypothesis):
    """An effect that the runs show."""

    # Hypotheses that the data do not exclude, the most probable first.
    alternatives: tuple[Hypothesis, ...] = ()
    # Root mean square of its torque on each joint in the fitted runs, shape (n,) [N m].
    torque_rms: np.ndarray
    # Decrease of twice the negative log likelihood of the held-out runs; NaN without such runs.
    held_out: Real
    alone: bool = False  # whether only one joint shows it, although it acts on the whole arm
    unnamed: bool = False  # whether its joint keeps an unexplained residual that is as large
    size: Size | None = None  # its torque with an interval; None where it was not computed
    # Parameters that the data do not determine, and why.
    left_out: Mapping[str, LeftOut] = field(default_factory=dict)
    family: str = ""  # name of the narrowest family in `FAMILIES` that is certain; empty where none is
    family_probability: Real = float("nan")  # probability of any member of that family; NaN without a family
    proven: bool = True  # whether its effect on fitted blocks and on held-out runs excludes zero

    @property
    def determined(self) -> dict[str, Quantity]:
        """Parameters that the data determine."""
        return {name: quantity for name, quantity in self.parameters.items() if name not in self.left_out}

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """95 % interval of each parameter that the data determine, in its SI unit."""
        return {name: quantity.interval for name, quantity in self.determined.items()}

    def __getitem__(self, name: str) -> Quantity:
        """One parameter.

        Raises:
            KeyError: There is no such parameter; the message lists the existing ones.
        """
        if name not in self.parameters:
            raise KeyError(f"{self.effect} has no parameter '{name}'. It has: {', '.join(self.parameters)}")
        return self.parameters[name]

    def __repr__(self) -> str:
        joints = ", ".join(f"joint {joint + 1}" for joint in self.joints) or "the arm"
        numbers = ", ".join(f"{name} {quantity}" for name, quantity in self.determined.items())
        head = f"Finding {self.effect} of {joints}, {100 * self.probability:.3g} %"
        return f"{head}: {numbers}" if numbers else head
