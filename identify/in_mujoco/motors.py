"""DC motors in a simulation: without current, or without the friction and cogging that effects replace.

The number of a motor's states depends on which of its numbers are zero, so MuJoCo stops if a stiffness or an
integral gain becomes zero in a compiled model. These functions keep such numbers above zero.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..robot_files.mjcf_dcmotors import SHORTED, dc_motors, is_dc_motor
from ..robot_files.mjcf_names import actuators, drives_joint

OPEN = 1e30
"""Resistance of an open circuit [ohm]."""
RESISTANCE, PROPORTIONAL, INTEGRAL, DERIVATIVE = 0, 4, 5, 6
"""Places in `actuator_gainprm` of a DC motor."""
BRISTLE_DAMPING = 6
"""Place in `actuator_dynprm`."""
AMPLITUDE, COULOMB, STATIC = 0, 3, 4
"""Places in `actuator_biasprm`."""


def silence(model: Any, joints: Sequence[int]) -> None:
    """Disable the drives of joints; friction, cogging and the brake of shorted motors stay."""
    for actuator in actuators(model):
        if not drives_joint(model, actuator) or model.actuator_trnid[actuator][0] not in joints:
            continue
        if is_dc_motor(model, actuator):
            _open_circuit(model, actuator)
        else:
            model.actuator_gainprm[actuator] = model.actuator_biasprm[actuator] = 0.0


def _open_circuit(model: Any, actuator: int) -> None:
    """Let no current flow through a motor that has an input."""
    if int(model.actuator_ctrlspec[actuator]) == SHORTED:
        return
    gain = model.actuator_gainprm[actuator]
    gain[RESISTANCE], gain[PROPORTIONAL], gain[DERIVATIVE] = OPEN, 0.0, 0.0
    gain[INTEGRAL] = np.finfo(float).tiny if gain[INTEGRAL] > 0.0 else 0.0


class MotorFriction:
    """LuGre friction and cogging of the DC motors of joints, removed while effects replace them.

    Args:
        model: An `MjModel`.
        joints: Indices of the joints in the model.
    """

    def __init__(self, model: Any, joints: Sequence[int]) -> None:
        self._model, self._motors = model, [motor.index for motor in dc_motors(model, joints)]
        self._bias = model.actuator_biasprm[self._motors].copy()
        self._dynamics = model.actuator_dynprm[self._motors].copy()

    def remove(self) -> None:
        """Set friction and cogging to zero."""
        for motor in self._motors:
            self._model.actuator_biasprm[motor, [AMPLITUDE, COULOMB, STATIC]] = 0.0
            self._model.actuator_dynprm[motor, BRISTLE_DAMPING] = 0.0

    def restore(self) -> None:
        """Restore the numbers of the file."""
        self._model.actuator_biasprm[self._motors] = self._bias
        self._model.actuator_dynprm[self._motors] = self._dynamics
