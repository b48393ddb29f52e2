"""What the tests of every driver need of its peer: a file of the driver's name, with a `PEER`."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from importlib import import_module

from exidyn.drivers import DRIVERS, driver_class


@dataclass(frozen=True)
class DriverPeer:
    """A driver's peer."""

    # gives the process and settings that reach it, with lists for six joints: a context manager of a folder
    # for its files and more of its command line
    running: Callable[..., AbstractContextManager]
    joints: int = 6  # of its arm
    states: str = "torque off"  # what the driver's `states` gives of each joint without power
    powered: tuple[str, ...] = ()  # words that it prints when drives are powered or moved
    # whether no drive is powered and nothing was commanded, of a process and a number of samples; without it,
    # that no word of `powered` was printed
    is_off: Callable[..., bool] | None = None
    hasty: dict = field(default_factory=dict)  # settings with which a driver gives up early
    # more of its command line, for the built-in cobot and a cycle a question; None for another arm
    cobot: tuple[object, ...] | None = ("--robot", "cobot", "--lockstep")
    pose: tuple[float, ...] = (0.0, -90.0, 0.0, 0.0, 0.0, 0.0)  # where that stands [deg]
    patient: dict = field(default_factory=dict)  # settings for a machine that is busy with other things

    def off(self, process, samples=0):
        """Whether no drive is powered and nothing was commanded, by its own account."""
        if self.is_off:
            return self.is_off(process, samples)
        return not any(word in line for word in self.powered for line in (process.lines if process else ()))


def peer_of(name) -> DriverPeer:
    return import_module(f".{name}", __name__).PEER


REAL = [name for name in DRIVERS if not driver_class(name).simulated]
"""Drivers that have a peer process."""
