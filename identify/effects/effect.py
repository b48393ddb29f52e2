"""Effect: one physical cause of joint torque.

Linear parameters are regressor columns. Nonlinear parameters are fields declared with `shape`. A choice
(joint, harmonic) is a plain field. Code that sums effects does not depend on their types.

Delays and clipped currents, which lie between the arm and its recordings, and elastic gears, which have their
own state, are not effects; see `measurements`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pinocchio as pin

from ..arm.motion import Motion
from ..arm.robot import Robot
from .joint_state import JointState, Scalar
from .simulator_terms import JointTerms, Spring

STEP = 1e-6
"""Step of a central difference in position [rad] or velocity [rad/s]. Its error is 1e-9 of the derivative of
friction that reverses over 3 mrad/s, and the rounding error is as large."""
MOVED_BY = ("position", "velocity", "acceleration")
"""Parts of a motion on which columns may depend, in addition to the load."""


@dataclass(frozen=True, eq=False)
class MotionGradient:
    """Derivatives of a number with respect to a motion, each of shape (t, n); see `Motion` for units."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    load: np.ndarray

    def __add__(self, other: "MotionGradient") -> "MotionGradient":
        pairs = ((getattr(self, f.name), getattr(other, f.name)) for f in fields(self))
        return MotionGradient(*(a + b for a, b in pairs))

    @classmethod
    def none(cls, shape: tuple[int, ...]) -> "MotionGradient":
        """Gradient that is zero everywhere."""
        return cls(*(np.zeros(shape) for _ in range(4)))


class Parameter(NamedTuple):
    """One linear parameter."""

    name: str  # name that is unique within a model, in the usual notation, such as "ZZ1" or "Fv3"
    unit: str  # SI unit
    minimum: float = -np.inf  # smallest value that is physically possible
    regroup: int = 1  # rank in the selection of base parameters; high ranks are regrouped into low ones


class Prior(NamedTuple):
    """Prior of a parameter: value and standard deviation."""

    value: float
    std: float = np.inf


class Shape(NamedTuple):
    """Unit and bounds of a nonlinear parameter."""

    unit: str
    low: float
    high: float


def shape(default: float | None, unit: str, low: float, high: float) -> Any:
    """Declare a nonlinear parameter as a dataclass field; without a default, it is required."""
    metadata = {"shape": Shape(unit, low, high)}
    return field(metadata=metadata) if default is None else field(default=default, metadata=metadata)


