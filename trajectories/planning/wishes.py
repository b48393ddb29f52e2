"""Planning options of a trajectory, besides the model and the goal, and the parameters that words mean.

Examples are "K_r", "gain of joint 2", "friction of elbow", "payload": the name of a parameter in any
spelling, or a word for a group of parameters of one joint or of all joints.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.fit.fit import Fit

from ..clearances.clearance import Clearance
from ..errors import BadLimits, UnknownChoice
from ..limits.usable_limits import Margins
from ..search.delivery import Setting

THERE_AND_BACK = (4.0, 3.0)
"""Default base periods, as multiples of the time that the slowest joint takes across its range: there and
back at half its speed, which leaves room for faster harmonics, and at two thirds of it."""
LEADS = 2.0
"""Time for both leads, as a multiple of the time in which the slowest joint reaches its largest velocity with
half of acceleration and jerk; usual leads begin where the motion is slow, and take half of it."""
MOST = {"harmonics": 25, "trajectories": 6}
"""Largest values: the time of a search step grows with the cube of the number of unknowns, and a step cannot
be interrupted. With these values it takes seconds."""
ROUNDING = 1e-6
"""Share of a sampling period, or of a base period, that counts as rounding [-]."""
ROWS = 2.0
"""Independent rows per second and hertz of bandwidth (Nyquist)."""
BANDWIDTH = 10.0
"""Bandwidth in which torques are compared if no fit gives it [Hz]: the usual cutoff of filters."""


@dataclass(frozen=True, eq=False)
class Wishes:
    """Planning options of a trajectory."""

    # A name in `CRITERIA`; None for the default: the drive gains if there are payloads, the worst relative
    # standard deviation after a fit, else the condition number.
    criterion: str | None = None
    harmonics: int = Setting.harmonics  # number of harmonics of each joint
    period: float | None = None  # base period [s]; several are tried by default
    seconds: float = 40.0  # duration of the whole run, with rests and leads [s]
    series: int = 1  # number of trajectories that are planned together
    margins: Margins = field(default_factory=Margins)  # safety margins to the limits
    # Window of the controller's corrections around the start pose, as in `usable`.
    window: np.ndarray | None = None
    # Pose at which the run begins and ends, shape (n,) [rad]; chosen by default.
    start: np.ndarray | None = None
    tick: float = 0.002  # sampling period of the controller [s]
    rest: float = 1.0  # least rest at each end, which records the noise of the still arm [s]
    clearances: Sequence[Clearance] = ()  # collisions and regions
    shapes: Sequence[str] = ()  # keys of effects whose shapes are unknown
    # Known parameters of the payload of each further run of the motion; empty for a single run.
    bodies: Sequence[tuple[tuple[str, float], ...]] = ()
    fit: Fit | None = None  # fit of earlier runs
    # Names, or beginnings of names, of the base parameters to optimize, regardless of the criterion; "gain"
    # means the drive gains.
    focus: Sequence[str] = ()
    # Share of arms that priors or fit allow and that must keep to the torque limits; 0 for the nominal model
    # alone.
    sure: float = 0.95

    def __post_init__(self) -> None:
        times = {"tick": self.tick, "length": self.seconds, "period": self.period}
        for name, value in times.items():
            if value is not None and not 0.0 < value < np.inf:
                raise BadLimits(f"{name}: {value:g} s; it must be above 0 and finite")
        if not 0.0 <= self.rest < np.inf:
            raise BadLimits(f"rest: {self.rest:g} s; it must be 0 or more")
        if not 0.0 <= self.sure < 1.0:
            raise BadLimits(f"sure: {self.sure:g}; it is a share of arms, at least 0 and below 1")
        for name, count in {"harmonics": self.harmonics, "trajectories": self.series}.items():
            if not 1 <= count <= MOST[name]:
                raise BadLimits(f"{name}: {count}; there must be at least 1 and at most {MOST[name]}")

    @property
    def in_focus(self) -> Sequence[str]:
        """Base parameters to optimize: the focus, or by default the drive gains if there are payloads."""
        gains = self.bodies and self.criterion is None and self.fit is None
        return self.focus or (("gain",) if gains else ())


def periods_of(wishes: Wishes, limits: Limits) -> tuple[float, ...]:
    """Base periods to try, in whole sampling periods; a whole number of each fills the run [s].

    Raises:
        BadLimits: The run is shorter than one period, rests and leads.
    """
    if wishes.seconds < (shortest := shortest_run(wishes, limits)) - ROUNDING:
        raise BadLimits(
            f"length: {wishes.seconds:g} s; the shortest possible is {np.ceil(10.0 * shortest) / 10.0:g} s: "
            f"one period of {shortest - beside_periods(wishes, limits):.3g} s between rests and leads"
        )
    if wishes.period:
        return (max(round(wishes.period / wishes.tick), 1) * wishes.tick,)
    room, across, tick = wishes.seconds - beside_periods(wishes, limits), _time_across(limits), wishes.tick
    counts = [max(round(room / (times * across)), 1) for times in THERE_AND_BACK]
    return tuple(dict.fromkeys(int(room / count / tick + ROUNDING) * tick for count in counts))


def shortest_run(wishes: Wishes, limits: Limits) -> float:
    """Duration of one period, in which every joint could cross its range, between rests and leads [s]."""
    return beside_periods(wishes, limits) + (wishes.period or _time_across(limits))


def beside_periods(wishes: Wishes, limits: Limits) -> float:
    """Time that rests and leads take of the run [s]."""
    half = 0.5 * (limits.position_upper - limits.position_lower)
    fastest = np.minimum(limits.velocity, np.sqrt(limits.acceleration * half))
    speeding = 2.0 * fastest / limits.acceleration + limits.acceleration / limits.jerk
    away = 0.0 if wishes.start is None else _time_across(limits)  # half of the range and back
    return 2.0 * wishes.rest + LEADS * float(np.max(speeding)) + away


def _time_across(limits: Limits) -> float:
    """Time that the slowest joint takes across its range [s].

    That of its fastest sinusoid: in a narrow window acceleration or jerk limit it, not velocity.
    """
    half = 0.5 * (limits.position_upper - limits.position_lower)
    rates = (limits.velocity / half, np.sqrt(limits.acceleration / half), np.cbrt(limits.jerk / half))
    return float(2.0 / np.min(rates))


def rows_of(wishes: Wishes, bandwidth: float | None = None) -> float:
    """Number of independent rows of all trajectories if torque is compared up to `bandwidth` [Hz]."""
    return ROWS * (bandwidth or BANDWIDTH) * wishes.seconds * wishes.series


WORDS: Mapping[str, tuple[str, ...]] = {
    "gain": ("gain",),
    "friction": ("Fv", "Fc"),
    "offset": ("Off",),
    "rotor inertia": ("Ia",),
    "mass": ("M", "MX", "MY", "MZ"),
    "inertia": ("XX", "XY", "XZ", "YY", "YZ", "ZZ"),
}
"""Names of parameters, without the number of the joint, by word."""
INERTIAL = (*WORDS["inertia"], *WORDS["mass"])
OF_JOINT = re.compile(r"^(?P<what>.+?)(?:\s+of)?(?:\s+joint)?\s+(?P<joint>\S+)$")
NUMBER = re.compile(r"^(?P<what>\D+?)\s*(?P<joint>\d+)$")


def wanted_names(
    phrases: Sequence[str], names: Sequence[str], joints: Sequence[str], payloads: Sequence[str]
) -> list[str]:
    """Names of base parameters, or beginnings of names, that phrases mean.

    Raises:
        UnknownChoice: A phrase means no base parameter; the message suggests the most similar one.
    """
    parts = [part.strip() for phrase in phrases for part in phrase.split(",")]
    return [name for part in parts if part for name in _names_of_phrase(part, names, joints, payloads)]


def _names_of_phrase(
    phrase: str, names: Sequence[str], joints: Sequence[str], payloads: Sequence[str]
) -> list[str]:
    if any(name.startswith(phrase) for name in names):
        return [phrase]  # as typed
    plain = {_plain(name): name for name in reversed(names)}
    if _plain(phrase) in plain:
        return [plain[_plain(phrase)]]
    if phrase.lower() in ("payload", "load"):
        candidates = [f"{name}{load}" for load in payloads if load for name in INERTIAL]
    else:
        quantity, numbers = _joint_of(phrase.lower(), joints)
        prefixes = WORDS.get(quantity) or WORDS.get(quantity.removesuffix("s"), ())
        candidates = [f"{prefix}{number}" for prefix in prefixes for number in numbers]
    present = [name for name in names if name in candidates or name.removesuffix("R") in candidates]
    if present:
        return present
    raise _unknown(phrase, names)


def _joint_of(phrase: str, joints: Sequence[str]) -> tuple[str, list[int]]:
    """Quantity and numbers of the joints, from 1, in a phrase; all joints if none is named."""
    lower = [joint.lower() for joint in joints]
    for pattern in (OF_JOINT, NUMBER):
        if (match := pattern.match(phrase)) is None:
            continue
        joint, quantity = match["joint"], match["what"].removesuffix(" of joint").strip()
        if joint in lower:
            return quantity, [lower.index(joint) + 1]
        if joint.isdigit() and 1 <= int(joint) <= len(joints):
            return quantity, [int(joint)]
    return phrase, list(range(1, len(joints) + 1))


def _plain(name: str) -> str:
    """A name without underscores, spaces, case and the R of regrouping."""
    return re.sub(r"[\s_]", "", name.removesuffix("R")).lower()


def _unknown(phrase: str, names: Sequence[str]) -> UnknownChoice:
    """The error about a phrase, with the most similar one that is valid."""
    valid = [*names, *WORDS, "payload"]
    by_plain = {_plain(name): name for name in valid}
    matches = get_close_matches(_plain(phrase), by_plain, 1, cutoff=0.5)  # one of two letters agrees
    meant = f"; did you mean '{by_plain[matches[0]]}'?" if matches else ""
    return UnknownChoice("base parameter", phrase, valid, meant)
