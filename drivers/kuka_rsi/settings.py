"""Settings of the KUKA driver, and the layout of telegrams that they and the configuration mean.

Settings have the units of KUKA controllers. Joints are in radians and axes in degrees, possibly with another
sign and zero. Corrections are in degrees of the axes, relative to the start.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from ipaddress import ip_address

import numpy as np

from ..errors import BadSettings
from ..settings import setting
from .config import AXES, EXTERNAL_AXES, RsiConfig, read_config, standard_config

FAST, SLOW = 0.004, 0.012
"""Cycles of controllers [s]: RSI_ON with #IPO_FAST, and with #IPO, the only one of a KRC2."""


@dataclass(frozen=True)
class RsiSettings:
    """Settings of the KUKA driver."""

    controller: str = setting(..., "address of the controller; telegrams from other addresses are ignored")
    config: str = setting("", "copy of the controller's RSI_EthernetConfig.xml; without it, the values below")
    bind: str = setting("", "address of this computer to listen on; by default IP_NUMBER of the config")
    port: int = setting(0, "port to listen on; by default the config's, or 49152", low=0, high=65535)
    sentype: str = setting("", "type of the answers; by default the config's, or ImFree")
    log_only: bool = setting(False, "listen and never answer, as with ONLYSEND in the config")
    generation: str = setting("KRC4", "generation of the controller", choices=("KRC2", "KRC4", "KRC5"))
    cycle: float = setting(
        FAST, "0.004 (#IPO_FAST) or 0.012 (#IPO, and any KRC2)", unit="s", low=FAST, high=SLOW
    )
    mode: str = setting("absolute", "the argument of RSI_ON", choices=("absolute", "relative"))
    probe: bool = setting(True, "probe the effect of corrections before a motion, by at most 0.05 degrees")
    axes: str = setting("", "axis of each joint with spaces between; by default A1 A2 ...")
    sign: tuple[float, ...] = setting(
        1.0, "-1 where an axis turns the other way than its joint", choices=(1.0, -1.0)
    )
    zero: tuple[float, ...] = setting(0.0, "position of the joint where the axis shows zero", unit="rad")
    window_lower: tuple[float, ...] = setting(
        -5.0, "LowerLim of the AXISCORR object", unit="deg", low=-720.0, high=0.0
    )
    window_upper: tuple[float, ...] = setting(
        5.0, "UpperLim of the AXISCORR object", unit="deg", low=0.0, high=720.0
    )
    overall: tuple[float, ...] = setting(
        6.0, "Max of the AXISCORRMON object; 6 also without one", unit="deg", low=0.0, high=720.0
    )  # fmt: skip
    timeout: int = setting(
        100, "Timeout of the ETHERNET object; KUKA's default is 10", unit="cycles", low=5, high=10000
    )
    current_unit: tuple[str, ...] = setting("A", "unit of MACur on this controller", choices=("A", "percent"))
    i_max: tuple[float, ...] = setting(
        0.0, "current that is 100 percent; for current_unit percent", unit="A", low=0.0
    )
    current_tag: str = setting("MACur", "element with the motors' currents")
    torque_tag: str = setting("GearTorque", "element with the joints' torques in N m, of a GEARTORQUE object")
    correction_tag: str = setting("", "element of the corrections, such as AK; by default the config's")
    stop_tag: str = setting("Stop", "channel to a STOP object, if the config has it; empty for none")
    wait: float = setting(
        60.0, "how long to wait for the controller's program", unit="s", low=0.0, high=86400.0
    )

    @property
    def window(self) -> tuple[np.ndarray, np.ndarray]:
        """Smallest and largest corrections that the controller accepts unchanged, each (n,) [deg]."""
        overall = np.asarray(self.overall)
        return np.maximum(self.window_lower, -overall), np.minimum(self.window_upper, overall)


def config_of(settings: RsiSettings) -> RsiConfig:
    """The configuration that the controller should have.

    Raises BadSettings if the file cannot be read or differs from the settings, or they contradict each other.
    """
    _check(settings)
    if not settings.config:
        if not settings.bind:
            raise BadSettings(
                "driver kuka_rsi: give config, or bind: the address that the controller sends to"
            )
        sentype = settings.sentype or "ImFree"
        stop = settings.stop_tag == "Stop"
        port = settings.port or 49152
        return standard_config(settings.bind, port, sentype, settings.log_only, stop=stop)
    config = read_config(settings.config)
    for name, ours, theirs in (
        ("port", settings.port, config.port),
        ("sentype", settings.sentype, config.sentype),
        ("log_only", settings.log_only, config.only_send),
    ):
        if ours and ours != theirs:
            raise BadSettings(
                f"driver kuka_rsi: {name} is {ours}, but {settings.config} has {theirs}. The controller uses "
                "that file: change it there and here, or omit the setting"
            )
    return config


def _check(settings: RsiSettings) -> None:
    try:
        ip_address(settings.controller)
    except ValueError:
        raise BadSettings(
            f"driver kuka_rsi: controller is '{settings.controller}', which is not an IP address; expected "
            "numbers, such as 172.31.1.147"
        ) from None
    if settings.mode == "relative":
        raise BadSettings(
            "driver kuka_rsi: mode is 'relative', in which every lost telegram moves the arm away from its "
            "assumed position. Valid: absolute; call RSI_ON(#ABSOLUTE) in the program"
        )
    slow_only = settings.generation == "KRC2"
    if settings.cycle not in (FAST, SLOW)[slow_only:]:
        raise BadSettings(
            f"driver kuka_rsi: cycle is {settings.cycle:g} s; a {settings.generation} has "
            f"{SLOW:g}{'' if slow_only else f' or {FAST:g}'}"
        )


