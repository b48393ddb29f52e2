"""Suspects: what a diagnosis found or could not name, and the torque by which it shows in a run."""

from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Robot
from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.findings.evidence import Trace
from exidyn.identification.diagnosis.findings.quantities import SLIDING, TURNING
from exidyn.identification.diagnosis.words.naming import effect_words, finding_names, joint_words, lower
from exidyn.identification.text_table import digits

from ..files.diagnosis_files import Traces
from ..files.given_runs import distinct_names
from .parts import COLOURS

SUSPECTS = (COLOURS[4], COLOURS[2], COLOURS[1])
"""Colours of suspects, to be read on dark ground and on light; none is that of before or of after."""
WINDOW = 0.5
"""Time over which a torque is taken together [s]: about what an eye takes in of a moving arm."""
LEVEL = 0.5
"""Square of a torque in its moments, at least, over the mean square weighted by itself: half of that at which
most of the torque is spent, so that neither a spike nor a long quiet rest counts much."""
MOST = 12
"""Moments of a run; who looks at more sees the run."""


class Moment(NamedTuple):
    """A span of time.

    Attributes:
        begin: [s].
        end: [s].
        over_noise: Root mean square of the torque within, over the noise floor [-].
    """

    begin: float
    end: float
    over_noise: float


class Suspect(NamedTuple):
    """A finding, or what is left on a joint without a name.

    Attributes:
        name: In words.
        short: The effect alone.
        joint: On which it shows most, from 0.
        place: Index of the finding in the traces; None for what has no name.
        colour: Colour of its torque and its moments.
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

        A noise scale [N m] is given where none was measured, so that the torque itself is stated; else zero.
        """
        within = (trace.time >= moment.begin) & (trace.time <= moment.end)
        position = float(np.mean(trace.position[within, self.joint]))
        speed = float(np.mean(np.abs(trace.velocity[within, self.joint])))
        unit = "rad" if robot.revolute[self.joint] else "m"
        when = f"{moment.begin:.1f} to {moment.end:.1f} s"
        where = f"{position:.2f} {unit}, {speed:.2f} {unit}/s"
        size = f"{digits(moment.over_noise, 2)} x noise"
        if noise:
            measure = TURNING if robot.revolute[self.joint] else SLIDING
            size = f"{digits(moment.over_noise * noise, 2)} {measure}"
        return f"{when}  {self.short}: {size} at {where}"


def suspects(diagnosis: Diagnosis, traces: Traces) -> list[Suspect]:
    """Those of a diagnosis: findings first."""
    findings = zip(finding_names(diagnosis), diagnosis.all_findings, strict=True)
    every: list[tuple[str, str, int, int | None]] = [
        (name, effect_words(finding.effect), _clearest(traces, place), place)
        for place, (name, finding) in enumerate(findings)
    ]
    for remainder in diagnosis.remainders:
        where = lower(joint_words(remainder.joint, diagnosis.joints))
        every.append((f"Left on {where}", "left", remainder.joint, None))
    names = distinct_names([name for name, *_ in every])
    return [
        Suspect(name, short, joint, place, SUSPECTS[number % len(SUSPECTS)])
        for number, (name, (_, short, joint, place)) in enumerate(zip(names, every, strict=True))
    ]


def _clearest(traces: Traces, place: int) -> int:
    """The joint on which a finding's torque stands highest above the noise."""
    squares = sum(np.sum((trace.explained[place] * trace.weight) ** 2, axis=0) for trace in traces.traces)
    return int(np.argmax(squares / traces.noise**2))


def lasting(time: np.ndarray, over_noise: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Root mean square within a window around each row, shape (r, n); NaN where nothing counts.

    Of torque over its noise floor (r, n) [-] at times (r,) [s]; weight is 0 where a joint sticks, else 1.
    """
    sums, counts = (_near(time, values) for values in (weight * over_noise**2, weight))
    some = counts > 1e-9  # of what rounding leaves of nothing
    return np.where(some, np.sqrt(np.maximum(sums, 0.0) / np.where(some, counts, 1.0)), np.nan)


def _near(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Mean of each column within a window around each row, shape (r, n)."""
    width = max(round(WINDOW / float(np.median(np.diff(time)))), 1) if len(time) > 1 else 1
    window = np.ones(min(width, len(time))) / width
    return np.stack([np.convolve(column, window, mode="same") for column in values.T], axis=1)


def moments(time: np.ndarray, over_noise: np.ndarray) -> list[Moment]:
    """The strongest moments, in order of time [s].

    Of torque over its noise floor, zero where it does not count, shape (r,) [-], at times (r,) [s].
    """
    power = over_noise**2
    if len(time) < 2 or not np.any(power > 0.0):
        return []
    near = _near(time, power[:, None])[:, 0]
    level = LEVEL * float(np.sum(near**2) / np.sum(near))
    spans = [
        Moment(float(time[a]), float(time[b]), float(np.sqrt(np.mean(power[a : b + 1]))))
        for a, b in _spans(time, near >= level)
    ]
    energetic = sorted(spans, key=lambda one: -((one.end - one.begin + WINDOW) * one.over_noise**2))
    return sorted(energetic[:MOST])


def _spans(time: np.ndarray, chosen: np.ndarray) -> list[tuple[int, int]]:
    """First and last row of every stretch; those that a window bridges are one."""
    rows = np.flatnonzero(chosen)
    breaks = np.flatnonzero(np.diff(time[rows]) > WINDOW)
    firsts, lasts = np.concatenate([[0], breaks + 1]), np.concatenate([breaks, [len(rows) - 1]])
    return [(int(rows[first]), int(rows[last])) for first, last in zip(firsts, lasts, strict=True)]
