"""What tests of the loop need: the cobot, a motion, and a controller whose arm follows at once."""

import numpy as np

from exidyn.acquire.run.frames import EVENT, SAMPLE, Unframed, read_cycle
from exidyn.acquire.run.perform import Job
from exidyn.acquire.run.stopping.watch import WatchLimits
from exidyn.drivers import Driver, Info, Sample
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.limits.moves import move
from exidyn.trajectories.limits.usable_limits import Margins, usable
from exidyn.trajectories.trajectory import State

CYCLE = 0.002
MODEL = read_model("cobot")
ROBOT = MODEL.robot
LIMITS = usable(ROBOT, Margins(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)).limits
PATIENT = WatchLimits(missed=1.0, stall=10.0, silence=5.0, stale=1.0)
"""Watches nothing that a loaded machine spoils."""
START = 0.5 * (LIMITS.position_lower + LIMITS.position_upper)


def motion(distance=0.5):
    """From rest at `START` to rest some way on."""
    return move(State.at_rest(START), State.at_rest(START + distance), LIMITS, CYCLE)


def job(**other):
    return Job(ROBOT, motion(), LIMITS, **other)


class Following(Driver):
    """An arm that is where it was commanded one cycle before; `change` may spoil its answer.

    `change` takes the number of commands so far and the fields of the sample.
    """

    simulated = True

    def __init__(self, start=START, change=lambda number, fields: None, **info):
        self.position, self._change, self._info = np.array(start, float), change, info
        self.commands, self.stops, self.closed, self.number = [], [], 0, 0
        self.holds = None

    def open(self):
        return Info(**({"cycle": CYCLE, "clock": "host", "signals": ("position", "current")} | self._info))

    def held(self):
        return self.holds

    def exchange(self, command):
        self.number += 1
        time, n = self.number * 2_000_000, len(self.position)
        silent = np.full(n, np.nan)
        fields = {
            "host_time": 10**18 + time,
            "controller_time": time,
            "position": self.position.copy(),
            "velocity": silent,
            "current": np.zeros(n),
            "torque": silent,
            "temperature": silent,
            "stale": np.zeros(n, bool),
        }
        self._change(len(self.commands), fields)
        if command is not None:
            self.position = command.position.copy()
            self.commands.append(command.position.copy())
        return Sample(**fields)

    def stop(self, level):
        self.stops.append(level)

    def close(self):
        self.closed += 1


class Listening:
    """A sink that keeps what it is handed."""

    failure = ""

    def __init__(self):
        self.frames, self._unframed = [], Unframed()

    def put(self, frame):
        self.frames += self._unframed.add(frame)

    def close(self):
        pass

    def cycles(self):
        return [read_cycle(body) for kind, body in self.frames if kind == SAMPLE]

    def events(self):
        return [body.decode() for kind, body in self.frames if kind == EVENT]
