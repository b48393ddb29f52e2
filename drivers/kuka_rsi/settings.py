"""Settings of the KUKA driver, in the units of KUKA controllers, and their consistency."""

from dataclasses import dataclass
from ipaddress import ip_address

import numpy as np

from ..errors import BadSettings
from ..settings import setting
from .config import RsiConfig, read_config, standard_config

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
