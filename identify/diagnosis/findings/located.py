"""Located: residual of each joint by the quantity on which it depends."""

from dataclasses import dataclass

from ...schema import Real


@dataclass(frozen=True)
class Located:
    """One row of the table of residuals by quantity.

    Attributes:
        joint: Index of the joint, from 0.
        depends_on: A key of `DEPENDENCES`, an effect without a family, or the dependence of a remainder.
        share: Share of the squared baseline residual of the joint, in held-out runs if there are any [-].
        probability: Probability that the torque depends on the quantity; None for noise, for parts without a
            dependence, and if the explained part may be zero.
        finding: Index of the finding that explains it, undecided ones behind the others; None without any.
    """

    joint: int
    depends_on: str
    share: Real
    probability: float | None
    finding: int | None


@dataclass(frozen=True)
class Hinted:
    """An effect that held-out runs show and fitted runs do not contradict; naming it requires fitting them.

    Attributes:
        effect: Name in the vocabulary.
        joint: Index of the joint that shows it best in the held-out runs, from 0; in files from 1.
        depends_on: Quantity on which it depends; see `Located`.
        gain: Log likelihood ratio of the fitted blocks with and without it.
        gain_held_out: Log likelihood ratio of the held-out runs, predicted by the fitted blocks.
        change: Relative change of the joint's squared residual in the held-out runs [-]; negative is better.
        std: Standard deviation of that change over blocks [-].
    """

    effect: str
    joint: int
    depends_on: str
    gain: Real
    gain_held_out: Real
    change: Real
    std: Real
