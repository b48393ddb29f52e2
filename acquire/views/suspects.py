"""Suspects: findings and unexplained residuals of a diagnosis, and their torques in a run."""

from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Robot
from exidyn.identification.diagnosis.findings.evidence import Trace
from exidyn.identification.diagnosis.findings.quantities import SLIDING, TURNING
from exidyn.identification.diagnosis.words.importance import clearest_joint
from exidyn.identification.diagnosis.words.naming import effect_words, joint_words, lower
from exidyn.identification.pages.shown import Shown
from exidyn.identification.text_table import digits

from ..files.given_runs import distinct_names
from .parts import COLORS

SUSPECTS = (COLORS[4], COLORS[2], COLORS[1])
"""Colors of suspects, readable on any background and different from those of residuals."""
WINDOW = 0.5
"""Averaging window of a torque's power [s]: about the time resolution of an eye that watches an arm."""
LEVEL = 0.5
"""Minimum power of a torque in its moments, over the power-weighted mean power: half of the power at which
most of the torque is spent, so that neither spikes nor long rests count much."""
MAX_MOMENTS = 12
"""Maximum number of moments per run."""


class Moment(NamedTuple):
    """A time span in which a torque stands out."""

    begin: float  # start time [s]
    end: float  # end time [s]
    over_noise: float  # RMS torque over the noise floor [-]


class Suspect(NamedTuple):
    """A finding, or an unexplained residual of a joint."""

    name: str  # name with effect and joints
    short: str  # name of the effect alone
    joint: int  # index of the joint on which it is clearest, from 0
    place: int | None  # index of the finding in the traces; None for an unexplained residual
    color: tuple[int, int, int]  # color of its torque and its moments

    def torque(self, trace: Trace) -> np.ndarray:
        """Torque of the suspect on its joint, zero where the joint sticks, shape (r,) [N m]."""
        torque = trace.after if self.place is None else trace.explained[self.place]
        return torque[:, self.joint] * trace.weight[:, self.joint]

    def before(self, trace: Trace) -> np.ndarray:
        """Residual of its joint without this finding but with all others, shape (r,) [N m]."""
        if self.place is None:
            return trace.before[:, self.joint]
        return trace.after[:, self.joint] + trace.explained[self.place][:, self.joint]

    def moments(self, trace: Trace, noise: np.ndarray) -> list[Moment]:
        """The strongest moments of the suspect in a run."""
        return moments(trace.time, self.torque(trace) / noise[self.joint])

    def sentence(self, moment: Moment, trace: Trace, robot: Robot, noise: float = 0.0) -> str:
        """A moment in words: its torque, and the joint's mean position and speed.

        If `noise` [N m], the scale of `over_noise`, is not zero, the torque is stated in its own unit.
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


def suspects(shown: Shown) -> list[Suspect]:
    """Findings of a diagnosis, followed by unexplained residuals."""
    diagnosis = shown.diagnosis
    findings = zip(shown.finding_names, diagnosis.all_findings, strict=True)
    entries: list[tuple[str, str, int, int | None]] = [
        (name, effect_words(finding.effect), clearest_joint(diagnosis, finding), place)
        for place, (name, finding) in enumerate(findings)
    ]
    for remainder in diagnosis.remainders:
        where = lower(joint_words(remainder.joint, diagnosis.joints))
        entries.append((f"Unexplained torque of {where}", "unexplained", remainder.joint, None))
    names = distinct_names([name for name, *_ in entries])
    return [
        Suspect(name, short, joint, place, SUSPECTS[number % len(SUSPECTS)])
        for number, (name, (_, short, joint, place)) in enumerate(zip(names, entries, strict=True))
    ]


def windowed_rms(time: np.ndarray, over_noise: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """RMS of torques over the noise floor (r, n) in a window around each row; NaN without weight.

    The weight (r, n) is 0 where a joint sticks, else 1.
    """
    sums, counts = (_windowed_mean(time, values) for values in (weight * over_noise**2, weight))
    positive = counts > 1e-9  # above rounding errors
    return np.where(positive, np.sqrt(np.maximum(sums, 0.0) / np.where(positive, counts, 1.0)), np.nan)


def _windowed_mean(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Mean of each column in a window around each row, shape (r, n)."""
    width = max(round(WINDOW / float(np.median(np.diff(time)))), 1) if len(time) > 1 else 1
    window = np.ones(min(width, len(time))) / width
    return np.stack([np.convolve(column, window, mode="same") for column in values.T], axis=1)


def moments(time: np.ndarray, over_noise: np.ndarray) -> list[Moment]:
    """The strongest moments of a torque over noise (r,), 0 where it does not count, in order of time."""
    power = over_noise**2
    if len(time) < 2 or not np.any(power > 0.0):
        return []
    smoothed = _windowed_mean(time, power[:, None])[:, 0]
    level = LEVEL * float(np.sum(smoothed**2) / np.sum(smoothed))
    spans = [
        Moment(float(time[a]), float(time[b]), float(np.sqrt(np.mean(power[a : b + 1]))))
        for a, b in _spans(time, smoothed >= level)
    ]
    energy = sorted(spans, key=lambda span: -((span.end - span.begin + WINDOW) * span.over_noise**2))
    return sorted(energy[:MAX_MOMENTS])


def _spans(time: np.ndarray, chosen: np.ndarray) -> list[tuple[int, int]]:
    """First and last row of each span of chosen rows; gaps shorter than a window are bridged."""
    rows = np.flatnonzero(chosen)
    breaks = np.flatnonzero(np.diff(time[rows]) > WINDOW)
    firsts, lasts = np.concatenate([[0], breaks + 1]), np.concatenate([breaks, [len(rows) - 1]])
    return [(int(rows[first]), int(rows[last])) for first, last in zip(firsts, lasts, strict=True)]