@dataclass(frozen=True)
class Effect(ABC):
    """One physical effect; a model is a sum of effects."""

    # Whether the gear transmits the torque (inertia, gravity, springs on the link), which then loads its
    # friction; friction itself and the rotor are not transmitted.
    transmitted: ClassVar[bool] = False
    needs_load: ClassVar[bool] = False  # whether the columns depend on `Motion.load`
    needs_temperature: ClassVar[bool] = False  # whether the columns depend on `Motion.temperature`
    # Whether the torque is a product of sines and powers of the motion, and so as smooth as the motion;
    # friction that reverses within milliseconds is not.
    smooth: ClassVar[bool] = False
    pointwise: ClassVar[bool] = True  # whether the torque at a sample depends only on that sample
    # Whether the columns are only a constant plus multiples of velocity and acceleration, so that a
    # simulation needs to compute them only once.
    linear: ClassVar[bool] = False
    # Whether the torque is independent of acceleration, so that a simulation needs no inertia.
    massless: ClassVar[bool] = False
    # Whether nominal values are only guesses, as for friction and offsets; they are then fitted even where
    # all other parameters are nominal.
    guessed: ClassVar[bool] = False
    # Whether the parameters are the inertial parameters of the robot's links, which are part of the robot
    # description.
    of_links: ClassVar[bool] = False
    greased: ClassVar[bool] = False  # whether it is friction of grease, which changes with temperature

    @property
    def payload(self) -> str:
        """Name of the payload that causes the torque in runs that carry it; empty for none."""
        return ""

    @property
    def known(self) -> tuple[tuple[str, float], ...]:
        """Known parameters of the payload: pairs of a name in `INERTIAL` and its value in SI units."""
        return ()

    @abstractmethod
    def parameters(self, robot: Robot) -> list[Parameter]:
        """Linear parameters, one per regressor column."""

    @abstractmethod
    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        """Torque per unit of each parameter, shape (t, n, p) [N m / unit]."""

    def continued(self, robot: Robot, motion: Motion, memory: Any) -> tuple[np.ndarray, Any]:
        """Regressor (t, n, p) of the next piece of a run, and the memory for the piece after it.

        `memory` is the memory returned for the previous piece; None for the first piece.
        """
        return self.regressor(robot, motion), None

    def known_torque(self, robot: Robot, motion: Motion) -> np.ndarray:
        """Torque that no parameter scales, shape (t, n) [N m]."""
        return np.zeros_like(motion.position)

    def bodies(self, robot: Robot, values: np.ndarray, payload: str) -> Mapping[int, pin.Inertia]:
        """Rigid bodies that cause all of the torque, link -> inertia in the link's frame; else empty.

        They allow fast computation of the torque for parameters (p,) while the named payload is carried.
        """
        return {}

    def motion_gradient(
        self, robot: Robot, motion: Motion, weights: np.ndarray, known: np.ndarray
    ) -> MotionGradient:
        """Derivatives of sum(weights * regressor) + sum(known * known torque) with respect to the motion.

        `weights` is (t, n, p) and `known` (t, n); an effect without known torque ignores `known`. The default
        uses central differences of all samples at once. The influence of a memory on later samples is
        neglected: hysteresis reverses within milliradians.
        """
        return differences(self.regressor, robot, motion, weights, self.needs_load)

    def parameter_joints(self, robot: Robot) -> list[int | None]:
        """Joint on which each parameter acts, or joint of its link; None if there is no single joint."""
        return [None] * len(self.parameters(robot))

    def portable(self, robot: Robot, values: np.ndarray) -> JointTerms | Spring | None:
        """Torque for parameters (p,) in terms that simulators share; None if it has no such form."""
        return None

    def link_parameters(self, robot: Robot, values: np.ndarray, payload: str) -> np.ndarray | None:
        """Ten parameters of each link that cause all of the torque, in `INERTIAL` order, shape (n, 10).

        They belong to parameters (p,) while the named payload is carried, and need not be those of a body
        that can exist. None for an effect that is not the inertia of links.
        """
        return None

    def joint_torque(self, robot: Robot, values: np.ndarray, state: JointState) -> Sequence[Scalar] | None:
        """Torque of each joint for parameters (p,), from scalars that may be symbols of a written program.

        The acceleration enters linearly, with constant factors. None for an effect without this form: the
        inertia of links, and effects with memory.
        """
        return None

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        """Derivative of the regressor with respect to each shape: shape name -> (t, n, p)."""
        return {}

    def priors(self, robot: Robot) -> Mapping[str, Prior]:
        """Priors of the parameters from the robot description alone."""
        return {}

    def inertias(self, robot: Robot) -> list[slice]:
        """Columns of each rigid body's ten inertial parameters, in `INERTIAL` order."""
        return []

    def apart(self, robot: Robot) -> "list[Effect]":
        """Effect split into effects whose shapes may differ, one per joint on which it acts."""
        return [self]

    @classmethod
    def shapes(cls) -> dict[str, Shape]:
        """Nonlinear parameters: field name -> unit and bounds."""
        return {f.name: f.metadata["shape"] for f in fields(cls) if "shape" in f.metadata}


def differences(
    columns: Callable[[Robot, Motion], np.ndarray],
    robot: Robot,
    motion: Motion,
    weights: np.ndarray,
    load: bool,
    groups: Sequence[Sequence[int]] | None = None,
    names: Sequence[str] = MOVED_BY,
) -> MotionGradient:
    """Derivatives of sum(weights * columns) by central differences.

    `columns` returns an array (t, n, p) for a robot and a motion, each sample from that sample alone, and
    depends on `Motion.load` if `load` is true. `weights` is (t, n, p). Joints of a group are moved together,
    which requires that each joint's rows depend only on that joint. Without groups, each joint is moved
    alone, and its derivative sums over all rows. Of position, velocity and acceleration, columns depend on
    `names`.
    """
    gradient = MotionGradient.none(motion.position.shape)
    for name in (*names, "load") if load else names:
        out, base = getattr(gradient, name), getattr(motion, name)
        for group in groups or [[joint] for joint in range(robot.dof)]:
            shift = np.zeros(robot.dof)
            shift[list(group)] = STEP * (1.0 if name in ("position", "velocity") else 1e3)
            sides = [columns(robot, replace(motion, **{name: base + s * shift})) for s in (1, -1)]
            gain = np.einsum("tnp,tnp->tn", weights, sides[0] - sides[1]) / (2 * shift.max())
            out[:, list(group)] = gain[:, list(group)] if len(group) > 1 else gain.sum(1, keepdims=True)
    return gradient


