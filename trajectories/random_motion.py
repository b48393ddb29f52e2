"""Random motion that is not optimized, for examples, tests and comparisons."""

from dataclasses import dataclass

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits


@dataclass(frozen=True)
class RampedFourier:
    """Position centre + sum over harmonics k of sine_k sin(k w s) + cosine_k cos(k w s).

    The phase s starts and ends at rest: it speeds up over `ramp`, and the arm rests for `rest` before
    and after, so that a recording also contains the noise of a still arm.
    """

    period: float  # base period [s]
    centre: np.ndarray  # center of the motion, shape (n,) [rad]
    sine: np.ndarray  # sine coefficients, shape (n, harmonics) [rad]
    cosine: np.ndarray  # cosine coefficients, shape (n, harmonics) [rad]
    duration: float  # time from start to end, rests included [s]
    ramp: float = 2.0  # time to speed up and to slow down [s]
    rest: float = 1.0  # time at rest at either end [s]

    def at(self, time: np.ndarray) -> Motion:
        """Motion at times of shape (t,) [s]."""
        phase, rate, change = self._phase(time)
        angle = 2 * np.pi / self.period * np.arange(1, self.sine.shape[1] + 1)
        wave, turn = np.sin(np.outer(phase, angle)), np.cos(np.outer(phase, angle))
        position = self.centre + wave @ self.sine.T + turn @ self.cosine.T
        slope = (turn * angle) @ self.sine.T - (wave * angle) @ self.cosine.T
        bend = -(wave * angle**2) @ self.sine.T - (turn * angle**2) @ self.cosine.T
        velocity = slope * rate[:, None]
        acceleration = bend * rate[:, None] ** 2 + slope * change[:, None]
        return Motion.of(time, position, velocity, acceleration)

    def _phase(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Phase [s] and its first two derivatives; its rate ramps from 0 to 1 and back along quintics."""
        moving = self.duration - 2 * self.rest
        since = np.clip(time - self.rest, 0.0, moving)
        up, down = np.clip(since / self.ramp, 0, 1), np.clip((moving - since) / self.ramp, 0, 1)
        phase = self.ramp * (_step_integral(up) - 0.5) + np.maximum(since - self.ramp, 0.0)
        phase -= np.where(down < 1, (1 - down) * self.ramp - self.ramp * (0.5 - _step_integral(down)), 0.0)
        rate = _step(up) * _step(down)
        change = (_step_slope(up) * (up < 1) - _step_slope(down) * (down < 1)) / self.ramp
        return phase + 0.5 * self.ramp, rate, change


def _step(share: np.ndarray) -> np.ndarray:
    """Smooth step from 0 to 1 with zero slope and curvature at both ends."""
    return share**3 * (10 - 15 * share + 6 * share**2)


def _step_slope(share: np.ndarray) -> np.ndarray:
    return 30 * share**2 * (1 - share) ** 2


def _step_integral(share: np.ndarray) -> np.ndarray:
    """Integral of the smooth step."""
    return share**4 * (2.5 - 3 * share + share**2)


def random_fourier(
    limits: Limits, duration: float, period: float = 10.0, harmonics: int = 5, seed: int = 0
) -> RampedFourier:
    """A Fourier motion with random coefficients that keeps to 90 % of the limits; not optimized."""
    random = np.random.default_rng(seed)
    lower, upper = np.maximum(limits.position_lower, -np.pi), np.minimum(limits.position_upper, np.pi)
    n = len(lower)
    centre = 0.5 * (lower + upper)
    sine, cosine = random.normal(size=(2, n, harmonics)) / np.arange(1, harmonics + 1)
    trial = RampedFourier(period, centre, sine, cosine, duration)
    motion = trial.at(np.arange(0.0, duration, 0.01))
    room = np.stack(
        [
            0.5 * (upper - lower) / np.max(np.abs(motion.position - centre), axis=0),
            limits.velocity / np.max(np.abs(motion.velocity), axis=0),
            limits.acceleration / np.max(np.abs(motion.acceleration), axis=0),
        ]
    )
    scale = 0.9 * np.min(np.where(np.isfinite(room), room, np.inf), axis=0)[:, None]
    return RampedFourier(period, centre, scale * sine, scale * cosine, duration)
