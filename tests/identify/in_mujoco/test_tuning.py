"""Numbers that differ from the file only if the runs require it, on errors that are linear in them."""

import numpy as np

from exidyn.identification.in_mujoco.joint_numbers import DRY, KP
from exidyn.identification.in_mujoco.rollouts import MOMENTS
from exidyn.identification.in_mujoco.tuning import Tuning

WINDOWS = 16
FILE = np.array([[20.0], [2.0], [0.2], [0.01], [np.inf], [0.0]])


class Linear:
    """Errors of a joint whose stiffness and dry friction show nearly alike in its motion."""

    def __init__(self, true: np.ndarray, seed: int) -> None:
        random = np.random.default_rng(seed)
        alike, own = random.normal(size=(2, WINDOWS, MOMENTS, 1))
        self._columns, self._true = {KP: alike, DRY: alike + 0.2 * own}, true
        self._noise = 0.01 * random.normal(size=alike.shape)

    def __len__(self) -> int:
        return WINDOWS

    def errors(self, versions, held):
        changes = [{KP: np.log(v[KP] / self._true[KP]), DRY: v[DRY] - self._true[DRY]} for v in versions]
        return np.array(
            [self._noise + sum(self._columns[row] * change[row] for row in change) for change in changes]
        )


def test_a_number_that_is_not_needed_returns_and_the_others_stay_certain():
    """Each of two numbers that show alike is uncertain as long as the other one is."""
    true, free = FILE.copy(), np.isin(np.arange(6), (KP, DRY))[:, None]
    true[KP] *= 0.97
    tuning = Tuning(Linear(true, 0), FILE, np.ones(FILE.shape), np.full(FILE.shape, 1e-6))
    values = tuning.fitted(FILE, free)
    needed, std = tuning.needed(values, free)
    assert needed[DRY] == FILE[DRY]
    assert needed[KP] != FILE[KP]
    assert abs(np.log(needed[KP] / true[KP])) < 4.0 * std[KP]
    assert std[KP] < 0.5 * tuning.deviations(values, free)[KP]
