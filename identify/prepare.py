"""From a recording to motion and current on one even time axis, filtered as in the paper's section III."""

from dataclasses import dataclass, replace

import numpy as np

from . import cutoffs
from .errors import NotExcited, RecordingError
from .filters import Decimation, differentiate, low_pass, uniform
from .motion import Motion
from .noise import noise_above, noise_at_rest
from .recording import Recording


@dataclass(frozen=True)
class Filtering:
    """How to filter; what is None is chosen from the data.

    Attributes:
        rate: Sample rate of the even time axis [Hz]; the recording's median rate by default.
        position_cutoff: Low-pass of positions before differentiation [Hz].
        torque_cutoff: Parallel decimation of torque and regressor [Hz].
        standstill: Speed below which a joint sticks rather than slides [rad/s], one for all joints.
    """

    rate: float | None = None
    position_cutoff: float | None = None
    torque_cutoff: float | None = None
    standstill: float | None = None


@dataclass(frozen=True)
class Prepared:
    """One run, ready to be compared with a model.

    Attributes:
        name: Name of the run.
        motion: Filtered motion at full rate, edges dropped.
        current: Motor currents at full rate, unfiltered, shape (t, n) [A]; torque [N m] where the
            controller gives that instead.
        measures: "current" or "torque".
        gain: Believed torque per unit of `current`, shape (n,).
        sliding: Whether the joint slides rather than sticks, shape (t, n).
        decimation: The filter through which torque and regressor are compared.
        position_cutoff: Low-pass that was used before differentiation [Hz].
        noise: Noise floor of `current` behind the decimation filter, shape (n,).
        noise_source: "rest" if measured while the arm stood still, else "high frequencies".
        encoder_noise: Standard deviation of the measured position's white noise, shape (n,) [rad].
        commanded: Motion that was commanded, filtered alike; None if it was not recorded.
        known: What is known of the payload carried: (parameter, value) pairs.
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
        """Share of each decimated sample's surroundings in which the joint slides, 0 or 1, (r, n)."""
        span = self.decimation.factor
        centres = self.decimation.centres(len(self.motion))
        counts = np.cumsum(np.pad(~self.sliding, ((span + 1, span), (0, 0))), axis=0)
        sticking = counts[centres + 2 * span + 1] - counts[centres]
        return (sticking == 0).astype(float)


def prepare(recording: Recording, filtering: Filtering = Filtering()) -> Prepared:  # noqa: B008
    """Resample, filter, differentiate, find standstill and noise.

    Raises:
        RecordingError: Too short for its filters.
        NotExcited: No joint moves.
    """
    signal = recording.signals["position"]
    rate = filtering.rate or 1.0 / float(np.median(np.diff(signal.time)))
    time, position = uniform(signal.time, signal.values, rate)
    measures = "current" if "current" in recording.signals else "torque"
    current = _onto(time, rate, recording, measures)
    position_cutoff = filtering.position_cutoff or cutoffs.position_cutoff(position, rate)
    gain = recording.model.robot.drive_gain if measures == "current" else np.ones(position.shape[1])
    cutoff = filtering.torque_cutoff or cutoffs.torque_cutoff(recording.model, position, current, gain, rate)
    decimation = Decimation.at(rate, min(cutoff, 0.7 * position_cutoff))
    motion, inside = _motion(recording, time, position, rate, position_cutoff, decimation)
    sliding = np.abs(motion.velocity) >= _standstill(motion, filtering)
    noise, source = _noise(current, motion, decimation)
    if not np.any(sliding):
        raise NotExcited(f"{recording.name}: no joint moves; record an exciting trajectory")
    return Prepared(
        name=recording.name,
        motion=motion[inside],
        current=current[inside],
        measures=measures,
        gain=gain,
        sliding=sliding[inside],
        decimation=decimation,
        position_cutoff=position_cutoff,
        noise=noise,
        noise_source=source,
        encoder_noise=np.sqrt(0.5 * rate * cutoffs.spectra(position, rate)[2]),
        commanded=_commanded(recording, time, rate, position_cutoff, inside),
        known=recording.payload.known if recording.payload else (),
    )


