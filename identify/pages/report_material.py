"""Material: what a report of several results can be made of; whatever there is."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..fit.fit import Fit
from ..model import Model
from ..simulation.comparison import Comparison
from .shown import Shown


class Run(NamedTuple):
    """One recorded run, as far as it is drawn and listed.

    Attributes:
        name: Name of the run.
        role: What it was for, in words; empty if unknown.
        payload: What hung on the flange, in words; empty if that is not known.
        rate: Samples a second [Hz].
        time: When positions were recorded, shape (t,) [s].
        position: Shape (t, n) [rad].
        effort_time: When currents or torques were recorded, shape (s,) [s].
        effort: Shape (s, n) [A] or [N m].
        quantity: "current" or "torque".
        warnings: About the recording, in sentences.
    """

    name: str
    role: str
    payload: str
    rate: float
    time: np.ndarray
    position: np.ndarray
    effort_time: np.ndarray
    effort: np.ndarray
    quantity: str
    warnings: tuple[str, ...] = ()


class Fitted(NamedTuple):
    """A fit and what it is called on the page.

    Attributes:
        title: Plain text.
        fit: With what it predicts of the runs, if they are at hand.
        nominal: The model with its nominal values, from before the data; None where they are not known.
        improved: Whether its model has what a diagnosis found.
    """

    title: str
    fit: Fit
    nominal: Fit | None = None
    improved: bool = False


@dataclass(frozen=True, eq=False)
class Material:
    """What there is.

    Attributes:
        joints: Names, the same in all that follows.
        model: The nominal robot; None if unknown.
        runs: That were recorded.
        fits: In the order in which they were given, improved ones last.
        diagnosis: What the model leaves out; None if that was not asked.
        comparisons: For example before and after.
        files: What was read for the page, in words, such as "fit.json" -> "a fit".
    """

    joints: tuple[str, ...]
    model: Model | None
    runs: tuple[Run, ...]
    fits: tuple[Fitted, ...]
    diagnosis: Shown | None
    comparisons: tuple[Comparison, ...]
    files: Mapping[str, str]
