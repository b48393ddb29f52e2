"""Located: on which joint a model misses torque, what that depends on, and how much of the misfit it is."""

from dataclasses import dataclass

from ...schema import Real


@dataclass(frozen=True)
class Located:
    """One row of the table that comes first.

    Attributes:
        joint: From 0.
        depends_on: A dependence of `DEPENDENCES`, an effect outside of them, or what a remainder depends on.
        share: Of the squared misfit of the joint, held out where there are such runs [-].
        probability: That the torque depends on it; None for noise, for what depends on nothing recorded, and
            where what it explains may be zero.
        finding: Place of the finding that explains it, undecided ones behind the others; None without any.
    """

    joint: int
    depends_on: str
    share: Real
    probability: float | None
    finding: int | None


@dataclass(frozen=True)
class Hinted:
    """What runs held out show and fitted ones do not contradict: to name it, those runs have to be fitted.

    Attributes:
        effect: Name in the vocabulary.
        joint: That runs held out show best, from 0; in files from 1.
        depends_on: As of `Located`.
        gain: Logarithm of how much more probable the fitted blocks are with it.
        gain_held_out: The same of runs held out, predicted by the fitted blocks.
        change: Of the joint's squared residual in runs held out, relative [-]; below zero it is less.
        std: Standard deviation of that over blocks [-].
    """

    effect: str
    joint: int
    depends_on: str
    gain: Real
    gain_held_out: Real
    change: Real
    std: Real
