"""Preparation of a recording: motion and current on an even time axis, filtered (paper, section III)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import ndimage

from ..arm.motion import Motion
from ..errors import NotExcited, RecordingError
from ..recordings.recording import Recording
from ..recordings.servo_error import is_servo_error
from . import spectra
from .even import Even, filled, is_clipped, torque_off
from .filters import Decimation

REST, ABOVE = "rest", "high frequencies"
SMOOTHED_REST, SMOOTHED = SMOOTHED_SOURCES = "rest, smoothed", "smoothed"
"""Source of a noise floor. If a recording was filtered before, even its noise at rest is too low."""
SHORTEST = 30.0
"""Minimum duration of a run in periods of the torque's cut-off: three times the length of its filter."""
FROM_DATA = "leave it out to have it chosen from the data"


@dataclass(frozen=True)
class Filtering:
    """Options of the filters; an option that is None is chosen from the data.

    Raises:
        RecordingError: An option is not above zero.
    """

    # Sampling rate of the even time axis [Hz]; the recording's median rate by default.
    rate: float | None = None
    position_cutoff: float | None = None  # cut-off of the low-pass of positions before differentiation [Hz]
    torque_cutoff: float | None = None  # cut-off of the parallel decimation of torque and regressor [Hz]
    # Speed below which a joint sticks rather than slides, the same for all joints [rad/s].
    standstill: float | None = None

    def __post_init__(self) -> None:
        for option, value in (*self._cutoffs, ("--standstill", self.standstill)):
            unit = "rad/s" if option == "--standstill" else "Hz"
            if value is not None and not value > 0.0:
                raise RecordingError(f"{option} is {value:g} {unit}; it must be above 0; {FROM_DATA}")

    @property
    def _cutoffs(self) -> tuple[tuple[str, float | None], ...]:
        return ("--position-cutoff", self.position_cutoff), ("--torque-cutoff", self.torque_cutoff)

    def check_cutoffs(self, rate: float, run: str) -> None:
        """Refuse a cut-off that is too high for a run at this sampling rate [Hz].

        Raises:
            RecordingError: A cut-off is not below half the sampling rate.
        """
        for option, cutoff in self._cutoffs:
            if cutoff is not None and not cutoff < 0.5 * rate:
                raise RecordingError(
                    f"{option} is {cutoff:g} Hz; it must lie below {0.5 * rate:g} Hz, half the sample "
                    f"rate of {run}; {FROM_DATA}"
                )


@dataclass(frozen=True)
class Prepared:
    """One run, ready to be compared with a model."""

    name: str  # name of the run
    motion: Motion  # filtered motion at full rate, edges dropped
    # Motor currents at full rate, unfiltered, shape (t, n) [A], or torques [N m] if the controller records
    # those; converted to those of rigid gears and constant drive gains, without delay.
    current: np.ndarray
    measures: str  # measured effort, "current" or "torque"
    gain: np.ndarray  # nominal torque per unit of `current`, shape (n,)
    sliding: np.ndarray  # whether the joint slides rather than sticks, shape (t, n)
    standstill: np.ndarray  # speed below which each joint counts as standing still, shape (n,) [rad/s]
    decimation: Decimation  # filter through which torque and regressor are compared
    position_cutoff: float  # cut-off of the low-pass before differentiation [Hz]
    noise: np.ndarray  # noise floor of `current` behind the decimation filter, shape (n,)
    # `REST` if measured while the arm stood still, else `ABOVE`; `SMOOTHED_REST` or `SMOOTHED` if the effort
    # was filtered before it was recorded.
    noise_source: str
    encoder_noise: np.ndarray  # standard deviation of the measured position's white noise, shape (n,) [rad]
    # Positions behind the gears, unfiltered, without the twist of gears in the model, shape (t, n) [rad]; NaN
    # if a joint has no second encoder, None if no link positions were recorded.
    link_position: np.ndarray | None = None
    # Time in which each joint moved with its drive off, which has no weight, shape (n,) [s].
    off: np.ndarray = field(default_factory=lambda: np.zeros(0))
    # Whether the torque is computed from commands and these positions, by a servo whose delay is known.
    computed: bool = False

    @property
    def decimated_current(self) -> np.ndarray:
        """Current behind the decimation filter, shape (r, n)."""
        return self.decimation.apply(self.current)

    @property
    def decimated_position(self) -> np.ndarray:
        """Positions at the decimated samples, shape (r, n) [rad]."""
        return self.motion.position[self.decimation.centres(len(self.motion))]

    @property
    def decimated_time(self) -> np.ndarray:
        """Time of the decimated samples, shape (r,) [s]."""
        return self.motion.time[self.decimation.centres(len(self.motion))]

    @property
    def weight(self) -> np.ndarray:
        """1 if the joint slides throughout the neighborhood of a decimated sample, else 0, shape (r, n)."""
        span = self.decimation.factor
        centres = self.decimation.centres(len(self.motion))
        counts = np.cumsum(np.pad(~self.sliding, ((span + 1, span), (0, 0))), axis=0)
        sticking = counts[centres + 2 * span + 1] - counts[centres]
        return (sticking == 0).astype(float)


