"""Driver: the interface between the control loop and every robot controller.

A driver is opened, armed, and then exchanges one command for one sample per cycle. `exchange` blocks until
the next cycle, whether the host keeps the clock (CAN, serial, mock) or the controller does (KUKA RSI). Units,
signs and telegrams of a controller stay inside its driver; outside there are only radians, amperes and
newton meters.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, ClassVar, Protocol

import numpy as np

from .errors import BadSettings
from .host_clock import HOST, Clock
from .settings import listed_joints
from .values import Command, Sample


class StopLevel(IntEnum):
    """How hard to stop; a higher level overrides a lower one, and no stop is taken back.

    BRAKE is a controlled stop: the loop streams jerk-limited commands, and the driver need not be told. QUICK
    is a quick stop: the controller stops the arm by itself and holds it. OFF is power off: an arm without
    brakes drops.
    """

    BRAKE = 1
    QUICK = 2
    OFF = 3


class Measured(Protocol):
    """Measurements of a simulated arm, each of shape (n,) and in the units of `Sample`."""

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
        """Return the current sensor readings."""

    def step(self, position: np.ndarray, velocity: np.ndarray, seconds: float) -> None:
        """Follow a command (n,) [rad], [rad/s] that is reached after `seconds`."""


@dataclass(frozen=True)
class Arm:
    """What a driver needs to know about the arm."""

    joints: tuple[str, ...]  # names of the joints, in the order of every (n,) array
    position_lower: np.ndarray  # lower position limits, shape (n,) [rad]
    position_upper: np.ndarray  # upper position limits, shape (n,) [rad]
    velocity: np.ndarray  # velocity limits, shape (n,) [rad/s]
    plant: Callable[[], Plant] | None = None  # function that creates a simulated arm; only the mock uses it

    @property
    def dof(self) -> int:
        return len(self.joints)


@dataclass(frozen=True)
class Info:
    """Metadata of a driver once it is open."""

    cycle: float  # time between exchanges [s]
    clock: str  # which clock sets the cycle: "host" or "controller"
    signals: tuple[str, ...]  # measured signals: some of position, velocity, current, torque, temperature
    # How the device stops by itself when the host falls silent; empty if this is not verified.
    dead_man: str = ""
    # Most negative position command that the controller allows, relative to the position at opening, shape
    # (n,) [rad]; None without such a window.
    window_lower: np.ndarray | None = None
    # Most positive position command, relative to the same position, shape (n,) [rad].
    window_upper: np.ndarray | None = None
    # Facts that explain the measurements later: scales, units, serial numbers, versions.
    settings: Mapping[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()  # warnings, a sentence each
    listens: bool = False  # whether the driver takes no commands because something else moves the arm
    # Parts of the controller's state in each sample, such as a safety mode: name -> meaning of its codes; an
    # empty mapping for a plain number.
    state: Mapping[str, Mapping[int, str]] = field(default_factory=dict)


class Driver(ABC):
    """One robot controller. A context manager that closes it.

    Args:
        settings: An instance of the `Settings` of this driver.
        arm: The arm to drive.

    Raises:
        BadSettings: If the settings do not fit each other, the arm or the bus.
    """

    Settings: ClassVar[type[Any]]
    """Frozen dataclass whose fields are declared by `settings.setting`."""

    simulated: ClassVar[bool] = False
    """Whether nothing real moves, so that no confirmation is needed."""

    fixed_joints: ClassVar[int] = 0
    """Number of joints of every arm of this controller; 0 if it drives arms with any number."""

    clock: Clock = HOST
    """Clock by which the driver and its run measure and wait."""

    def __init__(self, settings: Any, arm: Arm) -> None:
        self.settings = settings
        self.arm = arm

    @classmethod
    def controller_file(cls, address: str) -> str:
        """Text of the file that the controller needs, with the address of the host.

        Raises BadSettings if the controller needs no file.
        """
        raise BadSettings("this controller needs no file; the driver's settings contain everything")

    @property
    def in_real_time(self) -> bool:
        """Whether `exchange` runs in real time; a simulation may run as fast as it can."""
        return True

    @classmethod
    def count_joints(cls, table: Mapping[str, Any]) -> int:
        """Number of joints for which a table has settings; 0 if the table does not say."""
        return cls.fixed_joints or listed_joints(cls.Settings, table)

    @abstractmethod
    def open(self) -> Info:
        """Find the controller, configure and verify it, without moving or powering anything.

        Raises a subclass of DriverError whose message says what to try.
        """

    def open_to_read(self) -> Info:
        """Open for reading only: drives that are on stay on, drives that are off stay off.

        Until `close`, only `exchange(None)` and `states` may be called.
        """
        return self.open()

    def find(self) -> None:
        """Check that the controller answers, and leave it as it is. Do nothing if asking could move the arm.

        Raises DriverError if the controller does not answer.
        """
        if self.risk_of_reading:
            return
        try:
            self.open_to_read()
        finally:
            self.close()

    @property
    def sent_to_read(self) -> str:
        """What is sent to the controller while the arm is only read, in words."""
        return "nothing"

    @property
    def risk_of_reading(self) -> str:
        """What reading may do to the arm, in a sentence; empty if nothing. Known before opening."""
        return ""

    def states(self) -> tuple[str, ...]:
        """State of each drive, such as "torque off"; empty where a drive sends none.

        May be called between exchanges, with drives on or off. It may query the bus for a few cycles.
        """
        return ("",) * self.arm.dof

    def arm_drives(self) -> None:  # noqa: B027 - many controllers have nothing to do
        """Power the drives, which then hold their positions.

        Raises NotReady if they refuse, LinkLost if they do not answer.
        """

    @property
    def ready(self) -> bool:
        """Whether commands are taken; until then, `exchange(None)` continues the preparation."""
        return True

    def held(self) -> np.ndarray | None:
        """Position that the drives are commanded to hold, shape (n,) [rad], where commands must begin.

        None if commands begin at the measured position; None also before `arm_drives`, unless the controller
        holds the arm from `open` on. Under load, a compliant controller lets a joint deviate from its target;
        commands that began at the measured position would make the joint jump by this deviation.
        """
        return None

    @abstractmethod
    def exchange(self, command: Command | None) -> Sample:
        """Wait for the next cycle, send the command, and return the sample measured in that cycle.

        None commands nothing: the arm stays where its controller holds it. A joint that does not answer
        gives NaN and is `stale`. A drive that has stopped itself is reported in `Sample.fault`, from then on
        in every sample. Waiting for a silent controller takes at most 20 ms longer than a cycle. However
        broken the received data are, no other error is raised:

        Raises:
            LinkLost: If nothing has answered for so long that waiting makes no sense.
        """

    def stop(self, level: StopLevel) -> None:  # noqa: B027 - many controllers have nothing to do
        """Make the controller stop the arm; afterwards `exchange(None)` still listens where it can.

        A position-controlled drive holds the last command. A measured position is never the goal: if it is
        wrong, the stop would set the joint in motion. This neither waits for an answer nor raises.
        """

    @abstractmethod
    def close(self) -> None:
        """Leave the arm to its controller, which holds or brakes it, and close the connection.

        Never raises, and may be called again.
        """

    def __enter__(self) -> "Driver":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
