"""Forward: a run simulated in closed loop, with and without what was found, against its recording.

The drives that recorded the run are unknown, so that ones stiffer than any replace them and follow the
motion that was measured: torques are compared on one and the same motion.
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
"""Bandwidth of the simulated velocity loops [Hz]: six times that of the comparison, so that torques up to
there are those of the motion and not of these loops."""
SETTLED = 0.5
"""Time that a simulation, which begins at rest, takes to follow a run that does not [s]."""


@dataclass(frozen=True, eq=False)
class Forward:
    """One run in simulation; all behind the filter of the comparison."""

    run: str  # its name
    time: np.ndarray  # shape (r,) [s]
    measured: np.ndarray  # torque by currents and nominal gains, shape (r, n) [N m]
    torque_before: np.ndarray  # of the nominal arm, shape (r, n) [N m]
    torque_after: np.ndarray  # of the arm with what was found, shape (r, n) [N m]
    weight: np.ndarray  # 0 where a joint sticks, else 1, shape (r, n)
    missed: np.ndarray  # RMS of what simulated motors miss of the measured motion, shape (n,) [rad]
    left_out: tuple[str, ...]  # effects that were found and that the simulation does not have

    @property
    def summary(self) -> Simulated:
        """How it agrees with the recording, without samples."""
        return Simulated(self.run, self.before, self.after, self.left_out)

    @property
    def before(self) -> np.ndarray:
        """Root mean square of the difference to the recording, shape (n,) [N m]."""
        return _difference(self.measured - self.torque_before, self.weight)

    @property
    def after(self) -> np.ndarray:
        """Root mean square of the difference with what was found, shape (n,) [N m]."""
        return _difference(self.measured - self.torque_after, self.weight)


def _difference(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Root mean square, shape (n,); infinite or no number where a simulation has diverged."""
    with np.errstate(over="ignore", invalid="ignore"):
        return rms(values, weight)


def forward(diagnosis: Diagnosis, recording: Recording) -> Forward | None:
    """Simulate a run before and after; None for a diagnosis without evidence.

    Args:
        diagnosis: With its evidence.
        recording: One of its runs; best one that was held out.

    Raises:
        RobotError: The arm cannot be simulated: for example a joint without inertia.
    """
    if (known := diagnosis.evidence) is None:
        return None
    run = Driven.of(known.model, recording, "", known.filtering)
    # Parameters were fitted beside undecided findings too.
    findings = diagnosis.all_findings
    arms = as_nominal(known), as_found(known, findings)
    # An arm that diverges ends in infinity; what follows is no number, and reported as none.
    with np.errstate(over="ignore", invalid="ignore"):
        # The run is without the measurements that the nominal model holds.
        before, after = (_followed(arm.without(known.model.measurements), run) for arm in arms)
        torques = [run.thinned(run.prepared.gain * one["current"].values) for one in (before, after)]
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
    """What sensors of the arm measure along the run's motion; it is as warm as it was in the run's middle."""
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
