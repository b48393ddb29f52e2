"""Settings of a Franka controller, and the driver's metadata once the controller has answered."""

from dataclasses import dataclass

import numpy as np

from ..driver import Arm, Info
from ..samples import word
from ..settings import setting
from .fci_messages import ROBOT_MODE, STATE, mode_of
from .target_stream import CYCLE, LOWER, UPPER, VELOCITY


@dataclass(frozen=True)
class FrankaSettings:
    """Settings of a Franka controller."""

    address: str = setting(..., "address of the controller's shop floor network, such as 172.16.0.2")
    buffer: float = setting(
        0.02,
        "time by which commands are held back: a delay of this computer up to this does not stop the arm",
        unit="s",
        low=0.002,
        high=0.5,
    )
    collision_torque: float = setting(
        0.0,
        "torque of any joint above which the arm stops by a reflex; 0 keeps the controller's",
        unit="N m",
        low=0.0,
        high=100.0,
    )
    collision_force: float = setting(
        0.0,
        "force at the hand above which the arm stops by a reflex; 0 keeps the controller's",
        unit="N",
        low=0.0,
        high=200.0,
    )
    recover: bool = setting(False, "recover the arm from a reflex before a run, without asking")
    real_time: bool = setting(False, "refuse a computer without a real-time kernel")
    wait: float = setting(
        10.0, "time to wait for the connection and for answers", unit="s", low=0.1, high=60.0
    )


SIGNALS = ("position", "velocity", "torque")
SLOW = 0.03
"""Delay of commands above which the monitors of a run may treat it as a tracking error [s]."""


def info_of(settings: FrankaSettings, version: str, record: np.void, arm: Arm) -> Info:
    """Metadata that explain the measurements later, and warnings."""
    warnings = _wider(arm)
    if settings.buffer > SLOW:
        warnings.append(
            f"buffer is {settings.buffer:g} s: the arm follows later than that, which `--tracking` may treat "
            "as an error"
        )
    torque, force = settings.collision_torque, settings.collision_force
    thresholds = f"torque {torque:g} N m, force {force:g} N; 0 is 100"
    return Info(
        cycle=CYCLE,
        clock="controller",
        signals=SIGNALS,
        dead_man=f"a separate process stops the arm after {settings.buffer:g} s without a command; the "
        "controller stops it 20 ms after the last command of that process",
        settings={
            "controller": settings.address,
            "library": f"pylibfranka {version}",
            "buffer": f"{settings.buffer:g} s",
            "torque": "tau_J: measured behind the gears, with gravity; tau_J_d, commanded, without gravity",
            "collision": thresholds if torque or force else "as the controller has it",
            "robot_mode": word(ROBOT_MODE, mode_of(record)),
        },
        warnings=tuple(warnings),
        state=STATE,
    )


def _wider(arm: Arm) -> list[str]:
    wider = {
        "position": (arm.position_lower < LOWER) | (arm.position_upper > UPPER),
        "velocity": arm.velocity > VELOCITY,
    }
    return [
        f"the robot file allows more {name} of {', '.join(np.array(arm.joints)[joints])} than the "
        "controller: a motion beyond its limits is stopped"
        for name, joints in wider.items()
        if joints.any()
    ]