def torque_off_warnings(joints: Sequence[str], runs: Sequence[Prepared]) -> Iterator[str]:
    """Warnings about samples that are not used because a drive was off."""
    for run in runs:
        for joint, seconds in zip(joints, run.off, strict=True):
            if seconds > 0.0:
                yield (
                    f"{run.name}: the {run.measures} of {joint} is exactly zero for {seconds:.1f} s in which "
                    "it moves: its drive was off, or its resolution is too low; these samples are not used"
                )


def choose(recording: Recording, filtering: Filtering) -> Filtering:
    """Filtering in which every option that is None was chosen from a recording.

    Raises:
        RecordingError: The recording is too short for a spectrum, or a cut-off is too high.
    """
    return _chosen(Even.of(recording, filtering.rate), filtering)


def _chosen(even: Even, filtering: Filtering) -> Filtering:
    filtering.check_cutoffs(even.rate, even.recording.name)
    position_cutoff = filtering.position_cutoff or spectra.position_cutoff(even.position, even.rate)
    torque_cutoff = filtering.torque_cutoff
    if torque_cutoff is None:
        model, current = even.recording.model, even.signal(even.measures)
        comparable = spectra.torque_cutoff(model, even.position, current, even.gain, even.rate)
        torque_cutoff = min(comparable, _recorded_up_to(even, position_cutoff))
    # Positions are low-passed first, which attenuates accelerations beyond 0.7 of that cut-off.
    torque_cutoff = min(torque_cutoff, 0.7 * position_cutoff)
    return replace(filtering, rate=even.rate, position_cutoff=position_cutoff, torque_cutoff=torque_cutoff)


def recorded_up_to(recording: Recording, filtering: Filtering) -> float:
    """Frequency up to which torque or current was recorded [Hz], and at least what the run can resolve."""
    return _recorded_up_to(Even.of(recording, filtering.rate), float(filtering.position_cutoff or 0.0))


def _recorded_up_to(even: Even, position_cutoff: float) -> float:
    motion, current = even.motion(position_cutoff), even.signal(even.measures)
    band = spectra.recorded_band(even.recording.model, motion, current, even.rate)
    return max(band, SHORTEST * even.rate / len(even.time))


