"""Alarms: when a score exceeded its threshold, and where."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from ..arm.robot import Robot
from .observer import Estimates
from .threshold import BLOCK, Threshold
from .wrench import flange_wrenches


@dataclass(frozen=True, eq=False)
class Alarm:
    """One contact: exceedances that are less than a block of the threshold apart."""

    start: float  # time of the first exceedance [s]
    end: float  # time of the last exceedance [s]
    joint: int  # index of the joint that exceeded its threshold the most, from 0
    torque: np.ndarray  # external torques at the highest score, shape (n,) [N m]
    position: np.ndarray  # joint positions there, shape (n,) [rad]
    scale: np.ndarray  # standard deviations of the torques without contact there, shape (n,) [N m]
    score: float  # highest score, over the level of the threshold [-]

    def wrench(self, robot: Robot) -> np.ndarray:
        """Force and moment on the flange at the highest score, in the axes of the base, (6,) [N, N m]."""
        return flange_wrenches(robot, self.position[None], self.torque[None], self.scale[None])[0]


@dataclass(eq=False)
class Alarms:
    """Collects alarms from estimates that come in pieces; a recording is one piece."""

    threshold: Threshold  # threshold
    ended: list[Alarm] = field(default_factory=list)  # alarms that have ended
    _open: Alarm | None = None

    @property
    def all(self) -> list[Alarm]:
        """All alarms, including the current one."""
        return [*self.ended, *([self._open] if self._open is not None else [])]

    def add(self, estimates: Estimates) -> None:
        """Take further estimates."""
        for alarm in self._exceedances(estimates):
            if self._open is not None and alarm.start - self._open.end < BLOCK:
                self._open = _joined(self._open, alarm)
            else:
                self._close()
                self._open = alarm
        if self._open is not None and len(estimates) and estimates.time[-1] - self._open.end >= BLOCK:
            self._close()

    def _close(self) -> None:
        if self._open is not None:
            self.ended.append(self._open)
        self._open = None

    def _exceedances(self, estimates: Estimates) -> Iterator[Alarm]:
        """Each sample above the threshold as an alarm of its own."""
        scale = self.threshold.scale(estimates)
        score = np.abs(estimates.torque) / scale
        with np.errstate(invalid="ignore"):
            rows = np.flatnonzero(score.max(axis=1) > self.threshold.level)
        for row in rows:
            time, joint = float(estimates.time[row]), int(np.argmax(score[row]))
            highest = float(score[row, joint]) / self.threshold.level
            parts = estimates.torque[row], estimates.position[row], scale[row]
            yield Alarm(time, time, joint, *parts, highest)


def _joined(first: Alarm, second: Alarm) -> Alarm:
    """One alarm for both, described by the higher of them."""
    top = first if first.score >= second.score else second
    return Alarm(first.start, second.end, top.joint, top.torque, top.position, top.scale, top.score)
