"""Suspects: what a diagnosis found or could not name, and the torque by which it shows in a run."""

from typing import Any, NamedTuple

import numpy as np

from exidyn.identify.arm.robot import Robot
from exidyn.identify.diagnosis.findings.quantities import SLIDING, TURNING
from exidyn.identify.diagnosis.findings.trace import Trace
from exidyn.identify.diagnosis.words.naming import effect_words, joint_words, lower
from exidyn.identify.pages.views.view_parts import JOINTS

from ..files.names import distinct_names
from ..files.traces_file import Traces
from .diagnosis_words import finding_name
from .moments import Moment, moments

COLOURS = (JOINTS[4], JOINTS[2], JOINTS[1])
"""Of suspects, to be read on dark ground and on light; none is that of before or of after."""


class Suspect(NamedTuple):
    """A finding, or what is left on a joint without a name.

    Attributes:
        name: In words.
        short: The effect alone.
        joint: On which it shows most, from 0.
        place: Of the finding in the traces; None for what has no name.
        colour: Of its torque and its moments.
    """

    name: str
    short: str
    joint: int
    place: int | None
    colour: tuple[int, int, int]

    def torque(self, trace: Trace) -> np.ndarray:
        """Its torque on that joint, zero where the joint sticks, shape (r,) [N m]."""
        torque = trace.after if self.place is None else trace.explained[self.place]
        return torque[:, self.joint] * trace.weight[:, self.joint]

    def before(self, trace: Trace) -> np.ndarray:
        """What is left of that joint's torque without it, all else as fitted, shape (r,) [N m]."""
        if self.place is None:
            return trace.before[:, self.joint]
        return trace.after[:, self.joint] + trace.explained[self.place][:, self.joint]

    def moments(self, trace: Trace, noise: np.ndarray) -> list[Moment]:
        """When it shows most."""
        return moments(trace.time, self.torque(trace) / noise[self.joint])

    def sentence(self, moment: Moment, trace: Trace, robot: Robot, noise: float = 0.0) -> str:
        """A moment in words: how much, and where the joint was on the average and how fast.

        Args:
            moment: When.
            trace: Of the run.
            robot: Whose joint it is.
            noise: Its scale, where that was not measured and the torque itself is given [N m]; else zero.
        """
        within = (trace.time >= moment.begin) & (trace.time <= moment.end)
        position = float(np.mean(trace.position[within, self.joint]))
        speed = float(np.mean(np.abs(trace.velocity[within, self.joint])))
        unit = "rad" if robot.revolute[self.joint] else "m"
        when = f"{moment.begin:.1f} to {moment.end:.1f} s"
        where = f"{position:.2f} {unit}, {speed:.2f} {unit}/s"
        size = f"{moment.over_noise:.2g} x noise"
        if noise:
            measure = TURNING if robot.revolute[self.joint] else SLIDING
            size = f"{moment.over_noise * noise:.2g} {measure}"
        return f"{when}  {self.short}: {size} at {where}"


def suspects(table: dict[str, Any], traces: Traces) -> list[Suspect]:
    """Those of a diagnosis, the tables of whose file are given: findings first."""
    found = [
        (finding_name(table, one), effect_words(one["effect"]), _clearest(traces, place), place)
        for place, one in enumerate([*table["findings"], *table.get("undecided", ())])
    ]
    left = [
        (f"Left on {lower(joint_words(one['joint'] - 1, table['joints']))}", "left", one["joint"] - 1, None)
        for one in table["remainders"]
    ]
    every = [*found, *left]
    names = distinct_names([name for name, *_ in every])
    return [
        Suspect(name, short, joint, place, COLOURS[number % len(COLOURS)])
        for number, (name, (_, short, joint, place)) in enumerate(zip(names, every, strict=True))
    ]


def _clearest(traces: Traces, place: int) -> int:
    """The joint on which a finding's torque stands highest above the noise."""
    squares = sum(np.sum((trace.explained[place] * trace.weight) ** 2, axis=0) for trace in traces.traces)
    return int(np.argmax(squares / traces.noise**2))
