"""Settings of a Universal Robots controller."""

from dataclasses import dataclass

from ..errors import BadSettings
from ..settings import setting


@dataclass(frozen=True)
class UrSettings:
    """Settings of a Universal Robots controller."""

    address: str = setting(..., "of the controller, such as 192.168.56.101", kind=str)
    cycle: float = setting(
        0.002, "time between commands; at least 0.002, of a CB3 0.008", unit="s", low=0.002, high=0.1
    )
    lookahead: float = setting(
        0.03, "over which servoj smooths; most of its latency", unit="s", low=0.03, high=0.2
    )
    gain: float = setting(300.0, "of servoj", low=100.0, high=2000.0)
    deceleration: float = setting(
        10.0, "with which the program stops by itself (stopj)", unit="rad/s^2", low=0.1, high=100.0
    )
    dead_man: float = setting(
        0.2, "time without a command after which it does", unit="s", low=0.01, high=10.0
    )
    first_register: int = setting(
        24, "first of the registers that are used: 0 where a fieldbus has those from 24 on", choices=(0, 24)
    )
    wait: float = setting(5.0, "for an answer, and for the program to begin", unit="s", low=0.1, high=60.0)
    rtde_port: int = setting(30004, "of RTDE", low=1, high=65535)
    program_port: int = setting(30002, "that programs are sent to", low=1, high=65535)
    dashboard_port: int = setting(29999, "of the dashboard server", low=1, high=65535)


def require_cycle(cycle: float, major: int) -> None:
    """See that a controller keeps such cycles, by the first number of its version.

    Raises:
        BadSettings: It does not.
    """
    series, own = ("CB3", 0.008) if major <= 3 else ("e-Series or later", 0.002)
    if cycle < own - 1e-9 or abs(cycle / own - round(cycle / own)) > 1e-6:
        raise BadSettings(
            f"driver ur_rtde: cycle is {cycle:g} s, but the controller has version {major} ({series}), whose "
            f"cycle is {own:g} s. Try cycle = {own:g}, or a multiple"
        )
