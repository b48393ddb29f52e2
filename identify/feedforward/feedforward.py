r"""`Feedforward`: torque that a fit predicts, for a controller that adds it to its own.

Friction is compensated by the rule

.. math:: \tau = \kappa\, w(|\dot q| / b)\, f(q, \dot q), \qquad
          w(x) = s^2 (3 - 2 s), \; s = \mathrm{clip}(x - 1, 0, 1),

and only where f opposes the motion. Within the band b, compensation is zero, so noise of a velocity at rest
makes no torque; it grows smoothly up to 2 b. The share :math:`\kappa < 1` leaves
:math:`(1 - \kappa) f \dot q > 0` of the joint's friction power, so that compensation never drives the joint,
for any b, as long as the joint has that share of the identified friction. With a late velocity its dry part
stays below the dry friction that holds the joint at rest.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arm.robot import Robot, ServoLaw
from ..dynamics.dynamics import Dynamics, stacked
from ..dynamics.program import fitted_dynamics
from ..effects.joint_state import JointState, Scalar
from ..errors import FitError, WrongShape
from ..export.left_out import effect_sentences
from ..export.portable import robot_law
from ..fit.base_parameters import rich_motion
from ..fit.fit import Fit
from ..measurements import measurement_name
from ..model import Model

if TYPE_CHECKING:
    from pathlib import Path

SHARE = 0.7
"""Share of the identified friction that is compensated: the friction of a joint may be 30 % lower than
identified, for instance because it is warmer, before compensation drives it [-]."""


@dataclass(frozen=True, eq=False)
class Feedforward:
    """Torque ahead of a controller, from the parameters of a fit."""

    dynamics: Dynamics  # links and effects at the values of the fit
    unit: str  # unit of the torque of revolute joints: "N m", or "A" if drive gains are unknown
    # Joint torque per motor current, shape (n,) [N m/A]; None if they are not known, or not needed.
    gain: np.ndarray | None
    servo: ServoLaw | None  # law of the joints' position servos; None if there are none
    band: np.ndarray  # speed below which friction is not compensated, shape (n,) [rad/s]
    share: float  # share of the friction that is compensated [-]
    # What the fit contains and this does not, and what it assumes, one sentence each.
    remarks: tuple[str, ...]
    source: tuple[str, ...]  # names of the runs of the fit
    payload: str = ""  # name of the payload that is included; empty for none

    if TYPE_CHECKING:  # `exidyn.api` binds these functions of the layers above

        def python(self) -> str: ...
        def cpp(self) -> str: ...
        def save(self, path: Path | str) -> Path: ...

    @property
    def title(self) -> str:
        """The arm, the payload and the runs of the fit, a noun phrase."""
        carried = f"payload {self.payload}" if self.payload else "no payload"
        return f"arm {self.robot.name} with {carried}, fit of {', '.join(self.source)}"

    @property
    def robot(self) -> Robot:
        """The arm."""
        return self.dynamics.robot

    def torque(
        self, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray, temperature: np.ndarray | None = None
    ) -> np.ndarray:
        """Inverse dynamics: joint torque for a motion, shape (n,) or (t, n) [N m], as `Fit.torque`."""
        return self._of(self.dynamics.torque, q, dq, ddq, temperature)

    def gravity(self, q: np.ndarray, temperature: np.ndarray | None = None) -> np.ndarray:
        """Torque that holds the arm at rest at positions q, shape (n,) or (t, n) [N m]."""
        return self._of(self.dynamics.gravity_torque, q, None, None, temperature)

    def friction(self, q: np.ndarray, dq: np.ndarray, temperature: np.ndarray | None = None) -> np.ndarray:
        """Identified friction torque, shape (n,) or (t, n) [N m]."""
        return self._of(self.dynamics.friction_torque, q, dq, None, temperature)

    def friction_compensation(
        self, q: np.ndarray, dq: np.ndarray, temperature: np.ndarray | None = None
    ) -> np.ndarray:
        """Torque against friction that neither chatters at rest nor drives a joint, (n,) or (t, n) [N m]."""
        friction, dq = self.friction(q, dq, temperature), np.asarray(dq, float)
        s = np.clip(np.abs(dq) / self.band - 1.0, 0.0, 1.0)
        return np.where(friction * dq > 0.0, self.share * s * s * (3.0 - 2.0 * s) * friction, 0.0)

    def compensation(
        self, q: np.ndarray, dq: np.ndarray, temperature: np.ndarray | None = None
    ) -> np.ndarray:
        """Gravity plus friction compensation, shape (n,) or (t, n) [N m]: the arm floats."""
        return self.gravity(q, temperature) + self.friction_compensation(q, dq, temperature)

    def current(self, torque: np.ndarray) -> np.ndarray:
        """Motor currents for joint torques, shape (n,) or (t, n) [A].

        Raises:
            FitError: The fit has no drive gains.
        """
        if self.gain is None:
            raise FitError(
                f"{self.robot.name}: no drive gains; the runs of the fit have torques, not currents"
            )
        return np.asarray(torque) @ self.robot.to_motors.T / self.gain

    def position_offset(self, q: np.ndarray, temperature: np.ndarray | None = None) -> np.ndarray:
        """What position servos without an integral part sag by, to be added to the command, as q [rad].

        Raises:
            FitError: The stiffness of the servos is not known.
        """
        if self.servo is None:
            raise FitError(f"{self.robot.name}: the stiffness of its position servos is not known")
        torque = np.clip(self.gravity(q, temperature), -self.servo.limit, self.servo.limit)
        return torque / self.servo.stiffness

    def _of(
        self,
        function: Callable[[JointState], Sequence[Scalar]],
        q: np.ndarray,
        dq: np.ndarray | None,
        ddq: np.ndarray | None,
        temperature: np.ndarray | None,
    ) -> np.ndarray:
        """A function of joint states for arrays (n,) or (t, n)."""
        position = np.asarray(q, float)
        rows = np.atleast_2d(position)
        parts = [np.zeros_like(rows) if p is None else np.atleast_2d(np.asarray(p, float)) for p in (dq, ddq)]
        warmth = np.full_like(rows, np.nan) if temperature is None else np.atleast_2d(temperature)
        if rows.shape[-1] != self.robot.dof or any(p.shape != rows.shape for p in (*parts, warmth)):
            shapes = ", ".join(str(p.shape) for p in (rows, *parts, warmth))
            raise WrongShape(
                f"feedforward: shapes are {shapes}; expected {self.robot.dof} joints in the last axis"
            )
        state = JointState(*(list(p.T) for p in (rows, *parts, np.zeros_like(rows), warmth)))
        torque = stacked(function(state), len(rows))
        return torque[0] if position.ndim == 1 else torque


def make_feedforward(
    fit: Fit,
    payload: str = "",
    servo: ServoLaw | None = None,
    band: float | np.ndarray | None = None,
    share: float = SHARE,
) -> Feedforward:
    """Torque for gravity, friction and motion, as functions and as files for a controller.

    Args:
        fit: The fit.
        payload: Name of the payload on the flange; empty for none.
        servo: Law of the position servos; by default that of the fit's robot, if it has one.
        band: Speed below which friction is not compensated [rad/s]; by default the speed below which a
            joint counted as standing in the runs of the fit.
        share: Share of the friction that is compensated [-].

    Example:
        >>> fit.feedforward().save("arm.hpp")

    Raises:
        FitError: The fit has no such payload, or band or share are out of range.
    """
    dynamics = fitted_dynamics(fit, payload)
    if not 0.0 <= share < 1.0:
        raise FitError(
            f"share of friction is {100 * share:g} %; it must be at least 0 and below 100 %, since full "
            "compensation could drive a joint"
        )
    band = np.zeros(dynamics.robot.dof) + (fit.standstill if band is None else band)
    if not np.all(band > 0.0):
        raise FitError(f"band of velocity is {band.min():g} rad/s; it must be above 0")
    return Feedforward(
        dynamics,
        "A" if fit.unscaled else "N m",
        fit.estimate.gain if fit.measures == "current" and not fit.unscaled else None,
        servo or robot_law(fit.model.robot, fit.estimate.gain),
        band,
        share,
        tuple(remarks(fit, dynamics)),
        fit.runs,
        payload,
    )


def remarks(fit: Fit, dynamics: Dynamics) -> Iterator[str]:
    """One sentence for each effect that is missing and each assumption."""
    robot = fit.model.robot
    for sentence in effect_sentences(fit.model, dynamics.left_out):
        yield f"not included: {sentence}"
    for measurement in fit.model.measurements:
        yield (
            f"not included: {measurement_name(measurement)}; the torque is that of rigid gears, without delay"
        )
    if fit.unscaled:
        yield "drive gains are unknown: what is called torque is motor current times the nominal gain of 1"
    elif fit.measures == "current" and not np.any(fit.estimate.gain_estimated):
        yield (
            "drive gains are nominal, not estimated: torques are as uncertain as these; "
            "exidyn identify --payload RUN --mass KG estimates them"
        )
    if dynamics.needs_temperature:
        yield "friction depends on temperature: give the temperature of each joint [degC]"
    if robot.passive:
        yield f"joints without a motor: {', '.join(robot.passive)}; their torque cannot be applied"


REFERENCE = 25.0
"""Temperature at which friction that depends on it is summarized [degC]."""

ROUNDING = 1e-12
"""Share of the largest torque below which a torque is a rounding error, as that of a vertical axis."""


class Summary(NamedTuple):
    """Torques of each joint, each of shape (n,)."""

    gravity: np.ndarray  # largest holding torque over poses within the position limits [N m]
    friction: np.ndarray  # friction at twice the band of velocity, at rest of the other joints [N m]
    compensated: np.ndarray  # part of that friction that is compensated [N m]
    # Largest position offset of the servos over the same poses [rad]; None without servos.
    offset: np.ndarray | None


def summary(feedforward: Feedforward) -> Summary:
    """Summary over random poses within the position limits."""
    poses = rich_motion(Model(feedforward.robot, ())).position
    warm = np.full_like(poses, REFERENCE)
    speed = np.broadcast_to(2.0 * feedforward.band, poses.shape)
    gravity = np.abs(feedforward.gravity(poses, warm)).max(axis=0)
    gravity = np.where(gravity > ROUNDING * gravity.max(), gravity, 0.0)
    friction = np.abs(feedforward.friction(poses, speed, warm)).max(axis=0)
    compensated = np.abs(feedforward.friction_compensation(poses, speed, warm)).max(axis=0)
    offset = None
    if feedforward.servo is not None:
        offset = np.abs(feedforward.position_offset(poses, warm)).max(axis=0)
    return Summary(gravity, friction, compensated, offset)
