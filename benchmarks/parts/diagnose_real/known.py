"""What the real recordings are known to have, how that is known, and what their sources exclude."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from exidyn.identification.diagnosis.findings.finding import Finding
from exidyn.identification.effects import (
    Effect,
    FrictionAsymmetry,
    JointEffect,
    LoadDependentFriction,
    NonlinearViscousFriction,
    TorqueRipple,
)

Range = tuple[float, float]


@dataclass(frozen=True)
class Known:
    """One effect that a set is known to have."""

    effect: str  # Name in the vocabulary
    joints: tuple[int, ...]  # Where, from 0
    how: str  # It is known
    size: str  # In words
    sizes: Mapping[str, Range] = field(default_factory=dict)  # Number -> lowest and highest known value
    # Number of a finding -> where it has to be for the finding to be this effect
    shape: Mapping[str, Range] = field(default_factory=dict)
    first: bool = False  # Whether the first finding of that effect has to be this one
    # Whether it is a miss where it is not named. A name of any other is right, and its absence is no miss: it
    # is small, or shown by one method only.
    expected: bool = True
    # Of a joint's name, the effect by which a plain fit shows it; None where it is shown otherwise
    term: Callable[[str], Effect] | None = None

    def is_in(self, findings: Sequence[Finding]) -> Finding | None:
        """The finding that is this effect."""
        alike = [one for one in findings if (one.effect, one.joints) == (self.effect, self.joints)]
        fitting = [one for one in alike[: 1 if self.first else None] if inside(one, self.shape, 0.0)]
        return fitting[0] if fitting else None

    def right(self, one: Finding) -> bool | None:
        """Whether its known numbers are within two standard deviations of the finding's; None without any."""
        return inside(one, self.sizes, 2.0) if self.sizes else None


def inside(one: Finding, ranges: Mapping[str, Range], deviations: float) -> bool:
    """Whether numbers of a finding, within so many standard deviations, are where they have to be."""
    found = numbers(one)
    spare = {name: deviations * np.nan_to_num(found[name][1]) for name in ranges if name in found}
    return set(spare) == set(ranges) and all(
        low - spare[name] <= found[name][0] <= high + spare[name] for name, (low, high) in ranges.items()
    )


def numbers(one: Finding) -> dict[str, tuple[float, float]]:
    """Value and standard deviation of a finding's numbers, and of those that follow from them.

    A ripple is its strongest harmonic, with two coefficients and one amplitude; of an elastic gear that
    explains more than the whole of its torque, the stiffness is that much smaller.
    """
    found = {name: (float(q.value), float(q.std)) for name, q in one.parameters.items()}
    if one.effect == "torque_ripple":
        cosines = {float(name[4:].split("_")[0]): name for name in found if name.startswith("Rcos")}
        waves = {n: np.array([found[name], found[f"Rsin{name[4:]}"]]) for n, name in cosines.items()}
        order = max(waves, key=lambda n: float(np.hypot(*waves[n][:, 0])))
        found["amplitude"] = float(np.hypot(*waves[order][:, 0])), float(waves[order][:, 1].max())
        found.setdefault("harmonic", (order, float("nan")))
    if one.effect == "kinematic_coupling":  # fields of either joint, which is the same where the ratio is 1
        found |= {f"{name[:2]} of both": pair for name, pair in found.items() if "_" in name}
    if {"stiffness", "share"} <= set(found):
        (stiffness, off), (share, also) = found["stiffness"], found["share"]
        value = stiffness / share
        found["gear stiffness"] = value, abs(value) * float(np.hypot(off / stiffness, also / share))
    return found


FITS = "plain fit with and without it"
TURN = 0.5
"""Ripples nearer than this are one [cycles a turn]: over one turn of a joint they cannot be fields apart."""


def about(value: float, spare: float = 0.0) -> Range:
    """A known number and by how much it may be off."""
    return value - spare, value + spare


def term_of(kind: type[JointEffect], **fields: Any) -> Callable[[str], Effect]:
    """A function that makes an effect of a joint by the joint's name."""
    return lambda joint: kind((joint,), **fields)


def rubs_under_load(joint: int, how: str = FITS, size: str = "no size known", **sizes: Range) -> Known:
    return Known("load_dependent_friction", (joint,), how, size, sizes, term=term_of(LoadDependentFriction))


def sublinear(joint: int) -> Known:
    term = term_of(NonlinearViscousFriction, exponent=0.5)
    shape = {"exponent": (0.0, 1.0)}
    return Known("nonlinear_viscous_friction", (joint,), FITS, "exponent below 1", shape=shape, term=term)


def ripple(joint: int, order: float, size: float, how: str, unit: str, spare: float = 0.0) -> Known:
    words, shape = f"harmonic {order:g}, {size:g} {unit}", {"harmonic": about(order, TURN)}
    term = term_of(TorqueRipple, harmonic=order) if how == FITS else None
    return Known("torque_ripple", (joint,), how, words, {"amplitude": about(size, spare)}, shape, term=term)


def possible(*known: Known) -> tuple[Known, ...]:
    """Effects whose absence is no miss."""
    return tuple(replace(one, expected=False) for one in known)