def _onto(time: np.ndarray, rate: float, recording: Recording, name: str) -> np.ndarray:
    """A signal of its own rate on the even time axis."""
    signal = recording.signals[name]
    if signal.time.shape == time.shape and np.max(np.abs(signal.time - time)) < 1e-3 / rate:
        return np.array(signal.values)
    return np.stack([np.interp(time, signal.time, column) for column in signal.values.T], axis=1)


def _motion(
    recording: Recording,
    time: np.ndarray,
    position: np.ndarray,
    rate: float,
    cutoff: float,
    decimation: Decimation,
) -> tuple[Motion, slice]:
    """Filtered motion, and the samples that the filters' transients do not reach."""
    smooth = low_pass(position, rate, cutoff)
    velocity, acceleration = _derivatives(recording, time, smooth, rate, cutoff)
    temperature = _onto(time, rate, recording, "temperature") if "temperature" in recording.signals else None
    payload = recording.payload.name if recording.payload else ""
    motion = Motion.of(time, smooth, velocity, acceleration, None, temperature, payload)
    # A fourth-order Butterworth has forgotten its start, to 1 %, after one period of its cut-off.
    edge = 3 + int(np.ceil(rate / cutoff))
    if len(time) - 2 * edge < 2 * len(decimation.taps):
        raise RecordingError(
            f"{recording.name}: {len(time) / rate:.2f} s is too short for filters at {cutoff:.3g} Hz and "
            f"{decimation.cutoff:.3g} Hz; record at least {3 * len(decimation.taps) / rate:.1f} s"
        )
    return motion, slice(edge, len(time) - edge)


def _derivatives(
    recording: Recording, time: np.ndarray, smooth: np.ndarray, rate: float, cutoff: float
) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and acceleration; from the controller's own velocity where it can be trusted.

    A controller counts encoder ticks on its own clock, so its velocity knows nothing of the jitter of
    time stamps. It is trusted if it differs from the differentiated position by less than a twentieth
    on every joint: a velocity of another quantity, unit or filter differs by more.
    """
    velocity, acceleration = differentiate(smooth, rate)
    if "velocity" not in recording.signals:
        return velocity, acceleration
    recorded = low_pass(_onto(time, rate, recording, "velocity"), rate, cutoff)
    apart = np.linalg.norm(recorded - velocity, axis=0) / np.maximum(np.linalg.norm(velocity, axis=0), 1e-12)
    if not np.all(apart < 0.05):
        return velocity, acceleration
    return recorded, differentiate(recorded, rate)[0]


def _standstill(motion: Motion, filtering: Filtering) -> np.ndarray:
    """Speed below which each joint counts as standing still, shape (n,) [rad/s].

    Friction of a stuck joint is whatever holds it. One per cent of the joint's usual speed is where a
    sliding joint passes through within milliseconds, so little is lost.
    """
    if filtering.standstill is not None:
        return np.full(motion.position.shape[1], filtering.standstill)
    return 0.01 * np.maximum(np.percentile(np.abs(motion.velocity), 95, axis=0), 1e-6)


def _noise(current: np.ndarray, motion: Motion, decimation: Decimation) -> tuple[np.ndarray, str]:
    usual = np.maximum(np.percentile(np.abs(motion.velocity), 95, axis=0), 1e-6)
    still = np.all(np.abs(motion.velocity) < 1e-3 * usual, axis=1)
    noise = noise_at_rest(current, still, decimation)
    if np.all(np.isfinite(noise)):
        return noise, "rest"
    return noise_above(current, decimation), "high frequencies"


def _commanded(
    recording: Recording, time: np.ndarray, rate: float, cutoff: float, inside: slice
) -> Motion | None:
    if "command" not in recording.signals:
        return None
    smooth = low_pass(_onto(time, rate, recording, "command"), rate, cutoff)
    velocity, acceleration = differentiate(smooth, rate)
    payload = recording.payload.name if recording.payload else ""
    motion = Motion.of(time, smooth, velocity, acceleration, payload=payload)
    return motion[inside]
