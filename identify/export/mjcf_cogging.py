"""Cogging of a DC motor from the torque ripple of its joint: one wave, with amplitude and phase."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..effects import TorqueRipple
from ..robot_files.mjcf_dcmotors import DcMotor
from .mjcf_changes import SAME
from .portable import Portable
from .spread import Spread


class Wave(NamedTuple):
    """One wave of the torque ripple of a joint."""

    effect: TorqueRipple  # ripple of this joint alone
    values: np.ndarray  # its parameters, shape (p,) [N m]
    columns: slice  # parameters of the wave: those of cosine and sine
    poles: float  # number of waves per turn of the file's motor [-]

    @property
    def amplitude(self) -> float:
        """Amplitude at the joint [N m]."""
        return float(np.hypot(*self.values[self.columns]))


def with_cogging(
    motor: DcMotor, portable: Portable, place: int, halves: dict[str, float], spread: Spread
) -> tuple[DcMotor, Portable]:
    """The motor with the wave that the file's motor has, or else with the largest, and the model without it.

    Args:
        motor: Motor of the file.
        portable: Identified model.
        place: Index of the joint in the robot.
        halves: Field of the motor -> half of its 95 % interval; those of amplitude and phase are added.
        spread: Covariance of the parameters.
    """

    def preference(wave: Wave) -> tuple[bool, float]:
        return bool(motor.amplitude) and _equal(wave.poles, abs(motor.poles)), wave.amplitude

    wave = max(_waves(motor, portable, place), key=preference, default=None)
    if wave is None or not any(preference(wave)):
        return motor, portable
    names = [parameter.name for parameter in wave.effect.parameters(portable.robot)][wave.columns]
    pair, zeroed = wave.values[wave.columns], wave.values.copy()
    zeroed[wave.columns] = 0.0
    halves |= _halves(names, pair, motor.gear, spread)
    sign = np.sign(portable.robot.gear_ratio[place])  # the ripple counts turns of the robot's motor
    return _cogged(motor, wave.poles, pair * [1.0, sign]), portable.without_effect(wave.effect, zeroed)


def _waves(motor: DcMotor, portable: Portable, place: int) -> list[Wave]:
    """Waves of the joint; none if other joints turn its motor too."""
    robot = portable.robot
    if not motor.gear or np.any(robot.coupling[place] != np.eye(robot.dof)[place]):
        return []
    ratio = abs(robot.gear_ratio[place] / motor.gear)
    return [
        Wave(effect, values, slice(2 * k - 2, 2 * k), float(k * effect.harmonic * ratio))
        for effect, values in portable.joint_effects(TorqueRipple, place)
        if isinstance(effect, TorqueRipple)
        for k in range(1, effect.count + 1)
    ]


def _equal(poles: float, other: float) -> bool:
    return abs(poles - other) <= SAME * poles


def _cogged(motor: DcMotor, poles: float, wave: np.ndarray) -> DcMotor:
    """The motor with a cogging of this `wave` (2,) [N m]; unchanged if it is that of the file."""
    cosine, sine = wave.tolist()
    size = float(np.hypot(cosine, sine))
    if _equal(poles, abs(motor.poles)) and np.allclose(motor.wave, wave, rtol=0.0, atol=SAME * size):
        return motor
    if not size:
        return replace(motor, amplitude=0.0)
    phase = float(np.arctan2(-cosine / motor.gear, -sine / abs(motor.gear))) + 0.0
    return replace(motor, poles=poles, amplitude=size / abs(motor.gear), phase=phase)


def _halves(names: list[str], wave: np.ndarray, gear: float, spread: Spread) -> dict[str, float]:
    """Halves of the 95 % intervals of amplitude [N m] and phase [rad]; the number of poles is a choice."""
    size = float(np.hypot(*wave))
    if not size:
        return {}
    rows = {"amplitude": wave / size / abs(gear), "phase": np.array([-wave[1], wave[0]]) / size**2}
    return {"poles": 0.0} | {
        field: spread.half_of(dict(zip(names, row.tolist(), strict=True))) for field, row in rows.items()
    }
