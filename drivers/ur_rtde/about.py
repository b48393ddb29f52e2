"""About: metadata of the driver once the controller has answered."""

import numpy as np

from ..driver import Info
from .dashboard import Dashboard
from .modes import FULL, ROBOT_MODE, SAFETY_MODE, STATE, word
from .ur_settings import UrSettings

SIGNALS = ("position", "velocity", "current", "temperature")
SOFT = 0.05
"""Smoothing of servoj from which on the monitors of a run may take its latency for an error [s]."""


def info_of(settings: UrSettings, version: str, record: np.void, dashboard: Dashboard | None) -> Info:
    """All that explains the measurement later, and what to warn about now."""
    warnings = []
    if dashboard is not None and not dashboard.there:
        warnings.append(
            "the dashboard server does not answer: a stop of level OFF cannot switch the arm off, and remote "
            "control cannot be asked for"
        )
    if settings.lookahead > SOFT:
        warnings.append(
            f"lookahead is {settings.lookahead:g} s: the arm follows later than that, which `--tracking` may "
            "take for an error"
        )
    if float(record["speed_scaling"]) < FULL:
        warnings.append(f"the controller scales speed by {float(record['speed_scaling']):.3g}")
    return Info(
        cycle=settings.cycle,
        clock="controller",
        signals=SIGNALS,
        dead_man=f"the program on the controller stops the arm (stopj) after {settings.dead_man:g} s without "
        "a command",
        settings={
            "controller": settings.address,
            "version": version,
            "servoj": f"lookahead {settings.lookahead:g} s, gain {settings.gain:g}",
            "deceleration": f"{settings.deceleration:g} rad/s^2",
            "dead_man": f"{settings.dead_man:g} s",
            "registers": f"from {settings.first_register} on",
            "robot_mode": word(ROBOT_MODE, int(record["robot_mode"])),
            "safety_mode": word(SAFETY_MODE, int(record["safety_mode"])),
            "speed_slider": f"{100 * float(record['target_speed_fraction']):.4g} %",
        },
        warnings=tuple(warnings),
        state=STATE,
    )
