"""The arm whose stops do not work: with mass and drives, or following its commands at once."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from exidyn.drivers.driver import Plant
from exidyn.identification.simulation.plant import Plant as PlantWithMass
from exidyn.identification.simulation.plant.typical import typical_parts

from ..motion import JOINTS, MODEL, START

COARSE = 1.5e-3
"""Step of a serial servo's encoder, and standard deviation of its noise [rad]."""


def heavy(coarse: bool) -> Plant:
    """The arm of `record_motion`, with the encoders of serial servos if they are to be coarse."""
    control, sensors, thermal = typical_parts(MODEL)
    if coarse:
        rough = np.full(JOINTS, COARSE)
        sensors = replace(sensors, encoder_step=rough, encoder_noise=rough)
    gain = MODEL.robot.drive_gain
    return PlantWithMass(MODEL, MODEL.nominal_values, gain, START, control, sensors, None, thermal)


class _Measured(NamedTuple):
    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    temperature: np.ndarray


class _Light:
    def __init__(self, coarse: bool) -> None:
        self._position, self._coarse = START, coarse
        self._random = np.random.default_rng(0)

    def step(self, position: np.ndarray, velocity: np.ndarray, seconds: float) -> None:
        self._position = np.array(position)

    def measure(self) -> _Measured:
        position, nothing = self._position, np.zeros(JOINTS)
        if self._coarse:
            position = COARSE * np.round(position / COARSE + self._random.normal(size=JOINTS))
        return _Measured(position, nothing, nothing, nothing + 25.0)


def light(coarse: bool) -> Plant:
    """An arm that follows its commands at once, five times as fast to compute."""
    return _Light(coarse)
