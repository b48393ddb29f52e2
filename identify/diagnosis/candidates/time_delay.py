"""Time delay: currents of all drives or of one are recorded later or earlier than positions.

One controller reads all drives, so they share one delay, from which each may deviate by a telegram. A delay
of a single joint is tested only if there is no common delay, because two delays do not shift the recording.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from ...effects import Shape
from ...errors import NotRecorded
from ...measurements import TimeDelay
from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Hypothesis
from ..findings.kind import Kind
from ..findings.size import sign_known
from ..questions.candidate import UNNAMED, Candidate
from ..runs.driven import Driven, cached
from ..runs.rows import torque_rate
from .parts import RARE

APART = 1.5
"""Ratio between successive delays [-]."""
DELAYS = tuple(sign * 4e-3 * APART**step for sign in (-1.0, 1.0) for step in range(-3, 6))
"""Delays that are tried [s], from 1.2 to 30 ms; shorter ones are within the clock errors of any recording."""
DEVIATION = "deviation"
"""Name of the difference between one drive's delay and the common delay; the joint number follows."""
WHOLE = 1e-6
"""Standard deviation of the coefficient from 1 [-]: a delayed torque is there in full."""
TELEGRAM = 5e-3
"""Standard deviation of one drive's delay from the common delay [s]: one telegram."""


def delays(model: Model) -> Iterator[Candidate]:
    """Delays of all drives together, and of each drive, which rarely has its own bus."""
    robot, between = model.robot, cached(_between, loaded=False)
    drives = [joint for joint, name in enumerate(robot.joints) if name not in robot.passive]
    if len(drives) < 2:  # the common delay of a single drive is that of its joint
        yield from (_of(tuple(drives) if robot.dof > 1 else (), delay, 1.0, between) for delay in DELAYS)
        return
    yield from (_common(drives, delay, between) for delay in DELAYS)
    for joint in drives:
        yield from (_of((joint,), delay, RARE, between) for delay in DELAYS)


def _of(joints: tuple[int, ...], delay: float, prior: float, between: Callable[[Driven], PPoly]) -> Candidate:
    """A delay: the recorded torque of some drives minus the torque recorded later by the delay.

    With a coefficient of 1, this shifts the recording including its noise; a smaller one would average noise.
    """

    def columns(run: Driven) -> np.ndarray:
        if run.prepared.computed:
            raise NotRecorded("the torque is computed from the positions, whose clock it shares")
        time, recorded = run.motion.time, run.prepared.gain * run.prepared.current
        drives, change = list(joints) or slice(None), np.zeros_like(recorded)
        spline = between(run)
        later = PPoly(spline.c[:, :, drives], spline.x)(np.clip(time + delay, time[0], time[-1]))
        change[:, drives] = recorded[:, drives] - later
        return change[:, :, None]

    bounds = {"delay": Shape("s", *sorted((delay / APART, delay * APART)))}
    return Candidate(
        "time_delay", joints, columns, (UNNAMED,), ("1",), (0.0,), {"delay": delay}, bounds,
        lambda shape: _of(joints, shape["delay"], prior, between), expected=((1.0, WHOLE),),
        everywhere=not joints, rows=joints or None, reloads=True, prior=prior,
    )  # fmt: skip


def _common(drives: Sequence[int], delay: float, between: Callable[[Driven], PPoly]) -> Candidate:
    """A common delay of all drives, and the deviation of each drive from it."""
    common = _of((), delay, 1.0, between)

    def columns(run: Driven) -> np.ndarray:
        deviations = (-torque_rate(run)[:, :, None] * np.eye(run.torque.shape[1]))[:, :, drives]
        # Deviations are relative to their mean, since what they share is the common delay.
        return np.concatenate(
            [common.columns(run), deviations - deviations.mean(axis=2, keepdims=True)], axis=2
        )

    def from_mean(values: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.append(values[:1], values[1:] - values[1:].mean()), std

    count = len(drives)
    return replace(
        common, columns=columns, names=(UNNAMED, *(f"{DEVIATION}{joint + 1}" for joint in drives)),
        loaded=True, units=("1", *("s",) * count), lower=(0.0, *(-np.inf,) * count),
        expected=((1.0, WHOLE), *((0.0, TELEGRAM),) * count), covers=True, reported_as=from_mean,
        reshape=lambda shape: _common(drives, shape["delay"], between),
    )  # fmt: skip


def _between(run: Driven) -> PPoly:
    """Spline through the recorded torque of all drives in a run [N m].

    Linear interpolation would reduce noise between samples, which favors delays of a fraction of a sample.
    """
    return CubicSpline(run.motion.time, run.prepared.gain * run.prepared.current)


def _held(arm: Arm, finding: Hypothesis) -> Arm:
    """The arm with delayed efforts of some or all drives, and the deviation of drives where it is certain."""
    names, parameters = arm.model.robot.joints, finding.parameters
    joints = tuple(names[joint] for joint in finding.joints) or None
    arm = arm.with_measurement(TimeDelay(parameters["delay"].value, joints))
    for joint, name in enumerate(names):
        deviation = parameters.get(f"{DEVIATION}{joint + 1}")
        if deviation is not None and sign_known(deviation.value, deviation.std):
            arm = arm.with_measurement(TimeDelay(deviation.value, (name,)))
    return arm


KINDS = {
    "time_delay": Kind(
        family="delay",
        sentence="{late} {delay:size ms} {delay:later|earlier} than the positions recorded with it",
        drawn_against=("acceleration", "velocity"),
        ask=delays,
        sensor=True,
        held=_held,
        settled_by="a swept sine (exidyn excite --kind chirp)",
    )
}
