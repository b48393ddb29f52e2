"""From a recording to motion and current on one even time axis, filtered as in the paper's section III."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy import ndimage

from ..arm.motion import Motion
from ..errors import NotExcited, NotRecorded, RecordingError
from ..recordings.recording import EFFORT, Recording
from . import cutoffs
from .filtering import Filtering as Filtering
from .filters import Decimation, differentiate, low_pass, uniform
from .noise import noise_above, noise_at_rest, quantisation, smoothed
from .smoothing import recorded_band
from .torque_off import torque_off

REST, ABOVE = "rest", "high frequencies"
SMOOTHED_REST, SMOOTHED = SMOOTHED_SOURCES = "rest, smoothed", "smoothed"
"""Where a noise floor is from. Of a recording that was smoothed before, even that at rest is none."""
SHORTEST = 30.0
"""Periods of the torque's cut-off in a run, at least: three times the length of its filter."""
FEWEST = 64
"""Samples below which there is no spectrum to choose filters from; no filter fits such a run anyway."""


@dataclass(frozen=True)
class Prepared:
    """One run, ready to be compared with a model.

    Attributes:
        name: Name of the run.
        motion: Filtered motion at full rate, edges dropped.
        current: Motor currents at full rate, unfiltered, shape (t, n) [A]; torque [N m] where the
            controller gives that instead.
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
        link_position: Positions behind the gears, unfiltered, shape (t, n) [rad]; NaN where a joint has no
            second encoder, None if none was recorded.
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


@dataclass(frozen=True)
class _Even:
    """A recording on an even time axis, not yet filtered."""

    recording: Recording
    time: np.ndarray
    position: np.ndarray
    rate: float
    measures: str

    @classmethod
    def of(cls, recording: Recording, rate: float | None) -> "_Even":
        signal = recording.signals["position"]
        if len(signal) < FEWEST:
            raise RecordingError(
                f"{recording.name}: only {len(signal)} samples; record at least some seconds"
            )
        # Stamps are whole nanoseconds: they give a rate to mHz only.
        rate = rate or round(1.0 / float(np.median(np.diff(signal.time))), 3)
        time, position = uniform(signal.time, signal.values, rate)
        measures = next((name for name in EFFORT if len(recording.signals.get(name, ()))), "")
        if not measures:
            raise NotRecorded(
                f"{recording.name}: neither motor currents nor torques were recorded; set the controller up "
                "to send them, or put a trace of it beside the run (exidyn import --align)"
            )
        # Where one of the two was not recorded, there is nothing to compare.
        effort = recording.signals[measures].time
        both = (time > effort[0] - 1.5 / rate) & (time < effort[-1] + 1.5 / rate)
        if np.count_nonzero(both) < FEWEST:
            raise RecordingError(
                f"{recording.name}: position and {measures} share only {np.count_nonzero(both)} samples; "
                "are their time stamps from one clock?"
            )
        return cls(recording, time[both], position[both], rate, measures)

    @property
    def gain(self) -> np.ndarray:
        """Nominal torque per unit of what was measured, shape (n,)."""
        known = self.measures == "torque"
        return np.ones(self.position.shape[1]) if known else self.recording.robot.drive_gain

    @property
    def current(self) -> np.ndarray:
        return self.signal(self.measures)

    def signal(self, name: str) -> np.ndarray:
        """A signal of its own rate, on the even time axis."""
        signal = self.recording.signals[name]
        if (
            signal.time.shape == self.time.shape
            and np.max(np.abs(signal.time - self.time)) < 1e-3 / self.rate
        ):
            return np.array(signal.values)
        return np.stack([np.interp(self.time, signal.time, column) for column in signal.values.T], axis=1)


def choose(recording: Recording, filtering: Filtering) -> Filtering:
    """The filtering, with what it leaves open chosen from a recording.

    Raises:
        RecordingError: Too short to have a spectrum, or a cut-off that no filter can have.
    """
    even = _Even.of(recording, filtering.rate)
    filtering.check_cutoffs(even.rate, recording.name)
    position_cutoff = filtering.position_cutoff or cutoffs.position_cutoff(even.position, even.rate)
    torque_cutoff = filtering.torque_cutoff or min(
        cutoffs.torque_cutoff(recording.model, even.position, even.current, even.gain, even.rate),
        _recorded_up_to(even, position_cutoff),
    )
    # Positions are low-passed first: beyond 0.7 of that cut-off accelerations are short.
    torque_cutoff = min(torque_cutoff, 0.7 * position_cutoff)
    return replace(filtering, rate=even.rate, position_cutoff=position_cutoff, torque_cutoff=torque_cutoff)


def recorded_up_to(recording: Recording, filtering: Filtering) -> float:
    """Frequency up to which torque or current was recorded [Hz], as far as the run is long enough for it.

    Args:
        recording: One run.
        filtering: As chosen for it.
    """
    return _recorded_up_to(_Even.of(recording, filtering.rate), float(filtering.position_cutoff or 0.0))


def _recorded_up_to(even: _Even, position_cutoff: float) -> float:
    band = recorded_band(even.recording.model, _whole_motion(even, position_cutoff), even.current, even.rate)
    return max(band, SHORTEST * even.rate / len(even.time))


def prepare(recording: Recording, filtering: Filtering = Filtering()) -> Prepared:  # noqa: B008
    """Resample, filter, differentiate, find standstill and noise.

    Raises:
        RecordingError: Too short for its filters, or a standstill above all speeds.
        NotExcited: No joint moves.
    """
    if None in (filtering.rate, filtering.position_cutoff, filtering.torque_cutoff):
        filtering = choose(recording, filtering)
    even = _Even.of(recording, filtering.rate)
    cutoff = float(filtering.position_cutoff or 0.0)
    decimation = Decimation.at(even.rate, float(filtering.torque_cutoff or 0.0))
    inside = _inside(even, cutoff, decimation)
    motion, current = _whole_motion(even, cutoff), even.current
    filtering.check_standstill(motion.velocity, recording.name)
    off = torque_off(current, motion.position, even.rate)
    near = ndimage.binary_dilation(
        off, np.ones((len(decimation.taps), 1))
    )  # all that the filter takes of them
    sliding = (np.abs(motion.velocity) >= _standstill(motion, filtering)) & ~near
    noise, source = _noise(current, motion, decimation)
    if smoothed(recording.signals[even.measures].values, even.rate):
        source = SMOOTHED_REST if source == REST else SMOOTHED
    if not np.any(sliding):
        raise NotExcited(f"{recording.name}: no joint moves; record an exciting trajectory")
    return Prepared(
        name=recording.name,
        motion=motion[inside],
        current=current[inside],
        measures=even.measures,
        gain=even.gain,
        sliding=sliding[inside],
        decimation=decimation,
        position_cutoff=cutoff,
        noise=np.maximum(noise, quantisation(recording.signals[even.measures].values, decimation)),
        noise_source=source,
        encoder_noise=np.sqrt(0.5 * even.rate * cutoffs.spectra(even.position, even.rate)[2]),
        commanded=_commanded(even, cutoff, motion, inside),
        known=recording.payload.known if recording.payload else (),
        link_position=even.signal("link_position")[inside] if "link_position" in recording.signals else None,
        off=off[inside].sum(axis=0) / even.rate,
    )


def filtered(recording: Recording, filtering: Filtering) -> tuple[Motion, np.ndarray]:
    """Motion and current of a whole run at full rate, the filters' transients at both ends included.

    For a comparison with figures that others made without dropping edges; a fit takes `prepare`.

    Returns:
        Filtered motion, and currents as measured, shape (t, n) [A], or [N m] where the controller gave that.

    Raises:
        RecordingError: Too short to have a spectrum.
    """
    even = _Even.of(recording, filtering.rate)
    cutoff = filtering.position_cutoff or cutoffs.position_cutoff(even.position, even.rate)
    return _whole_motion(even, cutoff), even.current


def _inside(even: _Even, cutoff: float, decimation: Decimation) -> slice:
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


def _whole_motion(even: _Even, cutoff: float) -> Motion:
    """Filtered motion, its ends included."""
    smooth = low_pass(even.position, even.rate, cutoff)
    velocity, acceleration = _derivatives(even, smooth, cutoff)
    temperature = even.signal("temperature") if "temperature" in even.recording.signals else None
    payload = even.recording.payload.name if even.recording.payload else ""
    return Motion.of(even.time, smooth, velocity, acceleration, None, temperature, payload)


def _derivatives(even: _Even, smooth: np.ndarray, cutoff: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and acceleration; from the controller's own velocity where it can be trusted.

    A controller counts encoder ticks on its own clock, so its velocity knows nothing of the jitter of
    time stamps. But it comes later than the position, by half the time over which they are counted and by
    what its filter takes: a millisecond or two, of which inertia would look like damping. So it is brought
    to the position's time first. It is trusted if it then differs from the differentiated position by less
    than a twentieth on every joint: a velocity of another quantity, unit or filter differs by more.
    """
    velocity, acceleration = differentiate(smooth, even.rate)
    if "velocity" not in even.recording.signals:
        return velocity, acceleration
    recorded = _in_time(low_pass(even.signal("velocity"), even.rate, cutoff), velocity, even.rate)
    apart = np.linalg.norm(recorded - velocity, axis=0) / np.maximum(np.linalg.norm(velocity, axis=0), 1e-12)
    if not np.all(apart < 0.05):
        return velocity, acceleration
    return recorded, differentiate(recorded, even.rate)[0]


