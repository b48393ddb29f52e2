"""Friction of single joints that depends on velocity alone, and the constant offset that resembles it."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from .effect import JointEffect, Parameter, shape
from .simulator_terms import JointTerms
from .smooth_sign import smooth_sign, smooth_sign_by_reversal

TINY = np.finfo(float).tiny
"""Speed that keeps logarithms finite at standstill, where their products vanish [rad/s]."""


@dataclass(frozen=True)
class ViscousFriction(JointEffect):
    r"""Torque :math:`F_v \dot q`, the paper's :math:`Fv_j`."""

    smooth: ClassVar[bool] = True
    linear: ClassVar[bool] = True
    guessed: ClassVar[bool] = True
    greased: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ("velocity",)
    coefficients: ClassVar[tuple[tuple[Any, ...], ...]] = (("Fv", "N m s/rad", 0.0),)

    def profiles(self, at: Any) -> tuple[Any, ...]:
        return (at.velocity,)

    def portable(self, robot: Robot, values: np.ndarray) -> JointTerms:
        return self.terms(robot, damping=values)


@dataclass(frozen=True)
class CoulombFriction(JointEffect):
    r"""Torque :math:`F_c \tanh(\dot q / v_r)`, the paper's :math:`Fc_j`.

    Attributes:
        reversal: Velocity :math:`v_r` over which the sign changes [rad/s]; grease that drags like a fluid
            until it shears needs some tenths.
        gradual: Whether it is the part :math:`Fg_j` of a joint's dry friction that changes its sign over
            another velocity than :math:`Fc_j`, so that one model can have both.
    """

    reversal: float = shape(0.003, "rad/s", 1e-4, 0.3)
    gradual: bool = False

    guessed: ClassVar[bool] = True
    dry: ClassVar[bool] = True
    greased: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ("velocity",)

    def profiles(self, at: Any) -> tuple[Any, ...]:
        return (smooth_sign(at.velocity, self.reversal),)

    def parameters(self, robot: Robot) -> list[Parameter]:
        return self.on_each(robot, ("Fg" if self.gradual else "Fc", "N m", 0.0))

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = smooth_sign_by_reversal(motion.velocity, self.reversal)
        return {"reversal": self.on_joints(robot, slope)}

    def portable(self, robot: Robot, values: np.ndarray) -> JointTerms:
        return self.terms(robot, dry=values, reversal=np.full(len(values), self.reversal))


@dataclass(frozen=True)
class FrictionAsymmetry(JointEffect):
    r"""Torque :math:`F_a |\tanh(\dot q / v_r)| + F_{va} |\dot q|`, the even part of friction.

    With `CoulombFriction`, the friction of the joint is :math:`F_c + F_a` forward and :math:`F_c - F_a`
    backward, and with different viscous friction also :math:`F_v \pm F_{va}`. Unlike a `CurrentOffset`, it is
    zero at standstill; a motion without standstill hardly distinguishes the two.

    Attributes:
        reversal: Velocity :math:`v_r` over which the friction builds up [rad/s].
        viscous: Whether viscous friction differs too.
    """

    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)
    viscous: bool = False

    guessed: ClassVar[bool] = True
    greased: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ("velocity",)

    def profiles(self, at: Any) -> tuple[Any, ...]:
        built_up = np.abs(smooth_sign(at.velocity, self.reversal))
        return (built_up, np.abs(at.velocity)) if self.viscous else (built_up,)

    def parameters(self, robot: Robot) -> list[Parameter]:
        return self.on_each(robot, *[("Fa", "N m"), ("Fva", "N m s/rad")][: 1 + self.viscous])

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = smooth_sign_by_reversal(motion.velocity, self.reversal)
        still = np.zeros_like(slope)
        columns = [np.sign(motion.velocity) * slope, still][: 1 + self.viscous]
        return {"reversal": self.on_joints(robot, *columns)}


def _decay(velocity: Any, fade: float, exponent: float) -> Any:
    """Remaining share of the friction at a velocity [-]."""
    return np.exp(-(np.abs(velocity / fade) ** exponent))


@dataclass(frozen=True)
class StribeckFriction(JointEffect):
    r"""Torque :math:`F_s \tanh(\dot q / v_r) e^{-|\dot q / v_s|^\delta}`, on top of Coulomb friction.

    The exponent is 1 with Tustin and 2 with Armstrong-Hélouvry; between them, 1.5 is within 5 % of the form
    :math:`1 / (1 + (\dot q / v_s)^2)` of Hess and Soom.

    Attributes:
        fade: Stribeck velocity :math:`v_s`, at which 37 % of the friction remains [rad/s].
        reversal: Velocity :math:`v_r` over which the sign changes [rad/s].
        exponent: Exponent :math:`\delta` [-].
    """

    fade: float = shape(0.1, "rad/s", 0.01, 1.0)
    reversal: float = shape(0.003, "rad/s", 1e-4, 0.1)
    exponent: float = 2.0

    greased: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ("velocity",)
    coefficients: ClassVar[tuple[tuple[Any, ...], ...]] = (("Fs", "N m", 0.0),)

    def profiles(self, at: Any) -> tuple[Any, ...]:
        decay = _decay(at.velocity, self.fade, self.exponent)
        return (smooth_sign(at.velocity, self.reversal) * decay,)

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        v, decay = motion.velocity, _decay(motion.velocity, self.fade, self.exponent)
        growth = self.exponent * np.abs(v / self.fade) ** self.exponent / self.fade
        fade = smooth_sign(v, self.reversal) * decay * growth
        reversal = smooth_sign_by_reversal(v, self.reversal) * decay
        return {"fade": self.on_joints(robot, fade), "reversal": self.on_joints(robot, reversal)}


@dataclass(frozen=True)
class NonlinearViscousFriction(JointEffect):
    r"""Torque :math:`F_n\, \mathrm{sign}(\dot q)\, |\dot q / v_1|^a` with :math:`v_1` = 1 rad/s.

    The reference velocity makes the parameter a torque for any exponent. Exponent 1 is `ViscousFriction`,
    whose column is then the same, so an exponent near 1 means that there is no nonlinearity. Toward 0, the
    effect approaches `CoulombFriction`.

    Attributes:
        exponent: The power :math:`a` of the velocity [-]; 2 is the drag of a stirred fluid.
    """

    exponent: float = shape(2.0, "1", 0.3, 3.0)

    greased: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ("velocity",)
    coefficients: ClassVar[tuple[tuple[Any, ...], ...]] = (("Fn", "N m", 0.0),)

    def profiles(self, at: Any) -> tuple[Any, ...]:
        return (np.sign(at.velocity) * np.abs(at.velocity) ** self.exponent,)

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        slope = self.profiles(motion)[0] * np.log(np.maximum(np.abs(motion.velocity), TINY))
        return {"exponent": self.on_joints(robot, slope)}


@dataclass(frozen=True)
class CurrentOffset(JointEffect):
    r"""Constant torque, the paper's :math:`\tau_{off_j}`."""

    smooth: ClassVar[bool] = True
    linear: ClassVar[bool] = True
    guessed: ClassVar[bool] = True
    moved_by: ClassVar[tuple[str, ...]] = ()
    coefficients: ClassVar[tuple[tuple[Any, ...], ...]] = (("Off", "N m"),)

    def profiles(self, at: Any) -> tuple[Any, ...]:
        return (0.0 * at.velocity + 1.0,)

    def portable(self, robot: Robot, values: np.ndarray) -> JointTerms:
        return self.terms(robot, constant=values)
