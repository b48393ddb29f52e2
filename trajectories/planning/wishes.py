"""Wishes: what a user wants of a trajectory, beside the model and what to find out."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.fit.fit import Fit

from ..clearances.clearance import Clearance
from ..errors import BadLimits
from ..limits.usable_limits import Margins
from ..search.setting import Setting

THERE_AND_BACK = (4.0, 3.0)
"""Base periods to try where none is given, in times that the slowest joint takes across its range: there
and back at half its speed, so that faster harmonics have room, and at two thirds of it."""
MOST = {"harmonics": 25, "trajectories": 6}
"""A step of the search takes as the cube of what is searched, and cannot be interrupted: with these it still
is a matter of seconds."""
ROWS = 2.0
"""Independent rows a second and hertz of bandwidth (Nyquist)."""
BANDWIDTH = 10.0
"""Up to which torque is compared where no fit gives it [Hz]: where filters of identification usually end."""


@dataclass(frozen=True, eq=False)
class Wishes:
    """What is wished of a trajectory.

    Attributes:
        criterion: A name in `CRITERIA`; None for what suits the purpose: the drive gains of a pair, the worst
            deviation after a fit, else the condition number.
        harmonics: Number of harmonics of each joint.
        period: Base period [s]; several are tried unless given.
        seconds: Length of the exciting part; as many periods as fill it [s].
        series: How many trajectories are planned together.
        margins: What is kept off the limits.
        window: Window of the controller's corrections around the start pose, as in `usable`.
        start: Pose at which the run begins and ends, shape (n,) [rad]; chosen unless given.
        tick: Cycle of the controller [s].
        rest: At both ends, for the noise of the still arm [s].
        clearances: Collisions and regions.
        shapes: Effects whose shapes count as unknown, by their key.
        bodies: What is known of each body with which the motion is run again; none for a single run.
        fit: Fit of earlier runs.
        focus: Names, or beginnings of names, of base parameters that alone matter, whatever the criterion;
            "gain" stands for the drive gains of a pair.
        sure: Share of arms, within what priors or the fit leave open, that keep to the torque limits; 0 for
            the nominal arm alone.
    """

    criterion: str | None = None
    harmonics: int = Setting.harmonics
    period: float | None = None
    seconds: float = 40.0
    series: int = 1
    margins: Margins = field(default_factory=Margins)
    window: np.ndarray | None = None
    start: np.ndarray | None = None
    tick: float = 0.002
    rest: float = 1.0
    clearances: Sequence[Clearance] = ()
    shapes: Sequence[str] = ()
    bodies: Sequence[tuple[tuple[str, float], ...]] = ()
    fit: Fit | None = None
    focus: Sequence[str] = ()
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
        """Names of what alone matters: the focus, or the drive gains of a pair if nothing else is wished."""
        gains = self.bodies and self.criterion is None and self.fit is None
        return self.focus or (("gain",) if gains else ())


def periods_of(wishes: Wishes, limits: Limits) -> tuple[float, ...]:
    """Base periods to try, whole numbers of ticks [s].

    Across its range a joint takes what its fastest sinusoid takes: in a narrow window it is acceleration or
    jerk, and not velocity, that makes it slow.
    """
    half = 0.5 * (limits.position_upper - limits.position_lower)
    rates = (limits.velocity / half, np.sqrt(limits.acceleration / half), np.cbrt(limits.jerk / half))
    across = float(2.0 / np.min(rates))
    asked = [wishes.period] if wishes.period else [times * across for times in THERE_AND_BACK]
    return tuple(max(round(period / wishes.tick), 1) * wishes.tick for period in asked)


def rows_of(wishes: Wishes, bandwidth: float | None = None) -> float:
    """Independent rows of all trajectories whose torque is compared up to `bandwidth` [Hz]."""
    return ROWS * (bandwidth or BANDWIDTH) * wishes.seconds * wishes.series
