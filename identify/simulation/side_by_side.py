"""Side by side: two recordings of one motion behind the same filters, on the time axis of one of them."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from ..errors import DifferentRobot, RecordingError
from ..fit.fit import Fit
from ..preparation.prepare import Filtering, Prepared, choose, prepare
from ..recordings.recording import EFFORT, Recording


def side_by_side(
    simulated: Recording, recorded: Recording, offset: float, fit: Fit | None = None
) -> tuple[str, Prepared, Prepared]:
    """Two recordings, sample by sample where both go on.

    Args:
        simulated: Of any simulator, or another run.
        recorded: Of the same joints; its time axis and its rate are those of both.
        offset: To be added to the time of the first [s].
        fit: Whose filters and noise level are taken; by default those of the two.

    Returns:
        What effort both have, and both with that in place of currents: "current" where both were recorded
        with it, else "torque", by nominal drive gains where there is only current.

    Raises:
        DifferentRobot: Not the same joints.
        RecordingError: No time in common, or too short for filters.
    """
    if simulated.robot.joints != recorded.robot.joints:
        raise DifferentRobot(
            f"{simulated.name} is of {', '.join(simulated.robot.joints)}, {recorded.name} of "
            f"{', '.join(recorded.robot.joints)}; give the joints the same names in the same order"
        )
    effort, runs = _alike(_shifted(simulated, offset), recorded)
    filtering = fit.filtering if fit else _narrower(runs)
    theirs, ours = (_as_effort(prepare(run, filtering), run, effort) for run in runs)
    if fit and fit.noise is not None:
        level = np.abs(fit.estimate.gain) * fit.noise if effort != fit.measures == "current" else fit.noise
        ours = replace(ours, noise=level, noise_source=fit.noise_source)
    return effort, *_together(theirs, ours)


def _shifted(recording: Recording, offset: float) -> Recording:
    signals = {name: replace(signal, time=signal.time + offset) for name, signal in recording.signals.items()}
    return replace(recording, signals=signals, host_time=None)


def _alike(first: Recording, second: Recording) -> tuple[str, tuple[Recording, Recording]]:
    """What effort is compared, and both recordings without the other kind where both have this one."""
    common = next((name for name in EFFORT if name in first.signals and name in second.signals), None)
    left_out = {"velocity"} | (set(EFFORT) - {common} if common else set())
    return common or "torque", (_without(first, left_out), _without(second, left_out))


def _without(recording: Recording, names: set[str]) -> Recording:
    """The recording without some signals; velocities are made from positions, by one filter for both."""
    kept = {name: signal for name, signal in recording.signals.items() if name not in names}
    return replace(recording, signals=kept)


def _narrower(runs: tuple[Recording, Recording]) -> Filtering:
    """Cut-offs that both can have: what one of them is too slow for is no mismatch."""
    chosen = [choose(run, Filtering()) for run in runs]
    return Filtering(
        position_cutoff=min(one.position_cutoff or np.inf for one in chosen),
        torque_cutoff=min(one.torque_cutoff or np.inf for one in chosen),
    )


def _as_effort(run: Prepared, recording: Recording, effort: str) -> Prepared:
    """The run with joint torque [N m] in place of its current, where torque is asked for."""
    if run.measures == effort:
        return run
    torque = (run.current * run.gain) @ recording.robot.coupling
    return replace(run, current=torque, noise=np.abs(run.gain) * run.noise, measures=effort)


def _together(theirs: Prepared, ours: Prepared) -> tuple[Prepared, Prepared]:
    """Both on our time axis, where both go on.

    Raises:
        RecordingError: That is nowhere, or too short for the filter.
    """
    time = ours.motion.time
    first, last = theirs.motion.time[[0, -1]]
    both = (time >= first) & (time <= last)
    if np.count_nonzero(both) < 2 * len(ours.decimation.taps):
        raise RecordingError(
            f"{theirs.name} and {ours.name} have {np.count_nonzero(both) / ours.decimation.rate:.2f} s in "
            f"common, filters at {ours.decimation.cutoff:.3g} Hz need "
            f"{2 * len(ours.decimation.taps) / ours.decimation.rate:.1f} s; state how far apart their clocks "
            "are (--offset)"
        )
    ours = replace(ours, motion=ours.motion[both], current=ours.current[both], sliding=ours.sliding[both])

    def there(values: np.ndarray) -> np.ndarray:
        return CubicSpline(theirs.motion.time, values)(time[both])

    motion = replace(
        ours.motion, position=there(theirs.motion.position), velocity=there(theirs.motion.velocity)
    )
    current = there(theirs.current)
    return replace(ours, name=theirs.name, motion=motion, current=current, noise=theirs.noise), ours
