"""Quantity: a physical value with its standard deviation and unit."""

from dataclasses import dataclass

from .schema import Real
from .text_table import NORMAL_95, raised


@dataclass(frozen=True, repr=False)
class Quantity:
    """A physical value, its standard deviation (NaN if the data do not determine it), and its unit.

    Example:
        >>> Quantity(2.0, 0.1, "N m").interval
        (1.804, 2.196)
    """

    value: Real
    std: Real
    unit: str

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval, in the same unit."""
        half = NORMAL_95 * self.std
        return self.value - half, self.value + half

    def __repr__(self) -> str:
        return raised(f"{self.value:.4g} ± {NORMAL_95 * self.std:.2g} {self.unit}").rstrip()
