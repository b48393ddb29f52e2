"""`contact`: external torque, flange force and alarms along a recording."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import FitError, RecordingError
from ..fit.fit import Fit
from ..fit.identification import of_this_arm
from ..preparation.even import Even
from ..recordings.recording import Recording
from . import BANDWIDTH
from .observer import AHEAD, Estimates, Observer
from .threshold import Alarm, Alarms, Threshold
from .wrench import flange_wrenches

if TYPE_CHECKING:
    from pathlib import Path


@dataclass(frozen=True, eq=False)
class Contact:
    """External torques along a run, and what they say about contact."""

    fit: Fit  # the fit
    run: str  # name of the run
    estimates: Estimates  # external torques
    wrench: np.ndarray  # force and moment on the flange in the axes of the base, shape (t, 6) [N, N m]
    threshold: Threshold | None  # threshold of contact; None without runs from which it could be computed
    alarms: tuple[Alarm, ...]  # contacts; empty without a threshold

    if TYPE_CHECKING:  # `exidyn.api` binds this function of the layer above

        def save(self, path: Path | str, recording: Path | str) -> Path: ...


def contact(
    fit: Fit,
    run: Recording,
    free: Sequence[Recording] = (),
    payload: str | None = None,
    alarms_per_hour: float = 1.0,
    bandwidth: float = BANDWIDTH,
) -> Contact:
    """Estimate external torques along a run; see `exidyn.contact`.

    Raises:
        DifferentRobot: A run is of another arm than the fit.
        FitError: The fit does not have the payload.
        RecordingError: The runs without contact are too short, or were used for the fit.
        NotRecorded: The effort that the fit measures was not recorded.
    """
    estimates = observed(fit, run, payload, bandwidth)
    threshold = free_threshold(fit, free, alarms_per_hour, bandwidth)
    alarms: tuple[Alarm, ...] = ()
    if threshold is not None:
        collected = Alarms(threshold)
        collected.add(estimates)
        alarms = tuple(collected.all)
    wrench = wrenches(fit, estimates, threshold)
    return Contact(fit, run.name, estimates, wrench, threshold, alarms)


def free_threshold(
    fit: Fit, free: Sequence[Recording], alarms_per_hour: float, bandwidth: float = BANDWIDTH
) -> Threshold | None:
    """Threshold from runs without contact; None without any.

    Raises:
        RecordingError: They are too short, or were used for the fit.
    """
    if not free:
        return None
    if used := [run.name for run in free if run.name in fit.runs]:
        raise RecordingError(
            f"contact: {', '.join(used)} was used for the fit, whose residual there is too small; "
            "give runs that it has not used"
        )
    runs = [observed(fit, run, None, bandwidth) for run in free]
    return Threshold.of(runs, fit.standstill, alarms_per_hour)


def observed(fit: Fit, run: Recording, payload: str | None = None, bandwidth: float = BANDWIDTH) -> Estimates:
    """External torques along a recording, without delay between position and effort; see `contact`."""
    of_this_arm(fit, [run])
    name = (run.payload.name if run.payload else "") if payload is None else payload
    if payload is None and name and name not in fit.model.payloads:
        raise FitError(
            f"{run.name} was recorded with payload {name}, which the fit does not have. Identify the arm "
            "with it, or use another run as --free; with --payload none, its weight is an external force"
        )
    observer = Observer(fit, name, bandwidth)
    even = Even.of(run, None)
    if even.measures != fit.measures:
        raise RecordingError(
            f"{run.name}: the run has a {even.measures}, and the runs of the fit have a {fit.measures}"
        )
    most = 0.5 * even.rate / AHEAD  # of a low-pass with `AHEAD` times the bandwidth
    if bandwidth > most:
        raise RecordingError(
            f"{run.name}: a bandwidth of {bandwidth:g} Hz needs more than {even.rate:.4g} samples a second, "
            f"which allow {most:.3g} Hz"
        )
    temperature = even.signal("temperature") if observer.dynamics.needs_temperature else None
    return observer.add(even.time, even.position, even.signal(even.measures), temperature)


def torque_unit(fit: Fit) -> str:
    """Unit of external torques, of all kinds of joints: amperes without drive gains."""
    return "A" if fit.unscaled else "/".join(dict.fromkeys(fit.model.robot.units("N m")))


def wrenches(fit: Fit, estimates: Estimates, threshold: Threshold | None) -> np.ndarray:
    """Force and moment on the flange, shape (t, 6) [N, N m]; joints count by their residual without contact.

    Without a threshold all joints count by their noise floor in the fit. Without drive gains, torques are in
    amperes and forces are NaN.
    """
    if fit.unscaled:
        return np.full((len(estimates), 6), np.nan)
    noise = fit.noise_of("torque")
    equal = np.ones(fit.model.robot.dof) if noise is None or not np.all(noise > 0.0) else noise
    scale = np.broadcast_to(equal, estimates.torque.shape)
    if threshold is not None:
        scale = threshold.scale(estimates)
    return flange_wrenches(fit.model.robot, estimates.position, estimates.torque, scale)
