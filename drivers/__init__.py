"""Robot controllers: one file a driver, one line in this table. Needs numpy and the bus libraries only."""

from collections.abc import Mapping
from importlib import import_module
from typing import Any, NamedTuple

from .driver import Arm, Command, Driver, Info, Sample, StopLevel
from .errors import DriverError, UnknownDriver
from .settings import read_settings, template

__all__ = [
    "DRIVERS", "Arm", "Command", "Driver", "DriverError", "Info", "Sample", "StopLevel", "create",
    "driver_class", "explain",
]  # fmt: skip


class Entry(NamedTuple):
    """A driver: "module:Class" in this package, imported when it is asked for, and what it drives."""

    place: str
    purpose: str


DRIVERS: dict[str, Entry] = {
    "mock": Entry("mock.driver:Mock", "a simulated arm with drives, encoders and noise; nothing moves"),
    "kuka_rsi": Entry(
        "kuka_rsi.driver:KukaRsi", "KUKA KRC2, KRC4, KRC5 by Robot Sensor Interface (UDP), 83 or 250 Hz"
    ),
    "canopen_402": Entry(
        "canopen_402.driver:Canopen402", "CiA 402 drives on CAN, cyclic synchronous position, 500 Hz"
    ),
    "can_mit": Entry("can_mit.driver:CanMit", "motors with the MIT frame on CAN: Damiao, T-Motor AK"),
    "dynamixel": Entry("dynamixel.driver:Dynamixel", "Dynamixel servos, protocol 2.0, on a serial port"),
    "feetech": Entry("feetech.driver:Feetech", "Feetech STS and SMS servos on a serial port"),
}


def driver_class(name: str) -> type[Driver]:
    """The class of a driver.

    Raises:
        UnknownDriver: A name that is not in the table.
    """
    if name not in DRIVERS:
        raise UnknownDriver(name, DRIVERS)
    module, which = DRIVERS[name].place.split(":")
    return getattr(import_module(f"{__name__}.{module}"), which)


def create(name: str, table: Mapping[str, Any], arm: Arm) -> Driver:
    """A driver that is not open yet, from its settings.

    Raises:
        UnknownDriver: A name that is not in the table.
        BadSettings: What the driver cannot be set to.
    """
    cls = driver_class(name)
    return cls(read_settings(cls.Settings, table, arm.dof, f"driver {name}"), arm)


def explain(name: str) -> str:
    """A TOML file with all settings of a driver, to be filled in.

    Raises:
        UnknownDriver: A name that is not in the table.
    """
    settings = template(driver_class(name).Settings)
    return f'# {DRIVERS[name].purpose}\ndriver = "{name}"\n\n[settings]\n{settings}'