class Axes:
    """Relation between axes and joints. Raises BadSettings for currents in percent without i_max."""

    def __init__(self, settings: RsiSettings) -> None:
        self.sign = np.array(settings.sign)  # sign of the axes relative to the joints, 1 or -1, shape (n,)
        self.zero = np.array(settings.zero)  # joint positions where the axes show zero, shape (n,) [rad]
        percent = np.array(settings.current_unit) == "percent"
        maximum = np.array(settings.i_max)
        if (percent & (maximum == 0.0)).any():
            place = int(np.argmax(percent & (maximum == 0.0)))
            raise BadSettings(
                f"driver kuka_rsi: current_unit[{place}] is percent; set i_max, the current at 100 percent"
            )
        self.ampere = np.where(percent, 0.01 * maximum, 1.0)  # amperes per unit of current, shape (n,)

    def joints(self, degrees: np.ndarray) -> np.ndarray:
        """Joint positions (n,) [rad] of axis positions [deg]."""
        return self.sign * np.radians(degrees) + self.zero

    def degrees(self, position: np.ndarray) -> np.ndarray:
        """Axis positions (n,) [deg] of joint positions [rad]."""
        return self.sign * np.degrees(position - self.zero)

    def window(self, lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Convert limits of corrections [deg] to limits of joint displacements, each (n,) [rad]."""
        ends = np.radians([self.sign * lower, self.sign * upper])
        return ends.min(axis=0), ends.max(axis=0)


ACTUAL, PROGRAMMED, DELAY = "AIPos", "ASPos", "Delay"
EXTERNAL = ("EIPos", "MECur")
"""Elements of external axes, recorded in the controller's units: degrees or mm, and currents."""


@dataclass(frozen=True)
class Layout:
    """Values read and written for one arm."""

    axes: tuple[str, ...]  # axis of each joint, such as A1
    elements: tuple[str, ...]  # elements with a value for each axis, in reading order
    external: tuple[str, ...]  # names of values of external axes, such as EIPos.E1
    delay: bool  # whether the controller counts answers that came late
    corrections: tuple[str, ...]  # tag of each joint's correction; empty when only listening
    switch: str  # tag of the Stop channel; empty without one

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all values that are read from a telegram."""
        internal = tuple(f"{element}.{axis}" for element in self.elements for axis in self.axes)
        values = internal + self.external
        return (*values, f"{DELAY}.D") if self.delay else values

    @property
    def external_columns(self) -> slice:
        """Indices of the values of external axes in `names`."""
        first = len(self.elements) * len(self.axes)
        return slice(first, first + len(self.external))

    def columns(self, element: str) -> slice | None:
        """Indices of the values of an element in `names`; None if it is not sent."""
        if element not in self.elements:
            return None
        first = self.elements.index(element) * len(self.axes)
        return slice(first, first + len(self.axes))


def layout_of(config: RsiConfig, settings: RsiSettings, joints: int) -> Layout:
    """Layout for an arm. Raises BadSettings if the configuration lacks a required value."""
    axes = _axes(settings, joints)
    where = settings.config or "the configuration"
    wanted = (ACTUAL, PROGRAMMED, settings.current_tag, settings.torque_tag)
    elements = [name for name in wanted if name and all(config.sends(f"{name}.{axis}") for axis in axes)]
    if ACTUAL not in elements:
        raise BadSettings(
            f"{where} does not send the axes' positions: add DEF_{ACTUAL} to SEND, also on the controller"
        )
    tags = tuple(element.tag for element in config.receive)
    return Layout(
        axes=axes,
        elements=tuple(elements),
        external=tuple(
            name
            for name in (f"{element}.{axis}" for element in EXTERNAL for axis in EXTERNAL_AXES)
            if config.sends(name)
        ),
        delay=config.sends(DELAY),
        corrections=() if config.only_send else _corrections(config, settings, axes, where),
        switch=settings.stop_tag if settings.stop_tag in tags and not config.only_send else "",
    )


def _axes(settings: RsiSettings, joints: int) -> tuple[str, ...]:
    axes = tuple(settings.axes.split()) or AXES[:joints]
    if len(axes) != joints or len(set(axes)) != joints or not set(axes) <= set(AXES):
        raise BadSettings(
            f"driver kuka_rsi: axes are '{' '.join(axes)}' for {joints} joints; give each joint one of "
            f"{', '.join(AXES)}. External axes are recorded, and not driven"
        )
    return axes


def _corrections(
    config: RsiConfig, settings: RsiSettings, axes: Sequence[str], where: str
) -> tuple[str, ...]:
    candidates = (settings.correction_tag,) if settings.correction_tag else config.corrections()
    if len(candidates) != 1:
        problem = f"several corrections: {', '.join(candidates)}" if candidates else "no axis corrections"
        raise BadSettings(
            f"{where} receives {problem}. Set correction_tag to the element wired to AXISCORR, or add AK.A1 "
            "to AK.A6 to RECEIVE"
        )
    elements = {element.tag: element for element in config.receive}
    tags = tuple(f"{candidates[0]}.{axis}" for axis in axes)
    for tag in tags:
        element = elements.get(tag)
        if element is None or element.kind != "DOUBLE":
            raise BadSettings(
                f"{where} does not receive {tag} as DOUBLE; add it, there and on the controller"
            )
        if not element.hold:
            raise BadSettings(
                f'{where}: {tag} has HOLDON="0": one late answer would send the arm back to its start '
                'within a cycle. Set HOLDON="1", there and on the controller'
            )
    return tags
