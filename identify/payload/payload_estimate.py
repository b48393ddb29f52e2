"""`PayloadEstimate`: a payload on the flange with its intervals, and how it was found."""

from dataclasses import dataclass, field

import numpy as np

from ..errors import UnknownKey
from ..notebook import InNotebook
from ..text_table import digits
from .body import Body
from .formats import FORMATS
from .intervals import Interval, Intervals
from .pose_check import Check

FIT, DIFFERENCE, DESCRIPTION = "fit", "difference", "description"
"""What is known of the arm: a fit, a run without the payload, or only its description."""
OPEN_MASS = 0.3
"""Half-width of the mass's interval over the mass, beyond which it counts as not determined."""
OPEN_CENTER = 0.3
"""Half-width of a coordinate's interval over the distance of the center from the flange, or over `LEAST`."""
LEAST = 0.1
"""Distance to which `OPEN_CENTER` refers at least [m]: a center is never near enough to the flange to need
more than 3 cm."""
OPEN_INERTIA = 0.5
"""Half-width of an element's interval over the largest moment of the body."""
CENTER_NAMES = ("x", "y", "z")
INERTIA_NAMES = ("Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")


@dataclass(frozen=True, eq=False, repr=False)
class PayloadEstimate(InNotebook):
    """A payload identified from runs.

    Attributes:
        robot: Name of the arm.
        joints: Names of its joints.
        body: The payload; physically consistent.
        intervals: 95 % intervals.
        certain: 95 % intervals if arm and gains were known exactly: what the motion alone determines.
        estimate: Ten parameters about the flange before consistency, in `INERTIAL` order, shape (10,).
        covariance: Covariance of the estimate, shape (10, 10).
        source: What is known of the arm: "fit", "difference" or "description".
        nominal_gains: Whether drive gains are nominal; False if they were estimated, or torque was recorded.
        runs: Names of the runs with the payload.
        empty: Names of the runs without it.
        seconds: Duration of the runs with the payload [s].
        noise: Residual of each joint, shape (n,) [N m].
        gain_error: Relative change of each drive gain from the assumed one, shape (n,) [-].
        gain_std: Its standard deviation, shape (n,) [-]; zero if torque was recorded.
        check: Check in poses that were not used.
        distance: Distance of the consistent body from the estimate, in standard deviations (chi).
        warnings: Sentences to read.
    """

    robot: str
    joints: tuple[str, ...]
    body: Body
    intervals: Intervals
    certain: Intervals
    estimate: np.ndarray
    covariance: np.ndarray
    source: str
    nominal_gains: bool
    runs: tuple[str, ...]
    empty: tuple[str, ...]
    seconds: float
    noise: np.ndarray
    gain_error: np.ndarray
    gain_std: np.ndarray
    check: Check
    distance: float
    warnings: tuple[str, ...] = field(default=())

    @property
    def mass(self) -> Interval:
        """Mass with its interval [kg]."""
        return self.intervals.mass

    @property
    def center(self) -> tuple[Interval, ...]:
        """Center of mass in the flange frame with intervals [m]."""
        return self.intervals.center

    @property
    def inertia(self) -> tuple[Interval, ...]:
        """Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the center of mass with intervals [kg m^2]."""
        return self.intervals.inertia

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Names of the values that these runs do not determine; see `OPEN_MASS` and those below."""
        body, names = self.body, []
        reach = max(float(np.linalg.norm(body.center)), LEAST)
        moment = float(np.max(body.principal[0]))
        if not self.mass.half <= OPEN_MASS * body.mass:
            names.append("mass")
        for name, value in zip(CENTER_NAMES, self.center, strict=True):
            if not value.half <= OPEN_CENTER * reach:
                names.append(name)
        for name, value in zip(INERTIA_NAMES, self.inertia, strict=True):
            if not value.half <= OPEN_INERTIA * moment:
                names.append(name)
        return tuple(names)

    def text(self, format: str) -> str:
        """The payload as a controller or simulator takes it; see `FORMATS`.

        Raises:
            UnknownKey: There is no such format; the message lists the valid ones.
        """
        if format not in FORMATS:
            raise UnknownKey(format, "payload: format", tuple(FORMATS))
        return FORMATS[format](self.body)

    def __repr__(self) -> str:
        center = ", ".join(f"{1e3 * value:.1f}" for value in self.body.center + 0.0)
        open_words = f"; not determined: {', '.join(self.undetermined)}" if self.undetermined else ""
        return (
            f"Payload of {self.robot}: {digits(self.mass.value, 4)} kg "
            f"({digits(self.mass.low, 4)} to {digits(self.mass.high, 4)}), center ({center}) mm in the "
            f"flange frame{open_words}"
        )
