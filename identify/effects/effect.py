"""Effect: one physical cause of joint torque.

Linear unknowns are regressor columns. Nonlinear unknowns are fields declared with `shape`. A choice
(which joint, which harmonic) is a plain field. Whoever sums effects never asks which one it holds.

What is not an effect: faults of the measurement (delay, gain, encoder zero), which are corrections of
the data, and elasticity or backlash, which have a state of their own.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..motion import Motion
from ..robot import Robot


class Parameter(NamedTuple):
    """One linear unknown.

    Attributes:
        name: Unique within a model, in the field's notation, such as "ZZ1" or "Fv3".
        unit: SI unit.
        minimum: Smallest value that physics allows.
        regroup: Base parameters are taken in this order; what comes late is regrouped into the rest.
    """

    name: str
    unit: str
    minimum: float = -np.inf
    regroup: int = 1


class Belief(NamedTuple):
    """What is held true of a parameter before looking at data: value and standard deviation."""

    value: float
    std: float = np.inf


class Shape(NamedTuple):
    """A nonlinear unknown: unit and the bounds within which it makes sense."""

    unit: str
    low: float
    high: float


def shape(default: float | None, unit: str, low: float, high: float) -> Any:
    """Declare a nonlinear unknown as a dataclass field; without a default it must be given."""
    metadata = {"shape": Shape(unit, low, high)}
    return field(metadata=metadata) if default is None else field(default=default, metadata=metadata)


@dataclass(frozen=True)
class Effect(ABC):
    """One physical effect, of which a model is the sum.

    Attributes:
        transmitted: Whether the torque passes through the gear (inertia, gravity, springs on the
            link), and so loads its friction; friction itself and the rotor do not.
        needs_load: Whether its columns depend on `Motion.load`.
        smooth: Whether its torque is a product of sines and powers of the motion, and so no more abrupt than
            it; friction that turns within milliseconds is not.
        pointwise: Whether a sample's torque depends on that sample alone.
    """

    transmitted: ClassVar[bool] = False
    needs_load: ClassVar[bool] = False
    smooth: ClassVar[bool] = False
    pointwise: ClassVar[bool] = True

    @abstractmethod
    def parameters(self, robot: Robot) -> list[Parameter]:
        """Linear unknowns, one a regressor column."""

    @abstractmethod
    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        """Torque per unit of each parameter, shape (t, n, p) [N m / unit]."""

    def known_torque(self, robot: Robot, motion: Motion) -> np.ndarray:
        """Torque that no parameter scales, shape (t, n) [N m]."""
        return np.zeros_like(motion.position)

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        """Derivative of the regressor by each shape, shape name -> (t, n, p)."""
        return {}

    def beliefs(self, robot: Robot) -> Mapping[str, Belief]:
        """What the robot's description alone says about the parameters."""
        return {}

    def inertias(self, robot: Robot) -> list[slice]:
        """Columns that are the ten inertial parameters of one rigid body, in `INERTIAL` order."""
        return []

    def apart(self, robot: Robot) -> "list[Effect]":
        """The same effect in pieces that may differ in shape: one a joint, where it acts on several."""
        return [self]

    @classmethod
    def shapes(cls) -> dict[str, Shape]:
        """Nonlinear unknowns: field name -> unit and bounds."""
        return {f.name: f.metadata["shape"] for f in fields(cls) if "shape" in f.metadata}


@dataclass(frozen=True)
class JointEffect(Effect):
    """An effect that acts on single joints, each with its own parameters.

    Attributes:
        joints: Names of the joints it acts on; None for all.
    """

    joints: tuple[str, ...] | None = None

    def columns(self, robot: Robot) -> list[int]:
        """Indices of the joints it acts on.

        Raises:
            UnknownJoint: A name that the robot does not have.
        """
        if self.joints is None:
            return list(range(robot.dof))
        return [robot.index(joint) for joint in self.joints]

    def apart(self, robot: Robot) -> list[Effect]:
        return [replace(self, joints=(robot.joints[joint],)) for joint in self.columns(robot)]

    def on_joints(self, robot: Robot, *profiles: np.ndarray) -> np.ndarray:
        """Regressor whose columns are, joint by joint, the given profiles, each (t, n)."""
        columns = self.columns(robot)
        count = len(profiles)
        regressor = np.zeros((*profiles[0].shape, count * len(columns)))
        for place, joint in enumerate(columns):
            for which, profile in enumerate(profiles):
                regressor[:, joint, count * place + which] = profile[:, joint]
        return regressor
