"""From a recording to motion and current on one even time axis, filtered as in the paper's section III."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy import ndimage

from ..arm.derivatives import differentiate
from ..arm.motion import Motion
from ..errors import NotExcited, RecordingError
from ..recordings.recording import Recording
from . import cutoffs
from .clipped import filled, is_clipped
from .even import Even, torque_off
from .filters import Decimation, low_pass
from .noise import noise_above, noise_at_rest, quantisation, smoothed

REST, ABOVE = "rest", "high frequencies"
SMOOTHED_REST, SMOOTHED = SMOOTHED_SOURCES = "rest, smoothed", "smoothed"
"""Where a noise floor is from. Of a recording that was smoothed before, even that at rest is none."""
SHORTEST = 30.0
"""Periods of the torque's cut-off in a run, at least: three times the length of its filter."""
FROM_DATA = "leave it out to have it chosen from the data"


@dataclass(frozen=True)
class Filtering:
    """How to filter; what is None is chosen from the data.

    Attributes:
        rate: Sample rate of the even time axis [Hz]; the recording's median rate by default.
        position_cutoff: Low-pass of positions before differentiation [Hz].
        torque_cutoff: Parallel decimation of torque and regressor [Hz].
        standstill: Speed below which a joint sticks rather than slides [rad/s], one for all joints.

    Raises:
        RecordingError: One that is not above zero.
    """

    rate: float | None = None
    position_cutoff: float | None = None
    torque_cutoff: float | None = None
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
        """Refuse a cut-off that no filter of a run at this rate [Hz] can have.

        Raises:
            RecordingError: Not below half the sample rate.
        """
        for option, cutoff in self._cutoffs:
            if cutoff is not None and not cutoff < 0.5 * rate:
                raise RecordingError(
                    f"{option} is {cutoff:g} Hz; it must lie below {0.5 * rate:g} Hz, half the sample "
                    f"rate of {run}; {FROM_DATA}"
                )


@dataclass(frozen=True)
class Prepared:
    """One run, ready to be compared with a model.

    Attributes:
        name: Name of the run.
        motion: Filtered motion at full rate, edges dropped.
        current: Motor currents at full rate, unfiltered, shape (t, n) [A]; torque [N m] where the
            controller gives that instead; as of rigid gears and constant drive gains, and not delayed.
        measures: "current" or "torque".
        gain: Nominal torque per unit of `current`, shape (n,).
        sliding: Whether the joint slides rather than sticks, shape (t, n).
        decimation: The filter through which torque and regressor are compared.
        position_cutoff: Low-pass that was used before differentiation [Hz].
        noise: Noise floor of `current` behind the decimation filter, shape (n,).
        noise_source: `REST` if measured while the arm stood still, else `ABOVE`; of a recording that was
            smoothed before it was recorded `SMOOTHED_REST` or `SMOOTHED`.
        encoder_noise: Standard deviation of the measured position's white noise, shape (n,) [rad].
        commanded: Motion that was commanded, filtered alike; None if it was not recorded.
        known: What is known of the payload carried: (parameter, value) pairs.
        link_position: Positions behind the gears, unfiltered, without the twist of gears in the model, shape
            (t, n) [rad]; NaN where a joint has no second encoder, None if none was recorded.
        off: For how long each joint moved with its drive off, which does not count, shape (n,) [s].
    """

    name: str
    motion: Motion
    current: np.ndarray
    measures: str
    gain: np.ndarray
    sliding: np.ndarray
    decimation: Decimation
    position_cutoff: float
    noise: np.ndarray
    noise_source: str
    encoder_noise: np.ndarray
    commanded: Motion | None = None
    known: tuple[tuple[str, float], ...] = ()
    link_position: np.ndarray | None = None
    off: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @property
    def decimated_current(self) -> np.ndarray:
        """Current behind the decimation filter, shape (r, n)."""
        return self.decimation.apply(self.current)

    @property
    def decimated_time(self) -> np.ndarray:
        """Time of the decimated samples, shape (r,) [s]."""
        return self.motion.time[self.decimation.centres(len(self.motion))]

    @property
    def weight(self) -> np.ndarray:
        """1 where the joint slides all around a decimated sample, else 0, shape (r, n)."""
        span = self.decimation.factor
        centres = self.decimation.centres(len(self.motion))
        counts = np.cumsum(np.pad(~self.sliding, ((span + 1, span), (0, 0))), axis=0)
        sticking = counts[centres + 2 * span + 1] - counts[centres]
        return (sticking == 0).astype(float)


def choose(recording: Recording, filtering: Filtering) -> Filtering:
    """The filtering, with what it leaves open chosen from a recording.

    Raises:
        RecordingError: Too short to have a spectrum, or a cut-off that no filter can have.
    """
    return _chosen(Even.of(recording, filtering.rate), filtering)


def _chosen(even: Even, filtering: Filtering) -> Filtering:
    filtering.check_cutoffs(even.rate, even.recording.name)
    position_cutoff = filtering.position_cutoff or cutoffs.position_cutoff(even.position, even.rate)
    torque_cutoff = filtering.torque_cutoff
    if torque_cutoff is None:
        model, current = even.recording.model, even.signal(even.measures)
        comparable = cutoffs.torque_cutoff(model, even.position, current, even.gain, even.rate)
        torque_cutoff = min(comparable, _recorded_up_to(even, position_cutoff))
    # Positions are low-passed first: beyond 0.7 of that cut-off accelerations are short.
    torque_cutoff = min(torque_cutoff, 0.7 * position_cutoff)
    return replace(filtering, rate=even.rate, position_cutoff=position_cutoff, torque_cutoff=torque_cutoff)