def delay(how: str, words: str, earliest: float, latest: float) -> tuple[Known, ...]:
    """A delay that a scan finds, of the one joint or of the whole arm."""
    sizes = {"delay": (earliest, latest)}
    return possible(*(Known("time_delay", joints, how, words, sizes) for joints in ((0,), ())))


MAP = {14: 0.349, 28: 0.560, 36: 0.290, 12: 0.263, 84: 0.118, 56: 0.079, 21: 0.075}
"""Harmonics of the motor's cogging besides the 7th, and their amplitude [A], by a map of 2048 angles."""
SCATTER = 0.02
"""By which repeated maps differ [-]."""
COGGING = replace(
    ripple(0, 7, 0.862, "compensation switched off; independent map", "A", SCATTER * 0.862), first=True
)
TWIST = "second encoder behind the gear"  # read 2.6 to 3.2 ms beside the first: stiffness has ranges only
GEARS = (
    Known("joint_elasticity", (0,), TWIST, "stiffness undetermined"),
    Known("joint_elasticity", (1,), TWIST, "6.5e6 to 14e6 N m/rad", {"gear stiffness": (6.5e6, 14e6)}),
    Known("joint_elasticity", (2,), TWIST, "4.8e6 to 7.2e6 N m/rad", {"gear stiffness": (4.8e6, 7.2e6)}),
)
COUPLING = {"Ia of both": about(0.00964), "Fv of both": about(0.616), "Fc of both": about(1.95)}
WORN = (rubs_under_load(1), rubs_under_load(2), sublinear(0))
"""The UR10e's."""

KNOWN: dict[str, tuple[Known, ...]] = {
    "odrive": (
        COGGING,
        *possible(*(ripple(0, n, size, "independent map", "A", SCATTER * size) for n, size in MAP.items())),
    ),
    "emps": (
        Known("friction_asymmetry", (0,), "second model of its authors; plain fit with and without it",
              "drag 36.7 N s/m lower forward, higher backward", {"Fva1": about(-36.7)},
              term=term_of(FrictionAsymmetry, viscous=True)),
    ),
    "tx40": (
        Known("kinematic_coupling", (4, 5), "gears of the wrist; published",
              "Ia 0.00964 kg m², Fv 0.616 N m s/rad, Fc 1.95 N m, ratio 1", COUPLING),
        rubs_under_load(2),
        sublinear(0),
        ripple(3, 30.65, 0.5, FITS, "N m", 0.05),
    ),
    "panda": (),
    "dvrk_psm": (),
    "kr300": (*GEARS, sublinear(5)),
    "kr300_drawn": (
        Known("spring_balancer", (1,), "gas counterbalance; published law", "gas law, arms of 0.2 and 0.8 m"),
        *GEARS,
        sublinear(5),
    ),
    "ur10e": WORN,
    "ur10e_loaded": (Known("payload", (), "weighed", "2.805 kg", {"M": about(2.805)}), *WORN),
    "ur10e_calibrated": (Known("payload", (), "weighed", "2.805 kg", {"M": about(2.805)}), *WORN),
    "kscale": (
        rubs_under_load(0, "eight weighed masses and lengths", "0.18 to 0.26; 0.28 to 0.32 without the delay",
                        mu1=about(0.22, 0.04)),
        *delay("delay that fits best, scanned", "voltage 15 to 20 ms early", -0.02, -0.015),
    ),
    "bam_xl330": (
        rubs_under_load(0, "models of its publishers; plain fit with and without it", "0.12 to 0.23",
                        mu1=(0.12, 0.23)),
        *possible(Known("supply_sag", (), "supply recorded, 5.7 to 9.2 V", "no size known")),
        *delay("delay that fits best, scanned", "duty 25 to 60 ms early", -0.06, -0.025),
    ),
}  # fmt: skip
"""Set -> what it has."""

UNSTATED = "nothing of the kind in the source's account"
STILL = dict.fromkeys(("contact_event", "time_delay", "base_tilt", "payload"), UNSTATED)
"""What an experiment would have to state, and does not; effect -> why it is false unless stated below."""
TORQUE = STILL | {"drive_gain": "its torque was recorded, not its current"}

ABSENT: dict[str, Mapping[str, str]] = {
    "odrive": TORQUE
    | {
        "drive_gain": "its gain is 1 by definition",
        "encoder_offset": "its axis is vertical",
        "backlash": "it has no gear",
        "joint_elasticity": "it has no gear",
    },
    "emps": TORQUE | {"encoder_offset": "it is level"},
    "tx40": TORQUE | {"encoder_offset": "the source converts its angles"},
    "panda": TORQUE,
    "dvrk_psm": TORQUE,
    "kr300": {effect: why for effect, why in TORQUE.items() if effect != "payload"},
    "kr300_drawn": {effect: why for effect, why in TORQUE.items() if effect != "payload"},
    "ur10e": STILL,
    "ur10e_loaded": {effect: why for effect, why in STILL.items() if effect != "payload"},
    "ur10e_calibrated": {effect: why for effect, why in STILL.items() if effect != "payload"},
    "kscale": {effect: why for effect, why in STILL.items() if effect != "time_delay"}
    | {"encoder_offset": "zero hangs down"},
    "bam_xl330": {effect: why for effect, why in STILL.items() if effect != "time_delay"}
    | {"encoder_offset": "zero hangs down"},
}
"""Set -> what it cannot have."""
