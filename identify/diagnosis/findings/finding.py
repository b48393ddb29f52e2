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
    """One effect on certain joints, with its numbers.

    Attributes:
        effect: Name in the vocabulary.
        joints: Where it acts, from 0; empty where it has no joint.
        parameters: Coefficients and shape by name.
        probability: Probability that the missing physics is this effect.
        kind: Variant that distinguishes it from other hypotheses of its effect, such as "gradual".
        which: Variant or shape in words, such as "harmonic 7".
        listed: Whether the vocabulary has a name for it.
        geared: Whether its joint has a gear ratio, so that "per turn" refers to the motor.
        ambiguous: Whether another effect has exactly the same torque.
        term: The effect as a model holds it; None where no single effect of a model does.
        file: File of the model in which this alternative replaces its finding; empty if there is none.
    """

    effect: EffectName
    joints: tuple[int, ...]
    parameters: Mapping[str, Quantity]
    probability: Probability
    kind: str = ""
    which: str = ""
    listed: bool = True
    geared: bool = False
    ambiguous: bool = False
    term: Effect | None = field(default=None, metadata=NOT_IN_FILE)
    file: str = ""

    @property
    def numbers(self) -> dict[str, float]:
        """Values of the parameters by name."""
        return {name: quantity.value for name, quantity in self.parameters.items()}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Finding(Hypothesis):
    """An effect that the runs show.

    Attributes:
        alternatives: Hypotheses that the data do not exclude, the most probable first.
        torque_rms: Root mean square of its torque on each joint in the fitted runs, shape (n,) [N m].
        held_out: Decrease of twice the negative log likelihood of the held-out runs; NaN without such runs.
        alone: Whether only one joint shows it, although it acts on the whole arm.
        unnamed: Whether its joint keeps an unexplained residual that is as large.
        size: Its torque with an interval; None where it was not computed.
        left_out: Parameters that the data do not determine, and why.
        family: Name of the narrowest family in `FAMILIES` that is certain; empty where none is.
        family_probability: Probability of any member of that family; NaN without a family.
        proven: Whether its effect on fitted blocks and on held-out runs excludes zero.
    """

    alternatives: tuple[Hypothesis, ...] = ()
    torque_rms: np.ndarray
    held_out: Real
    alone: bool = False
    unnamed: bool = False
    size: Size | None = None
    left_out: Mapping[str, LeftOut] = field(default_factory=dict)
    family: str = ""
    family_probability: Real = float("nan")
    proven: bool = True

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
