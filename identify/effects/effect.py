"""Effect: one physical cause of joint torque.

Linear unknowns are regressor columns. Nonlinear unknowns are fields declared with `shape`. A choice
(which joint, which harmonic) is a plain field. Code that sums effects does not depend on which one it holds.

What is not an effect: what lies between the arm and its recordings (delays, clipped currents) and gears
that give way, which have a state of their own; see `measurements`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pinocchio as pin

from ..arm.motion import Motion
from ..arm.robot import Robot
from .simulator_terms import JointTerms, Spring

STEP = 1e-6
"""Of a central difference by position [rad] or velocity [rad/s]; its error is 1e-9 of what friction that
reverses over 3 mrad/s gains, and rounding adds as much."""
MOVED_BY = ("position", "velocity", "acceleration")
"""What of a motion columns may depend on, beside the load."""


@dataclass(frozen=True, eq=False)
class MotionGradient:
    """Derivatives of one number by a motion, each of shape (t, n); see `Motion` for units."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    load: np.ndarray

    def __add__(self, other: "MotionGradient") -> "MotionGradient":
        pairs = ((getattr(self, f.name), getattr(other, f.name)) for f in fields(self))
        return MotionGradient(*(one + two for one, two in pairs))

    @classmethod
    def none(cls, shape: tuple[int, ...]) -> "MotionGradient":
        """Zero everywhere."""
        return cls(*(np.zeros(shape) for _ in range(4)))


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


