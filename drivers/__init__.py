"""Robot controllers: one folder and one line in this table per driver. Needs numpy and bus libraries only."""

from collections.abc import Mapping
from importlib import import_module, metadata
from typing import Any, NamedTuple

from .driver import Arm, Driver, Info, StopLevel
from .errors import BadDriver, DriverError, MissingPackage, UnknownDriver
from .settings import read_settings, template
from .values import Command, Sample

__all__ = [
    "DRIVERS", "Arm", "Command", "Driver", "DriverError", "Info", "MissingPackage", "Sample", "StopLevel",
    "create", "driver_class", "explain", "known_drivers",
]  # fmt: skip

GROUP = "exidyn.drivers"
"""Group of entry points in which installed packages register drivers: name -> subclass of `Driver`."""


class Entry(NamedTuple):
    """Where the class of a driver is, what it drives, and what it needs."""

    place: str  # "module:Class", imported on first use
    purpose: str  # what the driver drives, for lists and templates
    extra: str = ""  # extra of exidyn that installs its libraries; empty if it needs none
    package: str = ""  # installed package that provides the driver; empty for exidyn's own drivers


DRIVERS: dict[str, Entry] = {
    "mock": Entry(".mock.driver:Mock", "a simulated arm with drives, encoders and noise; nothing moves"),
    "kuka_rsi": Entry(
        ".kuka_rsi.driver:KukaRsi", "KUKA KRC2, KRC4, KRC5 by Robot Sensor Interface (UDP), 83 or 250 Hz"
    ),
    "ur_rtde": Entry(
        ".ur_rtde.driver:UrRtde", "Universal Robots CB3, e-Series and later by RTDE (TCP), 125 or 500 Hz"
    ),
    "franka": Entry(".franka.driver:Franka", "Franka Research 3 by the FCI, 1 kHz", "franka"),
    "canopen_402": Entry(
        ".canopen_402.driver:Canopen402", "CiA 402 drives on CAN, cyclic synchronous position, 500 Hz", "can"
    ),
    "can_mit": Entry(".can_mit.driver:CanMit", "motors with the MIT frame on CAN: Damiao, T-Motor AK", "can"),
    "dynamixel": Entry(
        ".dynamixel.driver:Dynamixel", "Dynamixel servos, protocol 2.0, on a serial port", "serial"
    ),
    "feetech": Entry(".feetech.driver:Feetech", "Feetech STS and SMS servos on a serial port", "serial"),
}


def known_drivers() -> dict[str, Entry]:
    """`DRIVERS` and the drivers of installed packages. Raises BadDriver if one of their names is taken."""
    known = dict(DRIVERS)
    for point in metadata.entry_points(group=GROUP):
        package = point.dist.name if point.dist else "an unknown package"
        entry = Entry(point.value, f"a driver of the package {package}", package=package)
        if known.setdefault(point.name, entry).place != entry.place:
            raise BadDriver(point.name, package, "the name is taken. Give the entry point another name")
    return known


def driver_class(name: str) -> type[Driver]:
    """The class of a driver.

    Raises:
        UnknownDriver: If there is no driver of this name.
        MissingPackage: If a library that the driver needs is not installed.
        BadDriver: If the driver of an installed package is missing or cannot be loaded.
    """
    known = known_drivers()
    if name not in known:
        raise UnknownDriver(name, known)
    entry = known[name]
    if entry.package:
        return _load_installed(name, entry)
    try:
        return _load(entry)
    except ModuleNotFoundError as error:
        if not entry.extra or (error.name or "").startswith("exidyn"):
            raise
        raise MissingPackage(name, error.name, entry.extra) from error


def _load(entry: Entry) -> Any:
    module, _, class_name = entry.place.partition(":")
    return getattr(import_module(module, __name__), class_name)


def _load_installed(name: str, entry: Entry) -> type[Driver]:
    try:
        kind = _load(entry)
    except Exception as error:  # a module of another package may raise anything
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise BadDriver(
            name,
            entry.package,
            f"cannot be loaded from {entry.place}: {reason}. Repair or uninstall the package",
        ) from error
    if not (isinstance(kind, type) and issubclass(kind, Driver)):
        raise BadDriver(name, entry.package, f"{entry.place} is no subclass of exidyn.drivers.Driver")
    return kind


def create(name: str, table: Mapping[str, Any], arm: Arm) -> Driver:
    """Create a driver without opening it.

    Raises the errors of `driver_class`, and BadSettings for invalid settings.
    """
    cls = driver_class(name)
    return cls(read_settings(cls.Settings, table, arm.dof, f"driver {name}"), arm)


def explain(name: str) -> str:
    """TOML template with all settings of a driver. Raises the errors of `driver_class`."""
    settings = template(driver_class(name).Settings)
    return f'# {known_drivers()[name].purpose}\ndriver = "{name}"\n\n[settings]\n{settings}'
