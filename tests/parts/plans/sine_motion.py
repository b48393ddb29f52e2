"""A trajectory of one sine a joint, whose extremes are known without any code of ours."""

from dataclasses import dataclass

import numpy as np

from exidyn.trajectories.trajectory import Extremes, Range, States, Trajectory


@dataclass(frozen=True, eq=False)
class SineMotion(Trajectory):
    """Joint j at centre + amplitude sin(rate t + phase); every array of shape (n,)."""

    centre: np.ndarray
    amplitude: np.ndarray
    rate: np.ndarray
    phase: np.ndarray
    seconds: float

    @property
    def duration(self):
        return self.seconds

    @property
    def dof(self):
        return len(self.centre)

    def at(self, time):
        time = self.inside(time)
        angle = np.outer(time, self.rate) + self.phase
        wave, turn = self.amplitude * np.sin(angle), self.amplitude * np.cos(angle)
        w = self.rate
        return States(time, self.centre + wave, w * turn, -(w**2) * wave, -(w**3) * turn)

    def extremes(self):
        """Those of whole periods, which hold those of any part."""
        zero = np.zeros(self.dof)
        far = [np.abs(self.amplitude) * self.rate**order for order in range(4)]
        middle = [self.centre, zero, zero, zero]
        return Extremes(*(Range(c - a, c + a, zero, zero) for c, a in zip(middle, far, strict=True)))


def sine_motion(robot, seed, seconds=10.0):
    """A random one, of up to about 4 rad/s."""
    random, n = np.random.default_rng(seed), robot.dof
    rate = 2 * np.pi * random.integers(1, 6, n) / 10.0
    centre, amplitude = random.uniform(-2, 2, n), random.uniform(0.2, 1.2, n)
    return SineMotion(centre, amplitude, rate, random.uniform(0, 6, n), seconds)
