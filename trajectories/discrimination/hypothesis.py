"""Hypothesis: a model that may be the true one, and what is known of its parameters."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from exidyn.identify.model import Model

from ..errors import NotComparable


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A model that may be the true one.

    Attributes:
        name: What people call it.
        model: Robot and effects.
        values: What its parameters are if it is true, in the order of `Model.names`, shape (p,).
        precision: How firmly they are held, by priors and data so far: inverse of their covariance, shape
            (p, p). A zero row and column is a free parameter, an infinite diagonal entry a fixed one.
    """

    name: str
    model: Model
    values: np.ndarray
    precision: np.ndarray

    def __post_init__(self) -> None:
        count = len(self.model.names)
        if self.values.shape != (count,) or self.precision.shape != (count, count):
            raise NotComparable(
                f"hypothesis {self.name}: values {self.values.shape} and precision {self.precision.shape} "
                f"for the {count} parameters of its model"
            )
        if not np.all(np.isfinite(self.values)) or np.any(np.isnan(self.precision)):
            raise NotComparable(f"hypothesis {self.name}: values or precision hold NaN")

    @classmethod
    def of_priors(
        cls,
        name: str,
        model: Model,
        values: Mapping[str, float] | None = None,
        deviations: Mapping[str, float] | None = None,
    ) -> "Hypothesis":
        """The model's priors, of which none is about two parameters at once.

        Args:
            name: What people call it.
            model: Robot and effects.
            values: Of parameters by name, where they are not nominal.
            deviations: Standard deviation likewise; zero fixes a parameter, infinity frees it.

        Raises:
            NotComparable: A parameter that the model does not have.
        """
        given, spread = dict(values or {}), dict(deviations or {})
        if unknown := sorted({*given, *spread} - set(model.names)):
            raise NotComparable(
                f"hypothesis {name}: no parameter '{unknown[0]}'. Valid: {', '.join(model.names)}"
            )
        centre = [given.get(n, b.value) for n, b in zip(model.names, model.priors, strict=True)]
        deviation = [spread.get(n, b.std) for n, b in zip(model.names, model.priors, strict=True)]
        with np.errstate(divide="ignore"):
            return cls(name, model, np.array(centre), np.diag(np.array(deviation, float) ** -2.0))

    @property
    def free(self) -> np.ndarray:
        """Which parameters are not fixed, shape (p,), bool."""
        return np.isfinite(np.diag(self.precision))

    def changed(self, change: Callable[[Model], Model]) -> "Hypothesis":
        """The same under a changed model of the same parameters."""
        return replace(self, model=everywhere(self.model, change))


def everywhere(model: Model, change: Callable[[Model], Model]) -> Model:
    """The model changed, and likewise what its effects carry of it, as a drive gain's error does."""
    effects = []
    for effect in model.effects:
        inner = {f.name: getattr(effect, f.name) for f in fields(effect)}
        carried = {name: everywhere(one, change) for name, one in inner.items() if isinstance(one, Model)}
        effects.append(replace(effect, **carried))
    return change(replace(model, effects=tuple(effects)))
