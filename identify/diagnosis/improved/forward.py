"""Forward: a run simulated in closed loop, with and without the findings, and compared with its recording.

The real drives are unknown. Drives that are stiffer than real ones replace them and follow the measured
motion, so that torques are compared for the same motion.
"""

from dataclasses import dataclass

import numpy as np

from ...recordings.recording import Recording, Signal
from ...simulation.plant import DriveControl, Plant, Thermal
from ...simulation.plant.typical import typical_size
from ...simulation.simulate import follow
from ..candidates import kind_of
from ..findings.arm import Arm
from ..findings.diagnosis import Diagnosis, Simulated
from ..results.remainder import rms
from ..runs.driven import Driven
from .improved import as_found, as_nominal

BANDWIDTH = 150.0
"""Bandwidth of the simulated velocity loops [Hz]: six times that of the comparison, so that the loops do not
affect the compared torques."""
SETTLED = 0.5
"""Time after which a simulation that starts at rest follows a run that does not [s]."""


@dataclass(frozen=True, eq=False)
class Forward:
    """One simulated run; all torques are behind the filter of the comparison."""

    run: str  # name of the run
    time: np.ndarray  # shape (r,) [s]
    measured: np.ndarray  # torque by currents and nominal gains, shape (r, n) [N m]
    torque_before: np.ndarray  # torque of the nominal arm, shape (r, n) [N m]
    torque_after: np.ndarray  # torque of the arm with findings, shape (r, n) [N m]
    weight: np.ndarray  # 0 where a joint sticks, else 1, shape (r, n)
    missed: np.ndarray  # RMS difference of simulated and measured position, shape (n,) [rad]
    left_out: tuple[str, ...]  # effects of findings that the simulation does not contain

    @property
    def summary(self) -> Simulated:
        """Agreement with the recording, without samples."""
        return Simulated(self.run, self.before, self.after, self.left_out)

    @property
    def before(self) -> np.ndarray:
        """RMS difference between recorded torque and nominal arm, shape (n,) [N m]."""
        return _difference(self.measured - self.torque_before, self.weight)

    @property
    def after(self) -> np.ndarray:
        """RMS difference between recorded torque and arm with findings, shape (n,) [N m]."""
        return _difference(self.measured - self.torque_after, self.weight)


def _difference(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Root mean square, shape (n,); infinite or NaN if a simulation has diverged."""
    with np.errstate(over="ignore", invalid="ignore"):
        return rms(values, weight)


def forward(diagnosis: Diagnosis, recording: Recording) -> Forward | None:
    """Simulate a run before and after; None for a diagnosis without evidence.

    Args:
        diagnosis: Diagnosis with evidence.
        recording: One of its runs, preferably a held-out run.

    Raises:
        RobotError: The arm cannot be simulated, for example because a joint has no inertia.
    """
    if (known := diagnosis.evidence) is None:
        return None
    run = Driven.of(known.model, recording, "", known.filtering)
    # Parameters were fitted together with undecided findings too.
    findings = diagnosis.all_findings
    arms = as_nominal(known), as_found(known, findings)
    # A diverging simulation overflows to infinity and NaN, which are reported as missing values.
    with np.errstate(over="ignore", invalid="ignore"):
        # The run has already been corrected for the measurement models of the nominal model.
        before, after = (_followed(arm.without(known.model.measurements), run) for arm in arms)
        torques = [run.thinned(run.prepared.gain * signals["current"].values) for signals in (before, after)]
        missed = run.motion.position - after["position"].values
    wrong = [place for place in arms[1].left_out if kind_of(findings[place].effect).sensor]
    for trace in known.traces:
        if trace.name == recording.name:
            torques[1] = torques[1] + trace.explained[wrong].sum(axis=0)
    time = run.prepared.decimated_time
    left_out = [place for place in arms[1].left_out if place not in wrong]
    return Forward(
        run=recording.name,
        time=time,
        measured=run.prepared.gain * run.prepared.decimated_current,
        torque_before=torques[0],
        torque_after=torques[1],
        weight=run.prepared.weight * (time > run.motion.time[0] + SETTLED)[:, None],
        missed=_difference(missed, np.ones_like(missed)),
        left_out=tuple(findings[place].effect for place in left_out),
    )


def _followed(arm: Arm, run: Driven) -> dict[str, Signal]:
    """Sensor signals of the arm along the motion of a run, at the mean temperature of that run."""
    inertia, temperature = typical_size(arm.model)[0], run.motion.temperature
    warmth = np.nanmean(temperature) if np.any(np.isfinite(temperature)) else 25.0
    plant = Plant(
        arm.model,
        arm.values,
        arm.gain,
        run.motion.position[0],
        DriveControl.tuned(inertia, BANDWIDTH, np.full(len(inertia), np.inf), feed_forward=1.0),
        thermal=Thermal.constant(len(inertia), float(warmth)),
        payload=run.motion.payload,
    )
    return follow(plant, run.motion.position, run.motion.velocity, 1.0 / run.prepared.decimation.rate)
