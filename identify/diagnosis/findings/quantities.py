"""Quantities of a finding, by name with standard deviations and units, and their format in sentences."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ...quantity import Quantity
from ...text_table import NORMAL_95, digits, raised
from ..questions.block_answer import Answer
from ..questions.candidate import UNNAMED, Candidate
from .finding import Finding, Hypothesis

TURNING: Literal["N m"] = "N m"
SLIDING: Literal["N"] = "N"
AMPERE: Literal["A"] = "A"
"""Units of the torque or force of a joint."""
SCALES: dict[str, tuple[float, str]] = {
    "%": (100.0, "%"),
    "deg": (180.0 / np.pi, "°"),
    "mm": (1e3, "mm"),
    "mrad": (1e3, "mrad"),
    "ms": (1e3, "ms"),
}
"""Factor from the SI unit and symbol of each readable unit, by the name used in formats."""


ROUNDING = 1e-6
"""Rounding error of a solution, relative to its standard deviation [-]."""
FINEST = 6
"""Largest number of decimal places; smaller values are written with powers of ten."""


@dataclass(frozen=True, repr=False)
class Formatted(Quantity):
    """A quantity with formats for sentences.

    An empty format gives value, interval and unit; a name in `SCALES` selects another unit; `bare` omits the
    unit; `size` in front omits the sign. Two words separated by `|` stand for values above zero and others.
    """

    def __format__(self, spec: str) -> str:
        if "|" in spec:
            return spec.split("|")[0 if self.value > 0 else 1]
        words = spec.split()
        value = abs(self.value) if "size" in words else self.value
        scale, unit = next((SCALES[word] for word in words if word in SCALES), (1.0, self.unit))
        unit = "mm" if (unit, self.unit) == ("mrad", "m") else unit  # for a prismatic joint
        text = with_interval(scale * value, scale * self.std)
        return text if "bare" in words or unit in ("", "1") else raised(f"{text} {unit}").replace(" °", "°")


def with_interval(value: float, std: float) -> str:
    """A value ± half of its 95 % interval, both rounded to the significant digits of the interval."""
    half = NORMAL_95 * std
    if not (np.isfinite(half) and half > 0.0):
        return f"{value:.3g}" if abs(value) < 1e3 else digits(value, 3)
    # Two digits if the first is 1: 0.12 rounded to 0.1 would be off by a fifth.
    size = int(np.floor(np.log10(half)))
    places = (1 if half / 10.0**size < 2.0 else 0) - size
    if places > FINEST:
        return f"{digits(value, 2)} ± {digits(half, 1)}"
    # A value has at most four digits, however small its interval.
    places = min(places, 3 - int(np.floor(np.log10(abs(value) or half))))
    half = max(round(half, places), 10.0**-places)
    # Adding zero avoids "-0".
    return f"{round(value, places) + 0.0:.{max(places, 0)}f} ± {half:.{max(places, 0)}f}"


def formatted(finding: Finding) -> dict[str, Any]:
    """Parameters of a finding by name, and by name without the joint number at its end."""
    parameters = {name: Formatted(q.value, q.std, q.unit) for name, q in finding.parameters.items()}
    plain = {_plain(name): quantity for name, quantity in reversed(parameters.items())}
    return plain | parameters


def length(quantities: Mapping[str, Quantity], *names: str) -> Formatted:
    """Euclidean norm of the named quantities, with its standard deviation."""
    parts = [quantities[name] for name in names]
    size = float(np.sqrt(sum(part.value**2 for part in parts)))
    variance = sum((part.value * part.std) ** 2 for part in parts) / max(size, 1e-300) ** 2
    return Formatted(size, float(np.sqrt(variance)), parts[0].unit)


def together(known: Mapping[str, Quantity], dry: str, viscous: str) -> Formatted:
    """Sum of dry and viscous friction at 1 rad/s."""
    parts = [known[name] for name in (dry, viscous) if name in known]
    std = float(np.linalg.norm([part.std for part in parts]))
    return Formatted(sum(part.value for part in parts), std, known[dry].unit)


def _plain(name: str) -> str:
    """Name up to its first digit: Rcos for Rcos2_3."""
    cut = next((place for place, letter in enumerate(name) if letter.isdigit()), len(name))
    return name[:cut].rstrip("_") or name


def quantities(
    candidate: Candidate, values: np.ndarray, std: np.ndarray, shape: Mapping[str, float]
) -> dict[str, Quantity]:
    """Reported quantities of a finding: coefficients, shape, and results derived from the shape.

    Args:
        candidate: Candidate of the finding.
        values: Coefficients, shape (p,).
        std: Standard deviations of the coefficients, shape (p,).
        shape: Standard deviations of the numbers of the shape and of derived results, by name.
    """
    # A value at its limit differs from it only by rounding.
    within = np.where(
        np.abs(values - candidate.lower) < ROUNDING * std.max(initial=0.0), candidate.lower, values
    )
    numbers = {
        name: Quantity(float(value), float(deviation), unit)
        for name, value, deviation, unit in zip(
            candidate.names, *candidate.reported_as(within, std), candidate.units, strict=True
        )
        if not name.startswith(UNNAMED)
    }
    shape = {**shape, **candidate.known}
    units = {name: bounds.unit for name, bounds in candidate.bounds.items()}
    shape_values = {name: (value, units.get(name, "1")) for name, value in candidate.shape.items()}
    more = {
        name: Quantity(value, shape.get(name, float("nan")), unit)
        for name, (value, unit) in (shape_values | dict(candidate.reported)).items()
    }
    return numbers | more


def stated(candidate: Candidate) -> dict[str, Any]:
    """Fields of a hypothesis that its candidate determines, apart from numbers."""
    return {
        "effect": candidate.effect,
        "joints": candidate.joints,
        "kind": candidate.kind,
        "which": candidate.which,
        "listed": candidate.listed,
        "geared": candidate.gear_ratio != 1.0,
        "ambiguous": candidate.same_torque is not None,
        "term": candidate.instance,
    }


def alternative(answer: Answer, probability: float) -> Hypothesis:
    """An alternative of a finding, with its fitted values."""
    candidate, unknown = answer.candidate, float("nan")
    shape = {name: Quantity(value, unknown, "") for name, value in candidate.shape.items()}
    numbers = zip(candidate.names, answer.values, candidate.units, strict=True)
    coefficients = {name: Quantity(float(value), unknown, unit) for name, value, unit in numbers}
    return Hypothesis(**stated(candidate), parameters=shape | coefficients, probability=probability)
