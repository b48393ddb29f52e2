"""Gears that give way and have play, and joints that warm up from what motors and gears lose."""

from dataclasses import dataclass
from math import exp

import numpy as np

from ...effects import RotorInertia
from ...errors import RobotError
from ...model import Model
from .link_size import link_size
from .steps import Elastic

TINY = 1e-9
"""Least inertia of a link [kg m^2]."""
LIGHT = 0.01
"""Inertia of a motor to which the model gives none, over that of its link [-]: too little to be seen in a
torque, and enough to move apart from the link."""


@dataclass(frozen=True, eq=False)
class Transmission:
    """A spring and a damper between each motor and its link, both seen from the joint.

    Attributes:
        stiffness: Infinite for a rigid gear, shape (n,) [N m/rad].
        damping: Shape (n,) [N m s/rad].
        backlash: Width of the play in which neither spring nor damper is in contact, shape (n,) [rad].
    """

    stiffness: np.ndarray
    damping: np.ndarray
    backlash: np.ndarray

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping", "backlash"):
            value = np.asarray(getattr(self, name), float)
            if value.shape != np.shape(self.stiffness) or np.any(np.isnan(value)) or np.any(value < 0):
                raise RobotError(
                    f"transmission: {name} is {value}; expected one number a joint, none below 0"
                )
            object.__setattr__(self, name, value)
        if np.any(self.stiffness == 0.0):
            raise RobotError("transmission: a stiffness of 0 leaves a link without drive; use inf for rigid")
        if np.any((self.backlash > 0.0) & np.isinf(self.stiffness)):
            raise RobotError("transmission: a gear with backlash needs a finite stiffness")

    @classmethod
    def rigid(cls, joints: int) -> "Transmission":
        """Gears that do not give way."""
        return cls(np.full(joints, np.inf), np.zeros(joints), np.zeros(joints))

    @classmethod
    def of(cls, model: Model) -> "Transmission":
        """Gears of a model."""
        gears = cls.rigid(model.robot.dof)
        inertia = link_size(model)[0] if model.gears else ()
        for gear in model.gears:
            joint = model.robot.index(gear.joint)
            place = np.arange(model.robot.dof) == joint
            spring = gear.spring(max(float(inertia[joint]), TINY))
            gears = gears.softened(
                np.where(place, spring.stiffness, np.inf), place * spring.damping, place * spring.backlash
            )
        return gears

    def softened(self, stiffness: np.ndarray, damping: np.ndarray, backlash: np.ndarray) -> "Transmission":
        """These gears with other springs in series, and the larger damping and play of both, each (n,)."""
        with np.errstate(divide="ignore"):
            series = 1.0 / (1.0 / self.stiffness + 1.0 / np.asarray(stiffness))
        return Transmission(series, np.maximum(self.damping, damping), np.maximum(self.backlash, backlash))

    @property
    def elastic(self) -> np.ndarray:
        """Joints whose motor can move without their link, shape (m,)."""
        return np.flatnonzero(np.isfinite(self.stiffness))

    @property
    def links(self) -> np.ndarray:
        """Links' positions out of the plant's coordinates: all links, then the motors that are apart."""
        return np.eye(len(self.stiffness), len(self.stiffness) + len(self.elastic))

    @property
    def motors(self) -> np.ndarray:
        """Motors' positions, seen from the joints, out of the same, shape (n, n + m)."""
        n, out = len(self.stiffness), self.links
        out[self.elastic] = 0.0
        out[self.elastic, n + np.arange(len(self.elastic))] = 1.0
        return out

    def twist(self, torque: np.ndarray) -> np.ndarray:
        """How far motors are ahead of their links when they hold a torque (n,) [N m], shape (n,) [rad]."""
        return torque / self.stiffness + 0.5 * self.backlash * np.sign(torque)

    @property
    def springs(self) -> Elastic:
        """Its springs in the plant's coordinates."""
        joints = self.elastic
        stretch = (self.motors - self.links)[joints]
        return Elastic(
            stretch=stretch,
            back=stretch.T.copy(),
            stiffness=self.stiffness[joints],
            damping=self.damping[joints],
            play=0.5 * self.backlash[joints],
        )


def with_motors(model: Model, values: np.ndarray, elastic: np.ndarray) -> tuple[Model, np.ndarray]:
    """The model and its values (p,) with light motors on elastic joints whose motors have no inertia."""
    stated = dict(zip(model.names, map(float, values), strict=True))
    lacking = [joint for joint in elastic.tolist() if not stated.get(f"Ia{joint + 1}", 0.0) > 0.0]
    if not lacking:
        return model, values
    inertia = np.maximum(link_size(model)[0], TINY)
    for joint in lacking:
        if f"Ia{joint + 1}" not in stated:
            model = model + RotorInertia((model.robot.joints[joint],))
        stated[f"Ia{joint + 1}"] = LIGHT * float(inertia[joint])
    return model, np.array([stated[name] for name in model.names])


@dataclass(frozen=True, eq=False)
class Thermal:
    r"""First order, each joint alone: :math:`t_c \dot T = T_a + R_{th} (r i^2 + P_f) - T`.

    Attributes:
        ambient: Temperature :math:`T_a` around it, and at the start [degC].
        rise: Temperature above it per lost power :math:`R_{th}`, shape (n,) [K/W]; zero for none.
        resistance: Resistance of the winding :math:`r`, shape (n,) [ohm].
        time_constant: :math:`t_c` [s].
    """

    ambient: float
    rise: np.ndarray
    resistance: np.ndarray
    time_constant: float = 1800.0

    @classmethod
    def constant(cls, joints: int, ambient: float = 25.0) -> "Thermal":
        """Joints that stay as warm as they are."""
        return cls(ambient, np.zeros(joints), np.zeros(joints))

    def after(
        self, temperature: np.ndarray, current: np.ndarray, friction: np.ndarray, seconds: float
    ) -> np.ndarray:
        """Temperature (n,) [degC] after some time with current [A] and lost power of friction [W]."""
        end = self.ambient + self.rise * (self.resistance * current**2 + friction)
        return end + (temperature - end) * exp(-seconds / self.time_constant)