def recorded_up_to(recording: Recording, filtering: Filtering) -> float:
    """Frequency up to which torque or current was recorded [Hz], as far as the run is long enough for it."""
    return _recorded_up_to(Even.of(recording, filtering.rate), float(filtering.position_cutoff or 0.0))


def _recorded_up_to(even: Even, position_cutoff: float) -> float:
    motion, current = even.motion(position_cutoff), even.signal(even.measures)
    band = cutoffs.recorded_band(even.recording.model, motion, current, even.rate)
    return max(band, SHORTEST * even.rate / len(even.time))


def prepare(recording: Recording, filtering: Filtering = Filtering()) -> Prepared:  # noqa: B008
    """Resample, filter and differentiate; find standstill and noise.

    Raises:
        RecordingError: Too short for its filters, or a standstill above all speeds.
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
    # All samples that the decimation filter takes from where a drive was off.
    near = ndimage.binary_dilation(off, np.ones((len(decimation.taps), 1))) | clipped
    # Never zero: what each joint exceeds in a twentieth of the run, shape (n,) [rad/s].
    usual_speed = np.maximum(np.percentile(np.abs(motion.velocity), 95, axis=0), 1e-6)
    sliding = (np.abs(motion.velocity) >= _standstill(motion, filtering, usual_speed, recording.name)) & ~near
    measured = recording.signals[even.measures].values
    # Below a tenth of the speed at which a joint counts as standing still: creeping, it would still reverse
    # its friction.
    still = np.all(np.abs(motion.velocity) < 1e-3 * usual_speed, axis=1)
    noise, source = noise_at_rest(current, still, decimation), REST
    if not np.all(np.isfinite(noise)):
        noise, source = noise_above(current, decimation), ABOVE
    if smoothed(measured, even.rate):
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
        decimation=decimation,
        position_cutoff=cutoff,
        noise=np.maximum(noise, quantisation(measured, decimation)),
        noise_source=source,
        encoder_noise=np.sqrt(0.5 * even.rate * cutoffs.spectra(even.position, even.rate)[2]),
        commanded=_commanded(even, cutoff, motion, inside),
        known=recording.payload.known if recording.payload else (),
        link_position=None if behind is None else behind[inside],
        off=off[inside].sum(axis=0) / even.rate,
    )


def _of_rigid_arm(
    even: Even, motion: Motion, current: np.ndarray, clipped: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None]:
    """Currents (t, n), and positions behind the gears, as of an arm with rigid gears and constant gains."""
    model = even.recording.model
    behind = even.signal("link_position") if "link_position" in even.recording.signals else None
    if not model.measurements:
        return current, behind
    torque = model.restored(even.gain * filled(model, motion, current, even.gain, clipped))
    more, lead = model.gear_torque(motion)
    current = (torque - more @ model.robot.to_motors.T) / even.gain
    return current, None if behind is None else behind + lead


def filtered(recording: Recording, filtering: Filtering) -> tuple[Motion, np.ndarray]:
    """Motion and current of a whole run at full rate, the filters' transients at both ends included.

    For a comparison with figures that others made without dropping edges; a fit takes `prepare`.

    Returns:
        Filtered motion, and currents as measured, shape (t, n) [A], or [N m] where the controller gave that.

    Raises:
        RecordingError: Too short to have a spectrum.
    """
    even = Even.of(recording, filtering.rate)
    cutoff = filtering.position_cutoff or cutoffs.position_cutoff(even.position, even.rate)
    return even.motion(cutoff), even.signal(even.measures)


def _inside(even: Even, cutoff: float, decimation: Decimation) -> slice:
    """The samples that the filters' transients do not reach.

    A fourth-order Butterworth's start makes accelerations wrong by 4 % after one period of its cut-off and
    by 0.3 % after two; the decimation filter, of ten periods, is centred further in.
    """
    edge, samples = 3 + int(np.ceil(even.rate / cutoff)), len(even.time)
    if samples - 2 * edge < 2 * len(decimation.taps):
        raise RecordingError(
            f"{even.recording.name}: {samples / even.rate:.2f} s is too short for filters at {cutoff:.3g} Hz "
            f"and {decimation.cutoff:.3g} Hz; record at least {3 * len(decimation.taps) / even.rate:.1f} s"
        )
    return slice(edge, samples - edge)


def _commanded(even: Even, cutoff: float, measured: Motion, inside: slice) -> Motion | None:
    """The commanded motion, at the temperature and with the payload that were measured."""
    recorded = even.recording.signals.get("command")
    if recorded is None or not len(recorded):  # a run that was stopped before its first command
        return None
    command = even.signal("command")
    if not np.all(np.isfinite(command)):  # a joint whose command was not recorded
        return None
    smooth = low_pass(command, even.rate, cutoff)
    velocity, acceleration = differentiate(smooth, even.rate)
    return replace(measured, position=smooth, velocity=velocity, acceleration=acceleration)[inside]


def _standstill(motion: Motion, filtering: Filtering, usual_speed: np.ndarray, run: str) -> np.ndarray:
    """Speed below which each joint counts as standing still, shape (n,) [rad/s].

    Friction of a stuck joint is whatever holds it. One per cent of the joint's usual speed is where a
    sliding joint passes through within milliseconds, so little is lost.
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
