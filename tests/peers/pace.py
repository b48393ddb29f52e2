"""Pace: a simulated arm lives in the time of its messages, and not in the number of them.

A host that is late asks about an arm that has moved on meanwhile, as a real one would.
"""

import numpy as np

STEP = 1e-4
"""Of the arm's time [s]: a plant prepares each length of step once."""
LOST = 0.05
"""Distance of the two times from which on they begin anew [s]: there was no question for that long."""


class Pace:
    """The arm's time beside that of its messages.

    In lockstep, one cycle passes with each message whatever the clock shows, as for a host that does so too.
    """

    def __init__(self, plant):
        self.plant, self.lockstep, self.at = plant, False, 0.0
        self.velocity = np.zeros(len(plant.measure().position))

    def behind(self, now):
        """By how much the arm has not been moved yet [s], at the time of a message."""
        if self.lockstep or abs(now - self.at) > LOST:
            self.at = now
        return now - self.at

    def position(self, now):
        """Where it is at the time of a message, shape (n,) [rad]."""
        return self.plant.measure().position + self.velocity * self.behind(now)

    def length(self, period, now):
        """How long it is to be moved so that its time is that of the next message [s]."""
        return max(round((period + self.behind(now)) / STEP), 1) * STEP

    def step(self, position, velocity, seconds):
        """Move it on."""
        before = self.plant.measure().position
        self.plant.step(position, velocity, seconds)
        self.velocity = (self.plant.measure().position - before) / seconds
        self.at += seconds
