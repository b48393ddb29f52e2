"""Driver: what every robot controller looks like from the loop.

A driver is opened, armed, and then exchanges one command for one sample a cycle. `exchange` blocks until the
next cycle, with either clock: the host (CAN, serial, mock) or the controller (KUKA RSI). Inside a
driver's file are its units, signs and telegrams; outside there are radians, amperes and newton metres only.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, ClassVar, Protocol

import numpy as np

from .errors import BadSettings
from .settings import listed_joints
from .values import Command, Sample


class StopLevel(IntEnum):
    """How hard to stop; a higher level overrides a lower one, and none is taken back.

    BRAKE is done by commands: the loop streams a jerk-limited stop, and a driver need not know. QUICK asks
    the controller to stop by its own means and hold; OFF takes the torque away, and an arm without brakes
    drops.
    """

    BRAKE = 1
    QUICK = 2
    OFF = 3


class Measured(Protocol):
    """What a simulated arm gives, each of shape (n,) and in the units of `Sample`."""

    @property
    def position(self) -> np.ndarray: ...  # noqa: D102
    @property
    def velocity(self) -> np.ndarray: ...  # noqa: D102
    @property
    def current(self) -> np.ndarray: ...  # noqa: D102
    @property
    def temperature(self) -> np.ndarray: ...  # noqa: D102


class Plant(Protocol):
    """A simulated arm with its drives: `exidyn.identification.simulation.plant` has one for any model."""

    def measure(self) -> Measured:
        """What its sensors measure now."""

    def step(self, position: np.ndarray, velocity: np.ndarray, seconds: float) -> None:
        """Follow a command (n,) [rad], [rad/s], which is reached at the end of these seconds."""


@dataclass(frozen=True)
class Arm:
    """What a driver needs to know of the arm.

    Attributes:
        joints: Names, in the order of every (n,) array.
        position_lower: Shape (n,) [rad].
        position_upper: Shape (n,) [rad].
        velocity: Largest speed, shape (n,) [rad/s].
        plant: Makes a simulated arm; only the mock asks.
    """

    joints: tuple[str, ...]
    position_lower: np.ndarray
    position_upper: np.ndarray
    velocity: np.ndarray
    plant: Callable[[], Plant] | None = None

    @property
    def dof(self) -> int:
        return len(self.joints)


@dataclass(frozen=True)
class Info:
    """Metadata of a driver once it is open.

    Attributes:
        cycle: Time between exchanges [s].
        clock: Whose clock it is: "host" or "controller".
        signals: What is measured: some of position, velocity, current, torque, temperature.
        dead_man: How the device stops by itself when the host falls silent, as verified; empty if not.
        window_lower: Most negative position command relative to where the arm stood when opened, shape (n,)
            [rad], as the controller allows it; None for no such window.
        window_upper: Most positive, likewise.
        settings: What explains the measurement later: scales, units, identities, versions.
        warnings: Warnings, a sentence each.
        listens: Whether it takes no commands: something else moves the arm.
        state: What samples hold of the controller's own state, such as a safety mode: names, and for each
            what its codes mean; nothing for a plain number.
    """

    cycle: float
    clock: str
    signals: tuple[str, ...]
    dead_man: str = ""
    window_lower: np.ndarray | None = None
    window_upper: np.ndarray | None = None
    settings: Mapping[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    listens: bool = False
    state: Mapping[str, Mapping[int, str]] = field(default_factory=dict)


class Driver(ABC):
    """One robot controller. A context manager that closes it.

    Args:
        settings: An instance of the driver's own `Settings`.
        arm: What it needs to know of the arm.

    Raises:
        BadSettings: Settings that do not fit each other, the arm or the bus.
    """

    Settings: ClassVar[type[Any]]
    """Frozen dataclass whose fields are made by `settings.setting`."""

    simulated: ClassVar[bool] = False
    """Whether nothing real moves, so that no confirmation is needed."""

    def __init__(self, settings: Any, arm: Arm) -> None:
        self.settings = settings
        self.arm = arm

    @classmethod
    def controller_file(cls, address: str) -> str:
        """Text of the file that the controller needs, for a host's address. Raises BadSettings for none."""
        raise BadSettings("this controller needs no file of its own; its settings are all in the host's")

    @property
    def in_real_time(self) -> bool:
        """Whether `exchange` keeps to a clock on the wall; a simulation may go as fast as it can."""
        return True

    @classmethod
    def count_joints(cls, table: Mapping[str, Any]) -> int:
        """Number of joints that a table of settings is for; 0 where not given."""
        return listed_joints(cls.Settings, table)

    @abstractmethod
    def open(self) -> Info:
        """Find the controller, configure and verify it. Nothing moves, nothing is powered.

        Raises DriverError, one of its kinds, with what to try.
        """

    def open_to_read(self) -> Info:
        """As `open`, for an arm that is only read: drives that are on stay on, drives that are off stay off.

        Until `close` there is nothing but `exchange(None)` and `states`.
        """
        return self.open()

    def find(self) -> None:
        """See whether the controller answers, and leave it as it is; nothing where to ask could move the arm.

        Raises DriverError if it does not.
        """
        if self.risk_of_reading:
            return
        try:
            self.open_to_read()
        finally:
            self.close()

    @property
    def sent_to_read(self) -> str:
        """What the controller is sent while an arm is only read, for a person."""
        return "nothing"

    @property
    def risk_of_reading(self) -> str:
        """What that may do to the arm, in a sentence; empty for nothing. Known before the driver is open."""
        return ""

    def states(self) -> tuple[str, ...]:
        """State of each drive, such as "torque off"; empty where it sends none.

        Between exchanges, whether drives are powered or not. A bus may be asked, which takes a few cycles.
        """
        return ("",) * self.arm.dof

    def arm_drives(self) -> None:  # noqa: B027 - many controllers have nothing to do
        """Power the drives, which then hold where they stand.

        Raises NotReady if they refuse, LinkLost if they do not answer.
        """

    @property
    def ready(self) -> bool:
        """Whether commands are taken; until then `exchange(None)` goes on with what must come before."""
        return True

    def held(self) -> np.ndarray | None:
        """Position that the drives are commanded to hold, shape (n,) [rad]; None if that is what is measured.

        None also before `arm_drives`, unless the controller holds the arm from `open` on. Commands begin
        there. A joint that bears a load stands away from it where the controller is a spring or corrects
        towards it, and would jump by as much if commands began where it stands.
        """
        return None

    @abstractmethod
    def exchange(self, command: Command | None) -> Sample:
        """Wait for the next cycle, hand over the command, and return what is measured in that cycle.

        None commands nothing: the arm stays where its controller holds it. A joint that does not answer
        gives NaN and is `stale`; a drive that has stopped itself is reported in `Sample.fault`, once and from
        then on. A silent controller is waited for at most 20 ms longer than a cycle. What comes from outside,
        however broken, raises nothing but these:

        Raises:
            LinkLost: No answer at all, for so long that waiting makes no sense.
        """

    def stop(self, level: StopLevel) -> None:  # noqa: B027 - likewise
        """Stop by the controller's own means; afterwards `exchange(None)` still listens where it can.

        A drive that follows positions holds the last command. A measured position is never a goal: if it is
        wrong, the stop sets the joint in motion. Neither waits for an answer nor raises.
        """

    @abstractmethod
    def close(self) -> None:
        """Leave the arm held or braked as its controller does by itself, and let go.

        Never raises, and may be called again.
        """

    def __enter__(self) -> "Driver":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