def _in_time(recorded: np.ndarray, velocity: np.ndarray, rate: float) -> np.ndarray:
    """A velocity that comes too late, each joint by its own time, to first order in that time."""
    slope = differentiate(recorded, rate)[0]
    delay = np.sum(slope * (velocity - recorded), axis=0) / np.maximum(np.sum(slope**2, axis=0), 1e-12)
    return recorded + delay * slope


def _commanded(even: _Even, cutoff: float, measured: Motion, inside: slice) -> Motion | None:
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


def _standstill(motion: Motion, filtering: Filtering) -> np.ndarray:
    """Speed below which each joint counts as standing still, shape (n,) [rad/s].

    Friction of a stuck joint is whatever holds it. One per cent of the joint's usual speed is where a
    sliding joint passes through within milliseconds, so little is lost.
    """
    if filtering.standstill is not None:
        return np.full(motion.position.shape[1], filtering.standstill)
    return 0.01 * _usual_speed(motion)


def _usual_speed(motion: Motion) -> np.ndarray:
    """What each joint exceeds in a twentieth of the run, shape (n,) [rad/s]; never zero."""
    return np.maximum(np.percentile(np.abs(motion.velocity), 95, axis=0), 1e-6)


def _noise(current: np.ndarray, motion: Motion, decimation: Decimation) -> tuple[np.ndarray, str]:
    """Noise floor of each current behind the filter, shape (n,), and where it was measured.

    A joint rests below a tenth of the speed at which it counts as standing still: creeping, it would
    still reverse its friction.
    """
    still = np.all(np.abs(motion.velocity) < 1e-3 * _usual_speed(motion), axis=1)
    noise = noise_at_rest(current, still, decimation)
    if np.all(np.isfinite(noise)):
        return noise, REST
    return noise_above(current, decimation), ABOVE
