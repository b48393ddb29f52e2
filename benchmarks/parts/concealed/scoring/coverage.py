"""Coverage: how often 95 % intervals of diagnosed numbers contain the truth.

The plant has its own formulas. Only numbers with one meaning count: masses, shares, times, angles, and
coefficients of laws that both have.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from exidyn.identification.text_table import NORMAL_95

from .answers import Guess

Parameters = Mapping[str, Any]


class Number(NamedTuple):
    """One diagnosed number beside its truth."""

    effect: str  # Name in the vocabulary
    name: str  # Of the number, without that of its joint
    true: float  # Its true value
    value: float  # As diagnosed
    std: float  # Its standard deviation

    @property
    def held(self) -> bool:
        """Whether its 95 % interval contains the truth."""
        return bool(abs(self.value - self.true) <= NORMAL_95 * self.std)


def _tilt(truth: Parameters) -> dict[str, float]:
    angle, heading = np.deg2rad(truth["degrees"]), truth["heading"]
    return {"tilt_x": np.sin(angle) * np.cos(heading), "tilt_y": np.sin(angle) * np.sin(heading)}


def _rotor(truth: Parameters) -> dict[str, float]:
    """Only that of a rotor which the model lacks is known beside the model's."""
    return {"Ia": truth["Ia"]} if truth["missing"] else {}


SAME: Mapping[str, Callable[[Parameters], Mapping[str, float]]] = {
    "payload": lambda truth: {"M": truth["mass"]},
    "link_inertia": lambda truth: {"M": truth["mass"]},
    "rotor_inertia": _rotor,
    "base_tilt": _tilt,
    "viscous_friction": lambda truth: {"Fv": truth["Fv"]},
    "coulomb_friction": lambda truth: {"Fc": truth["Fc"]},
    "load_dependent_friction": lambda truth: {"mu": truth["mu"]},
    "nonlinear_viscous_friction": lambda truth: {"Fn": truth["coefficient"], "exponent": truth["power"]},
    "drive_gain": lambda truth: {"share": truth["error"]},
    "current_offset": lambda truth: {"Off": -truth["offset"]},  # torque beside the current's: so much less
    "backlash": lambda truth: {"gap": truth["gap"]},
    "encoder_offset": lambda truth: {"zero": truth["radians"]},
    "time_delay": lambda truth: {"delay": truth["seconds"]},
}
"""Effect -> its numbers by the truth, in the names and signs of the diagnosis."""


def numbers(
    truth: Guess, parameters: Parameters, stated: Mapping[str, Sequence[float | None]]
) -> list[Number]:
    """Numbers of a finding that is right about an effect, by the parameters of the truth.

    Args:
        truth: The effect that is concealed.
        parameters: Its parameters.
        stated: The finding's numbers -> value and standard deviation.
    """
    known = truth.effect in SAME and bool(parameters)  # older truths have no numbers
    true = SAME[truth.effect](parameters) if known else {}
    endings = {str(joint) for joint in truth.joints} | {""}
    pairs = []
    for name, value in true.items():
        pair = next((stated[name + ending] for ending in endings if name + ending in stated), None)
        if pair is not None and None not in pair:
            pairs.append(Number(truth.effect, name, float(value), *map(float, pair)))  # type: ignore[arg-type]
    return pairs


def interval_coverage(every: Sequence[Number]) -> float:
    """Share of 95 % intervals that contain the truth [%]; NaN of none."""
    return 100.0 * float(np.mean([one.held for one in every])) if every else float("nan")


def coverage_rows(every: Iterable[Number]) -> list[list[Any]]:
    """One row a number of an effect: count, contained [%], median error and half interval [%], error/std."""
    groups: dict[tuple[str, str], list[Number]] = {}
    for one in every:
        groups.setdefault((one.effect, one.name), []).append(one)
    rows = []
    for (effect, name), own in sorted(groups.items()):
        apart = np.array([one.value - one.true for one in own])
        std, true = np.array([one.std for one in own]), np.abs([one.true for one in own])
        error, half = (100.0 * float(np.median(x / true)) for x in (np.abs(apart), NORMAL_95 * std))
        deviations = float(np.sqrt(np.mean((apart / std) ** 2)))
        rows.append([effect, name, len(own), interval_coverage(own), error, half, deviations])
    return rows
