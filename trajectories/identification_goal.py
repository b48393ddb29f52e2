"""The goal of identifying a model: from beliefs alone, or from what an earlier fit knows."""

import numpy as np

from exidyn.identify.arm.robot import Limits
from exidyn.identify.model import Model

from .after_fit import after_fit
from .errors import UnknownChoice
from .families.fourier import Fourier
from .search.criteria import CRITERIA, Criterion, Focus
from .search.goals import Identify
from .search.information import Experiment
from .search.payload_guess import with_payload
from .search.shrink import inside_kinematics
from .search.unknowns import with_drive_gains, with_shapes
from .wishes import Wishes, rows_of

NOISE = 0.01
"""Torque noise where none was measured, as a share of each joint's rms torque in a random motion: the
currents of industrial drives, at 500 Hz, scatter by one per cent."""


def identification_goal(model: Model, wishes: Wishes, limits: Limits) -> Identify:
    """To tell the model's parameters, and the drive gains where a pair of runs can."""
    if wishes.criterion not in CRITERIA:
        raise UnknownChoice("criterion", wishes.criterion, CRITERIA)
    payloads: tuple[str, ...] = ("",)
    believed = model
    if wishes.payload is not None:
        believed, payloads = with_payload(model, wishes.payload), ("", "L")
    if wishes.fit is not None:
        return after_fit(wishes.fit, believed, payloads, wishes)
    asked = with_shapes(believed, wishes.shapes)
    asked = with_drive_gains(asked) if wishes.payload is not None else asked
    experiment = Experiment.of(asked, payloads, believed_noise(believed, limits, payloads[-1]))
    criterion: Criterion = CRITERIA[wishes.criterion]
    if wishes.focus:
        criterion = Focus.on(experiment.base.names, wishes.focus)
    return Identify(experiment, criterion, rows_of(wishes), believed)


def believed_noise(model: Model, limits: Limits, payload: str = "") -> np.ndarray:
    """Noise of each drive's torque where none was measured, shape (n,) [N m]; see `NOISE`."""
    n, random = model.robot.dof, np.random.default_rng(0)
    middle = 0.5 * (limits.position_lower + limits.position_upper)
    series = inside_kinematics(Fourier(10.0, middle, *random.normal(size=(2, n, 5))), limits, 0.9)
    motion = model.loaded(series.at(np.linspace(0.0, 10.0, 500)).motion(payload))
    on_motors = model.torque(motion, model.believed_values) @ model.robot.to_motors.T
    rms = np.sqrt(np.mean(on_motors**2, axis=0))
    largest = float(np.max(rms))
    return NOISE * np.maximum(rms, 1e-3 * largest) if largest > 0 else np.ones(n)
