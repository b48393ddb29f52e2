"""`PayloadEstimate`: a payload on the flange with its intervals, and how it was found."""

from dataclasses import dataclass, field

import numpy as np

from ..errors import FitError, UnknownKey
from ..notebook import InNotebook
from ..text_table import digits
from .body import Body, Interval, Intervals
from .formats import FORMATS, is_own_flange
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
    """A payload identified from runs."""

    robot: str  # name of the arm
    frame: str  # name of the flange frame
    joints: tuple[str, ...]  # names of its joints
    body: Body  # the payload; physically consistent
    intervals: Intervals  # 95 % intervals
    certain: Intervals  # 95 % intervals if arm and gains were known exactly: what the motion alone determines
    # Ten parameters about the flange before consistency, in `INERTIAL` order, shape (10,).
    estimate: np.ndarray
    covariance: np.ndarray  # covariance of the estimate, shape (10, 10)
    source: str  # what is known of the arm: "fit", "difference" or "description"
    # Whether drive gains are nominal; False if they were estimated, or torque was recorded.
    nominal_gains: bool
    runs: tuple[str, ...]  # names of the runs with the payload
    empty: tuple[str, ...]  # names of the runs without it
    seconds: float  # duration of the runs with the payload [s]
    noise: np.ndarray  # residual of each joint, shape (n,) [N m]
    gain_error: np.ndarray  # relative change of each drive gain from the assumed one, shape (n,) [-]
    gain_std: np.ndarray  # its standard deviation, shape (n,) [-]; zero if torque was recorded
    check: Check  # check in poses that were not used
    distance: float  # distance of the consistent body from the estimate, in standard deviations (chi)
    warnings: tuple[str, ...] = field(default=())  # sentences to read

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
            FitError: The mass may be zero, or the frame is not the flange of the controller.
        """
        if obstacle := self.obstacle(format):
            raise FitError(obstacle)
        return FORMATS[format](self.body, self.frame)

    def obstacle(self, format: str) -> str:
        """A sentence on why there is no such form; empty if there is one."""
        if format not in FORMATS:
            raise UnknownKey(format, "payload: format", tuple(FORMATS))
        if not self.mass.low > 0.0:
            return f"{format}: no form, since the mass may be zero"
        if not is_own_flange(format, self.frame):
            flanges = " or ".join(FORMATS[format].frames)
            return (
                f"{format}: no form, since the payload is in frame {self.frame}, and the controller expects "
                f"its own flange ({flanges}); state it under [flange] in robot.toml"
            )
        return ""

    def __repr__(self) -> str:
        center = ", ".join(f"{1e3 * value:.1f}" for value in self.body.center + 0.0)
        open_words = f"; not determined: {', '.join(self.undetermined)}" if self.undetermined else ""
        return (
            f"Payload of {self.robot}: {digits(self.mass.value, 4)} kg "
            f"({digits(self.mass.low, 4)} to {digits(self.mass.high, 4)}), center ({center}) mm in frame "
            f"{self.frame}{open_words}"
        )
