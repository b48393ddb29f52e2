"""The errors of drivers, each a fact with a value, a limit and what to try.

DriverError
├── UnknownDriver     a name that is not in the table
├── BadSettings       settings that are missing, unknown or out of range, or a bus that cannot carry them
├── NotReady          the controller is there and refuses to begin
├── LinkLost          nothing comes back, or nothing that can be read
└── DriveFault        a drive has stopped itself
"""

from collections.abc import Iterable


class DriverError(Exception):
    """Base of every error a driver raises; its text is meant for the user."""


class UnknownDriver(DriverError, LookupError):
    """A name that is not in the table; the message lists the valid ones."""

    def __init__(self, name: str, valid: Iterable[str]) -> None:
        super().__init__(f"unknown driver '{name}'. Valid: {', '.join(valid)}")


class BadSettings(DriverError, ValueError):
    """Settings that are missing, unknown or out of range, or that the bus cannot carry."""


class NotReady(DriverError):
    """The controller is there and refuses to begin."""


class LinkLost(DriverError):
    """Nothing comes back from the controller, or nothing that can be read."""


class DriveFault(DriverError):
    """A drive has stopped itself."""