def prepare(recording: Recording, filtering: Filtering = Filtering()) -> Prepared:  # noqa: B008
    """Resample, filter and differentiate; find standstill and noise.

    Raises:
        RecordingError: The recording is too short for its filters, or `standstill` exceeds all speeds.
        NotExcited: No joint moves.
    """
    even = Even.of(recording, filtering.rate)
    if None in (filtering.rate, filtering.position_cutoff, filtering.torque_cutoff):
        filtering = _chosen(even, filtering)
    cutoff = float(filtering.position_cutoff or 0.0)
    decimation = Decimation.at(even.rate, float(filtering.torque_cutoff or 0.0))
    inside = _inside(even, cutoff, decimation)
    motion, current = even.motion(cutoff), even.signal(even.measures)
    model = recording.model
    driven = ~np.isin(recording.robot.joints, recording.robot.passive)
    off = torque_off(current, motion.position, even.rate) & driven
    clipped = is_clipped(model, current, decimation.factor)
    # All samples whose decimation filter extends over samples in which a drive was off.
    excluded = ndimage.binary_dilation(off, np.ones((len(decimation.taps), 1))) | clipped
    # Speed that each joint exceeds in a twentieth of the run, above zero, shape (n,) [rad/s].
    usual_speed = np.maximum(np.percentile(np.abs(motion.velocity), 95, axis=0), 1e-6)
    standstill = _standstill(motion, filtering, usual_speed, recording.name)
    sliding = (np.abs(motion.velocity) >= standstill) & ~excluded
    measured = recording.signals[even.measures].values
    # A tenth of the speed below which a joint counts as stuck: a creeping joint would still reverse its
    # friction.
    still = np.all(np.abs(motion.velocity) < 1e-3 * usual_speed, axis=1)
    noise, source = spectra.noise_at_rest(current, still, decimation), REST
    computed = even.measures == "torque" and is_servo_error(recording.settings)
    # A torque computed from the steps of an encoder is constant while the arm stands still.
    if computed or not np.all(np.isfinite(noise)):
        noise, source = spectra.noise_above(current, decimation), ABOVE
    if spectra.smoothed(measured, even.rate):
        source = SMOOTHED_REST if source == REST else SMOOTHED
    rigid, behind = _of_rigid_arm(even, motion, current, clipped)
    if not np.any(sliding):
        raise NotExcited(f"{recording.name}: no joint moves; record an exciting trajectory")
    return Prepared(
        name=recording.name,
        motion=motion[inside],
        current=rigid[inside],
        measures=even.measures,
        gain=even.gain,
        sliding=sliding[inside],
        standstill=standstill,
        decimation=decimation,
        position_cutoff=cutoff,
        noise=np.maximum(noise, spectra.quantization(measured, decimation)),
        noise_source=source,
        encoder_noise=np.sqrt(0.5 * even.rate * spectra.noise_spectra(even.position, even.rate)[2]),
        link_position=None if behind is None else behind[inside],
        off=off[inside].sum(axis=0) / even.rate,
        computed=computed,
    )


def _of_rigid_arm(
    even: Even, motion: Motion, current: np.ndarray, clipped: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None]:
    """Currents (t, n) and positions behind the gears of an arm with rigid gears and constant drive gains."""
    model = even.recording.model
    behind = even.signal("link_position") if "link_position" in even.recording.signals else None
    if not model.measurements:
        return current, behind
    torque = model.restored(even.gain * filled(model, motion, current, even.gain, clipped))
    compliance_torque, lead = model.gear_torque(motion)
    current = (torque - compliance_torque @ model.robot.to_motors.T) / even.gain
    return current, None if behind is None else behind + lead


def filtered(recording: Recording, filtering: Filtering) -> tuple[Motion, np.ndarray]:
    """Motion and current of a run at full rate, including the transients of the filters at both ends.

    Use it to compare with published figures that include the transients; a fit uses `prepare`.

    Returns:
        Filtered motion, and measured currents, shape (t, n) [A], or torques [N m] if those were recorded.

    Raises:
        RecordingError: The recording is too short for a spectrum.
    """
    even = Even.of(recording, filtering.rate)
    cutoff = filtering.position_cutoff or spectra.position_cutoff(even.position, even.rate)
    return even.motion(cutoff), even.signal(even.measures)


def _inside(even: Even, cutoff: float, decimation: Decimation) -> slice:
    """Samples beyond the reach of the filters' transients.

    The transient of a fourth-order Butterworth filter makes accelerations wrong by 4 % after one period of
    its cut-off and by 0.3 % after two; the decimation filter, of ten periods, is centered further in.
    """
    edge, samples = 3 + int(np.ceil(even.rate / cutoff)), len(even.time)
    if samples - 2 * edge < 2 * len(decimation.taps):
        raise RecordingError(
            f"{even.recording.name}: {samples / even.rate:.2f} s is too short for filters at {cutoff:.3g} Hz "
            f"and {decimation.cutoff:.3g} Hz; record at least {3 * len(decimation.taps) / even.rate:.1f} s"
        )
    return slice(edge, samples - edge)


def _standstill(motion: Motion, filtering: Filtering, usual_speed: np.ndarray, run: str) -> np.ndarray:
    """Speed below which each joint counts as standing still, shape (n,) [rad/s].

    The friction of a stuck joint may have any value that holds it. The default is 1 % of the joint's usual
    speed, which a sliding joint passes within milliseconds, so few samples are lost.
    """
    if filtering.standstill is None:
        return 0.01 * usual_speed
    fastest = float(np.max(np.abs(motion.velocity)))
    if not filtering.standstill <= fastest:
        raise RecordingError(
            f"--standstill is {filtering.standstill:g} rad/s; it must lie below {fastest:.3g} rad/s, the "
            f"highest speed of any joint in {run}; {FROM_DATA}"
        )
    return np.full(len(usual_speed), filtering.standstill)
