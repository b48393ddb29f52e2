"""Gears: joints whose link can move relative to its motor, by a twist.

Motors are where their encoders measure. All links except one follow their motors; that one differs by a twist
with the equation of row j of the arm: M_jj twist'' + d twist' + (K + dtau_j/dq_j) twist = load_j. The
additional torque of all motors, compared with a rigid gear, is minus the links' torque for the twist.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arm.motion import Tangent, differentiate
from ..arm.robot import Robot
from .measurement import Measurement, require

CHUNK = 200
"""Number of rows converted to Python numbers at once."""

SOFTEST = 1e-3
"""Minimum total stiffness of gear and gravity relative to its maximum; a softer gear explains nothing."""


class Twist(NamedTuple):
    """Angle by which a motor leads its link, and its derivatives, each (t,) [rad], [rad/s], [rad/s^2]."""

    value: np.ndarray
    rate: np.ndarray
    second: np.ndarray


def bent(
    inertia: np.ndarray, damping: np.ndarray, stiffness: np.ndarray, load: np.ndarray, step: float
) -> Twist:
    """Twist of an elastic gear: inertia twist'' + damping twist' + stiffness twist = load at each sample.

    Newmark's method with average acceleration is stable for any stiffness. All time steps form one banded
    system; it starts in equilibrium with the initial load. Inertia [kg m^2], damping [N m s/rad], stiffness
    [N m/rad] and load [N m] of the link are arrays (t,); `step` is the sampling period [s].
    """
    # A first fit may give a light link negative inertia if the moments of a payload are unknown, and a soft
    # gear cannot carry a payload: the twist would be undefined or unbounded. The Coriolis torque in the
    # damping conserves energy only together with a change of the inertia, so both are limited.
    if np.min(inertia) < 0.0:
        inertia, damping = np.maximum(inertia, 0.0), np.maximum(damping, 0.0)
    stiffness = np.maximum(stiffness, SOFTEST * np.max(np.abs(stiffness)))
    mass, loss = inertia / step**2, damping / (2 * step)
    bands = np.zeros((3, len(load)))
    # Row k is the equation at sample k - 1; the first two rows state that the gear starts at rest.
    bands[0, 2:] = (mass + loss + stiffness / 4)[1:-1]
    bands[1, 1:-1] = (stiffness / 2 - 2 * mass)[1:-1]
    bands[2, :-2] = (mass - loss + stiffness / 4)[1:-1]
    bands[0, :2] = 1.0
    right = np.empty(len(load))
    right[:2] = load[0] / stiffness[0]
    right[2:] = (load[:-2] + 2 * load[1:-1] + load[2:]) / 4
    from scipy.linalg.blas import dtbsv  # a large module that file readers should not load

    value = dtbsv(2, bands, right, lower=1)
    rate, second = differentiate(value[:, None], 1.0 / step)
    return Twist(value, rate[:, 0], second[:, 0])


def loose(
    inertia: np.ndarray,
    damping: np.ndarray,
    stiffness: np.ndarray,
    load: np.ndarray,
    step: float,
    play: float,
    teeth: tuple[float, float],
    on_teeth: Twist | None = None,
) -> Twist:
    """Twist of a gear with play, within which only the inertia of the link resists the load.

    The link rests on the teeth on the side of its load; the teeth are rigid, or bend by `on_teeth`. When the
    load changes its sign, the link floats to the other side, strikes the teeth, and bounces until they have
    damped it out.

    Inertia, damping, stiffness (by gravity) and load are those of the link without its gear, as in `bent`.
    `play` is half of the width [rad]. `teeth` is the resonance of the link on its teeth, at most an eighth of
    the sampling rate [Hz], and its damping ratio [-]. `on_teeth` is the twist of soft teeth without play.
    """
    angular, ratio = 2 * np.pi * teeth[0], teeth[1]
    spring, damper = angular**2, 2.0 * ratio * angular
    settled = int(3.0 / (ratio * angular * step))  # oscillation has decayed to e^-3, a twentieth
    side = np.where(load < 0, -1.0, 1.0)
    value, rate, second = play * side, np.zeros(len(load)), np.zeros(len(load))
    if on_teeth is not None:
        value, rate, second = value + on_teeth.value, on_teeth.rate.copy(), on_teeth.second.copy()
    per_inertia = np.stack([load, damping, stiffness], axis=1) / inertia[:, None]
    end = 0
    for start in (np.flatnonzero(np.diff(side)) + 1).tolist():
        if start < end:
            continue
        x, v, in_contact, path = float(value[start - 1]), float(rate[start - 1]), 0, []
        # Python numbers, since each sample depends on the previous one and small arrays are slow
        for pull, drag, weight in _rows(per_inertia, start):
            past = x - play if x > play else x + play if x < -play else 0.0
            acceleration = pull - drag * v - weight * x
            if past:
                acceleration -= spring * past + damper * v
                in_contact += 1
            else:
                in_contact = 0
            v += step * acceleration
            x += step * v
            path.append((x, v, acceleration))
            if in_contact > settled and past * pull > 0.0:
                break
        end = start + len(path)
        value[start:end], rate[start:end], second[start:end] = np.array(path).T
    return Twist(value, rate, second)


def _rows(values: np.ndarray, start: int) -> Iterator[list[float]]:
    """Rows of values (t, p) from `start` on as Python numbers, converted in chunks."""
    for first in range(start, len(values), CHUNK):
        yield from values[first : first + CHUNK].tolist()


class Spring(NamedTuple):
    """Gear in a simulated arm."""

    stiffness: float  # [N m/rad]
    damping: float  # [N m s/rad]
    backlash: float = 0.0  # width of the play [rad]


@dataclass(frozen=True)
class Gear(Measurement, ABC):
    """A gear that twists under load, while the position is measured at the motor."""

    joint: str  # name of the joint

    @abstractmethod
    def twist(self, tangent: Tangent, load: np.ndarray, joint: int, step: float) -> Twist:
        """Angle by which the motor leads its link.

        Args:
            tangent: Derivatives of the links' torque along the motion.
            load: Torque that a rigid gear would transmit, shape (t,) [N m].
            joint: Index of the joint.
            step: Sampling period [s].
        """

    @abstractmethod
    def spring(self, inertia: float) -> Spring:
        """Gear in a simulated arm, for a mean inertia of the link [kg m^2]."""

    def check(self, robot: Robot) -> None:
        super().check(robot)
        robot.index(self.joint)


@dataclass(frozen=True)
class JointElasticity(Gear):
    """A spring and a damper between motor and link, reflected to the joint: the link lags and oscillates."""

    stiffness: float  # [N m/rad]
    damping: float = 0.0  # [N m s/rad]

    def twist(self, tangent: Tangent, load: np.ndarray, joint: int, step: float) -> Twist:
        weight, drag, inertia = tangent.own(joint)
        return bent(inertia, self.damping + drag, self.stiffness + weight, load, step)

    def spring(self, inertia: float) -> Spring:
        return Spring(self.stiffness, self.damping)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        require("joint_elasticity", "stiffness", self.stiffness)
        require("joint_elasticity", "damping", self.damping, above=False)


TEETH = 40.0
"""Resonance of a link on its teeth above which they count as rigid [Hz]: behind a low-pass of 25 Hz, their
impacts look alike; softer teeth also bend under the load."""
RATIO = 0.5
"""Damping ratio of the teeth, including the drive that they push back [-]."""


@dataclass(frozen=True)
class Backlash(Gear):
    """Play between two sides of the teeth: while they change sides, the link floats without its motor."""

    gap: float  # full width of the play, at the joint [rad]
    damping_ratio: float = RATIO  # damping ratio of the link on its teeth [-]
    load_shift: float = 0.0  # true load minus the load of the model [N m]
    resonance: float = TEETH  # resonance of the link on its teeth [Hz]

    def twist(self, tangent: Tangent, load: np.ndarray, joint: int, step: float) -> Twist:
        weight, drag, inertia = tangent.own(joint)
        load, play = load + self.load_shift, 0.5 * self.gap
        if not np.min(inertia) > 0.0:  # a link without positive inertia in the fit never floats
            still = np.zeros(len(load))
            return Twist(np.where(load < 0, -play, play), still, still)
        on_teeth = None
        if self.resonance < TEETH:
            soft = self.spring(float(np.mean(inertia)))
            on_teeth = bent(inertia, soft.damping + drag, soft.stiffness + weight, load, step)
        teeth = min(self.resonance, 0.125 / step), self.damping_ratio
        return loose(inertia, drag, weight, load, step, play, teeth, on_teeth)

    def spring(self, inertia: float) -> Spring:
        angular = 2 * np.pi * self.resonance
        return Spring(inertia * angular**2, 2 * self.damping_ratio * inertia * angular, self.gap)

    def check(self, robot: Robot) -> None:
        super().check(robot)
        for name in ("gap", "damping_ratio", "resonance"):
            require("backlash", name, getattr(self, name))