@dataclass(frozen=True)
class JointEffect(Effect):
    """An effect that acts on single joints, each with its own parameters."""

    joints: tuple[str, ...] | None = None  # names of the joints on which it acts; None for all

    massless: ClassVar[bool] = True
    # Whether each parameter is the dry friction of a joint [N m], which changes its sign at rest.
    dry: ClassVar[bool] = False
    # Parts of the motion (position, velocity, acceleration) on which the columns depend.
    moved_by: ClassVar[tuple[str, ...]] = MOVED_BY
    # Letters, unit and minimum of each parameter of a joint, as `on_each` takes them.
    coefficients: ClassVar[tuple[tuple[Any, ...], ...]] = ()

    def parameters(self, robot: Robot) -> list[Parameter]:
        return self.on_each(robot, *self.coefficients)

    def profiles(self, at: Any) -> tuple[Any, ...]:
        """Torque per unit of each parameter of a joint, if it depends only on the state of that joint.

        `at` is a motion, then profiles are arrays (t, n), or a `JointState` of scalars.
        """
        raise NotImplementedError

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, *self.profiles(motion))

    def joint_torque(self, robot: Robot, values: np.ndarray, state: JointState) -> Sequence[Scalar] | None:
        if type(self).profiles is JointEffect.profiles:
            return None
        return self.on_scalars(
            robot, values, lambda j: self.profiles(JointState(*(part[j] for part in state)))
        )

    def on_scalars(
        self, robot: Robot, values: np.ndarray, profiles: Callable[[int], Sequence[Scalar]]
    ) -> Sequence[Scalar]:
        """Sum of parameters (p,) times the profiles of each joint, a function of the joint's index."""
        torque, joints = [0.0] * robot.dof, self.columns(robot)
        for joint, factors in zip(joints, values.reshape(len(joints), -1), strict=True):
            pairs = zip(factors, profiles(joint), strict=True)
            torque[joint] = sum(float(factor) * profile for factor, profile in pairs)
        return torque

    def columns(self, robot: Robot) -> list[int]:
        """Indices of the joints on which it acts; raises `UnknownJoint` for an unknown name."""
        if self.joints is None:
            return list(range(robot.dof))
        return [robot.index(joint) for joint in self.joints]

    def on_each(self, robot: Robot, *kinds: tuple[Any, ...]) -> list[Parameter]:
        """Parameters joint by joint, from letters before the joint number, unit if revolute, and minimum."""
        return [
            Parameter(f"{letters}{joint + 1}", robot.unit(joint, unit), *minimum)
            for joint in self.columns(robot)
            for letters, unit, *minimum in kinds
        ]

    def motion_gradient(
        self, robot: Robot, motion: Motion, weights: np.ndarray, known: np.ndarray
    ) -> MotionGradient:
        return differences(
            self.regressor, robot, motion, weights, self.needs_load, [self.columns(robot)], self.moved_by
        )

    def parameter_joints(self, robot: Robot) -> list[int | None]:
        columns = self.columns(robot)
        each = len(self.parameters(robot)) // max(len(columns), 1)
        return [joint for joint in columns for _ in range(each)]

    def terms(self, robot: Robot, **values: np.ndarray) -> JointTerms:
        """Joint terms for `portable` from values (j,) for the joints on which the effect acts."""
        columns = self.columns(robot)
        terms = {name: np.zeros(robot.dof) for name in values}
        for name, on_joints in values.items():
            terms[name][columns] = on_joints
        return JointTerms.of(robot.dof, **terms)

    def apart(self, robot: Robot) -> list[Effect]:
        return [replace(self, joints=(robot.joints[joint],)) for joint in self.columns(robot)]

    def on_joints(self, robot: Robot, *profiles: np.ndarray) -> np.ndarray:
        """Regressor with the given profiles, each (t, n), as columns of each joint."""
        count, shape = len(profiles), profiles[0].shape
        if self.joints is None:  # fast path along the diagonal: simulations evaluate this at every time step
            flat = np.zeros((len(profiles[0]), count * shape[1] ** 2))
            for k, profile in enumerate(profiles):
                flat[:, k :: count * (shape[1] + 1)] = profile
            return flat.reshape(*shape, -1)
        columns = self.columns(robot)
        regressor = np.zeros((*shape, count * len(columns)))
        for place, joint in enumerate(columns):
            for k, profile in enumerate(profiles):
                regressor[:, joint, count * place + k] = profile[:, joint]
        return regressor
