"""Robot controllers: one folder a driver, one line in this table. Needs numpy and the bus libraries only."""

from collections.abc import Mapping
from importlib import import_module
from typing import Any, NamedTuple

from .driver import Arm, Driver, Info, StopLevel
from .errors import DriverError, MissingPackage, UnknownDriver
from .settings import read_settings, template
from .values import Command, Sample

__all__ = [
    "DRIVERS", "Arm", "Command", "Driver", "DriverError", "Info", "MissingPackage", "Sample", "StopLevel",
    "create", "driver_class", "explain",
]  # fmt: skip


class Entry(NamedTuple):
    """A driver.

    Attributes:
        place: "module:Class" in this package, imported when it is asked for.
        purpose: What it drives.
        extra: Extra of the package that brings the libraries that it needs.
    """

    place: str
    purpose: str
    extra: str = ""


DRIVERS: dict[str, Entry] = {
    "mock": Entry("mock.driver:Mock", "a simulated arm with drives, encoders and noise; nothing moves"),
    "kuka_rsi": Entry(
        "kuka_rsi.driver:KukaRsi", "KUKA KRC2, KRC4, KRC5 by Robot Sensor Interface (UDP), 83 or 250 Hz"
    ),
    "ur_rtde": Entry(
        "ur_rtde.driver:UrRtde", "Universal Robots CB3, e-Series and later by RTDE (TCP), 125 or 500 Hz"
    ),
    "franka": Entry("franka.driver:Franka", "Franka Research 3 by the FCI, 1 kHz", "franka"),
    "canopen_402": Entry(
        "canopen_402.driver:Canopen402", "CiA 402 drives on CAN, cyclic synchronous position, 500 Hz", "can"
    ),
    "can_mit": Entry("can_mit.driver:CanMit", "motors with the MIT frame on CAN: Damiao, T-Motor AK", "can"),
    "dynamixel": Entry(
        "dynamixel.driver:Dynamixel", "Dynamixel servos, protocol 2.0, on a serial port", "serial"
    ),
    "feetech": Entry("feetech.driver:Feetech", "Feetech STS and SMS servos on a serial port", "serial"),
}


def driver_class(name: str) -> type[Driver]:
    """The class of a driver.

    Raises:
        UnknownDriver: A name that is not in the table.
        MissingPackage: A library that it needs is not installed.
    """
    if name not in DRIVERS:
        raise UnknownDriver(name, DRIVERS)
    place, _, extra = DRIVERS[name]
    module, which = place.split(":")
    try:
        return getattr(import_module(f"{__name__}.{module}"), which)
    except ModuleNotFoundError as error:
        if not extra or (error.name or "").startswith("exidyn"):
            raise
        raise MissingPackage(name, error.name, extra) from error


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
