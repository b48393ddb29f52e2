"""Material: the results that a report is made of, each of them optional."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..fit.fit import Fit
from ..model import Model
from ..simulation.comparison import Comparison
from .shown import Shown


class Run(NamedTuple):
    """The parts of a recorded run that a report shows.

    Attributes:
        name: Name of the run.
        role: Purpose of the run, in words; empty if unknown.
        payload: Payload on the flange, in words; empty if unknown.
        rate: Sampling rate [Hz].
        time: Time of the positions, shape (t,) [s].
        position: Joint positions, shape (t, n) [rad].
        effort_time: Time of the currents or torques, shape (s,) [s].
        effort: Motor currents or joint torques, shape (s, n) [A] or [N m].
        quantity: "current" or "torque".
        warnings: Warnings about the recording, in sentences.
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
    """A fit with its title on the page.

    Attributes:
        title: Title, as plain text.
        fit: The fit, with its predictions of the runs if these were given.
        nominal: The same model with nominal values; None if they are unknown.
        improved: Whether the model contains the findings of a diagnosis.
    """

    title: str
    fit: Fit
    nominal: Fit | None = None
    improved: bool = False


@dataclass(frozen=True, eq=False)
class Material:
    """All results of a report.

    Attributes:
        joints: Names of the joints, which all results share.
        model: The nominal robot; None if unknown.
        runs: Recorded runs.
        fits: Fits in the order in which they were given, improved ones last.
        diagnosis: The diagnosis; None without one.
        comparisons: Comparisons of simulations with recordings.
        files: Content of each file that was read, in words, such as "fit.json" -> "a fit".
    """

    joints: tuple[str, ...]
    model: Model | None
    runs: tuple[Run, ...]
    fits: tuple[Fitted, ...]
    diagnosis: Shown | None
    comparisons: tuple[Comparison, ...]
    files: Mapping[str, str]
