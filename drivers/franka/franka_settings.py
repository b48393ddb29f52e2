"""Settings of a Franka controller."""

from dataclasses import dataclass

from ..settings import setting


@dataclass(frozen=True)
class FrankaSettings:
    """Settings of a Franka controller."""

    address: str = setting(..., "of the controller's shop floor network, such as 172.16.0.2", kind=str)
    buffer: float = setting(
        0.02,
        "by which commands are held back: what this computer may be late by without a stop",
        unit="s",
        low=0.002,
        high=0.5,
    )
    collision_torque: float = setting(
        0.0,
        "of any joint, above which is a reflex; 0 as the controller has it",
        unit="N m",
        low=0.0,
        high=100.0,
    )
    collision_force: float = setting(
        0.0, "at the hand, likewise; 0 as the controller has it", unit="N", low=0.0, high=200.0
    )
    recover: bool = setting(False, "recover the arm from a reflex before a run, without asking")
    real_time: bool = setting(False, "refuse a computer without a real-time kernel")
    wait: float = setting(10.0, "for the connection and for answers", unit="s", low=0.1, high=60.0)