class Prior(NamedTuple):
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
        needs_temperature: Whether its columns depend on `Motion.temperature`.
        smooth: Whether its torque is a product of sines and powers of the motion, and so no more abrupt than
            it; friction that reverses within milliseconds is not.
        pointwise: Whether a sample's torque depends on that sample alone.
        linear: Whether its columns are a constant, plus multiples of velocity and acceleration, and nothing
            else: who simulates asks only once.
        massless: Whether acceleration does not change its torque: who simulates asks for no inertia.
        guessed: Whether nominal values are guesses at best, as of friction and offsets: they are fitted where
            all else is taken as nominal.
        inertial: Whether it is the inertia of bodies or of a rotor, which does not wear.
        of_links: Whether its parameters are those of the robot's links, `INERTIAL` of each, which the robot's
            description has.
        greased: Whether it is friction of grease, which changes with temperature.
        together: Name of what changes when all its parameters change by one share, such as the force of a
            spring whose gas leaks; empty where there is no such thing.
        plausible: Size of a parameter, at most with 68 %, of which nothing is stated [its unit].
    """

    transmitted: ClassVar[bool] = False
    needs_load: ClassVar[bool] = False
    needs_temperature: ClassVar[bool] = False
    smooth: ClassVar[bool] = False
    pointwise: ClassVar[bool] = True
    linear: ClassVar[bool] = False
    massless: ClassVar[bool] = False
    guessed: ClassVar[bool] = False
    inertial: ClassVar[bool] = False
    of_links: ClassVar[bool] = False
    greased: ClassVar[bool] = False
    together: ClassVar[str] = ""
    plausible: ClassVar[float] = np.inf

    @property
    def payload(self) -> str:
        """Name of the body on the flange whose torque it is, in runs that carry it; empty for none."""
        return ""

    @property
    def known(self) -> tuple[tuple[str, float], ...]:
        """What is known of that body: pairs of a name in `INERTIAL` and its value in SI units."""
        return ()

    @abstractmethod
    def parameters(self, robot: Robot) -> list[Parameter]:
        """Linear unknowns, one a regressor column."""

    @abstractmethod
    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        """Torque per unit of each parameter, shape (t, n, p) [N m / unit]."""

    def continued(self, robot: Robot, motion: Motion, memory: Any) -> tuple[np.ndarray, Any]:
        """Regressor (t, n, p) of the next piece of a run, and what has to be remembered for the one after.

        `memory` is what the piece before left; None for the first.
        """
        return self.regressor(robot, motion), None

    def known_torque(self, robot: Robot, motion: Motion) -> np.ndarray:
        """Torque that no parameter scales, shape (t, n) [N m]."""
        return np.zeros_like(motion.position)

    def bodies(self, robot: Robot, values: np.ndarray, payload: str) -> Mapping[int, pin.Inertia]:
        """The rigid bodies that make all of its torque, link -> inertia in the link's frame; else empty.

        For those who need the torque of parameters (p,) quickly, while the named payload is carried.
        """
        return {}

    def motion_gradient(
        self, robot: Robot, motion: Motion, weights: np.ndarray, known: np.ndarray
    ) -> MotionGradient:
        """Derivatives of sum(weights * regressor) + sum(known * known torque) by the motion.

        Weights are (t, n, p) and known (t, n), which an effect without known torque leaves aside. Unless an
        effect knows better, by central differences of all samples at once. What a memory carries from one
        sample to the next is left out: hysteresis reverses within milliradians.
        """
        return differences(self.regressor, robot, motion, weights, self.needs_load)

    def parameter_joints(self, robot: Robot) -> list[int | None]:
        """Joint at which each parameter acts, or whose link it is of; None where there is not one."""
        return [None] * len(self.parameters(robot))

    def portable(self, robot: Robot, values: np.ndarray) -> JointTerms | Spring | None:
        """Its torque for parameters (p,) in terms that simulators share; None where it is something else."""
        return None

    def shape_derivatives(self, robot: Robot, motion: Motion) -> dict[str, np.ndarray]:
        """Derivative of the regressor by each shape, shape name -> (t, n, p)."""
        return {}

    def priors(self, robot: Robot) -> Mapping[str, Prior]:
        """What the robot's description alone states about the parameters."""
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

    Columns (t, n, p) are of a robot and a motion, each sample from that sample alone, and depend on
    `Motion.load` if `load`. Weights are (t, n, p). Joints of a group are moved at once, since each joint's
    rows depend on it alone; without groups each is moved on its own, and its gain is that of all rows.
    Of position, velocity and acceleration, columns depend on `names` alone.
    """
    found = MotionGradient.none(motion.position.shape)
    for name in (*names, "load") if load else names:
        out, base = getattr(found, name), getattr(motion, name)
        for group in groups or [[joint] for joint in range(robot.dof)]:
            shift = np.zeros(robot.dof)
            shift[list(group)] = STEP * (1.0 if name in ("position", "velocity") else 1e3)
            sides = [columns(robot, replace(motion, **{name: base + s * shift})) for s in (1, -1)]
            gain = np.einsum("tnp,tnp->tn", weights, sides[0] - sides[1]) / (2 * shift.max())
            out[:, list(group)] = gain[:, list(group)] if len(group) > 1 else gain.sum(1, keepdims=True)
    return found


class Formula(NamedTuple):
    """Profiles of an effect.

    Attributes:
        function: Of position, velocity, load, temperature and the constants, a tuple of one profile a
            parameter of a joint; the same arithmetic for arrays and for single numbers.
        constants: Numbers beside the motion.
    """

    function: Callable[[Any, Any, Any, Any, tuple[float, ...]], tuple[Any, ...]]
    constants: tuple[float, ...] = (0.0,)


@dataclass(frozen=True)
class JointEffect(Effect):
    """An effect that acts on single joints, each with its own parameters.

    Attributes:
        joints: Names of the joints it acts on; None for all.
        dry: Whether each parameter is the dry friction of a joint [N m], which changes its sign at rest.
        moved_by: Of position, velocity and acceleration, those on which its columns depend.
    """

    joints: tuple[str, ...] | None = None

    massless: ClassVar[bool] = True
    dry: ClassVar[bool] = False
    moved_by: ClassVar[tuple[str, ...]] = MOVED_BY

    @property
    def formula(self) -> Formula | None:
        """Its profiles in arithmetic that can be compiled; None where it has no such form."""
        return None

    def profiles(self, motion: Motion) -> tuple[np.ndarray, ...]:
        """What `formula` gives along a motion, one profile (t, n) a parameter of a joint."""
        assert self.formula is not None
        function, constants = self.formula
        return function(motion.position, motion.velocity, motion.load, motion.temperature, constants)

    def columns(self, robot: Robot) -> list[int]:
        """Indices of the joints it acts on; raises `UnknownJoint` for a name that the robot does not have."""
        if self.joints is None:
            return list(range(robot.dof))
        return [robot.index(joint) for joint in self.joints]

    def on_each(self, robot: Robot, *kinds: tuple[Any, ...]) -> list[Parameter]:
        """Parameters joint by joint, of letters before its number, unit where it turns, and minimum."""
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
        """Terms of `portable` from the values (j,) of each on its joints."""
        columns = self.columns(robot)
        every = {name: np.zeros(robot.dof) for name in values}
        for name, own in values.items():
            every[name][columns] = own
        return JointTerms.of(robot.dof, **every)

    def apart(self, robot: Robot) -> list[Effect]:
        return [replace(self, joints=(robot.joints[joint],)) for joint in self.columns(robot)]

    def on_joints(self, robot: Robot, *profiles: np.ndarray) -> np.ndarray:
        """Regressor whose columns are, joint by joint, the given profiles, each (t, n)."""
        count, shape = len(profiles), profiles[0].shape
        if self.joints is None:  # all at once, along the diagonal: a plant asks every tick
            every = np.zeros((len(profiles[0]), count * shape[1] ** 2))
            for which, profile in enumerate(profiles):
                every[:, which :: count * (shape[1] + 1)] = profile
            return every.reshape(*shape, -1)
        columns = self.columns(robot)
        regressor = np.zeros((*shape, count * len(columns)))
        for place, joint in enumerate(columns):
            for which, profile in enumerate(profiles):
                regressor[:, joint, count * place + which] = profile[:, joint]
        return regressor
