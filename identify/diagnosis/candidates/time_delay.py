"""Time delay: currents that are recorded later than positions, or earlier, of all drives or of one.

One controller reads all drives. So they share one delay, from which each may deviate by a telegram; a delay
of a single joint is asked for only beside no common one, and of two delays one is no shift of the recording.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from ...effects import Shape
from ...measurements import TimeDelay
from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Hypothesis
from ..findings.kind import Kind
from ..findings.size import sign_known
from ..questions.candidate import UNNAMED, Candidate
from ..runs.driven import Driven
from ..runs.kept import at_any_load, kept
from ..runs.rows import torque_rate
from .parts import RARE

APART = 1.5
"""From one delay that is tried to the next [-]."""
DELAYS = tuple(sign * 4e-3 * APART**step for sign in (-1.0, 1.0) for step in range(6))
"""Delays of cycles of a fieldbus [s], up to 30 ms; what is shorter is in proportion to the torque's rate."""
DEVIATION = "deviation"
"""How the difference between one drive's delay and that of all is called; the joint's number is behind."""
LINEAR = 4e-3
"""Delay up to which a torque changes in proportion to its rate [s]: the least that is tried whole."""
WHOLE = 1e-6
"""By how much a torque that comes later may be more or less than all of it [-]: not at all."""
OWN_CLOCK = ((0.0, 5e-3),)
"""By how much a clock may be wrong otherwise [s]: a telegram or two of the slowest fieldbus."""


TELEGRAM = 5e-3
"""By how much one drive's delay may differ from that of all [s]: that telegram."""


def delays(model: Model) -> Iterator[Candidate]:
    """Delays of all drives, which one controller reads, and of each, which seldom has a bus of its own."""
    robot, between = model.robot, kept(_between, at_any_load)
    drives = [joint for joint, name in enumerate(robot.joints) if name not in robot.passive]
    if len(drives) < 2:  # what a single motor has is no more than that of its joint
        yield from _of(tuple(drives) if robot.dof > 1 else (), 1.0, between)
        return
    yield _little((), 1.0)
    yield from (_common(drives, delay, between) for delay in DELAYS)
    for joint in drives:
        yield from _of((joint,), RARE, between)


def _of(joints: tuple[int, ...], prior: float, between: Callable[[Driven], PPoly]) -> Iterator[Candidate]:
    """A delay of some drives together, short or long."""
    yield _little(joints, prior)
    yield from (_whole(joints, delay, prior, between) for delay in DELAYS)


def _little(joints: tuple[int, ...], prior: float) -> Candidate:
    """A delay that is in proportion to how fast torque changes; more is another torque."""

    def columns(run: Driven) -> np.ndarray:
        return _of_drives(joints, -torque_rate(run))

    return Candidate(
        "time_delay", joints, columns, ("delay",), ("s",), (-np.inf,), expected=OWN_CLOCK, most=LINEAR,
        everywhere=not joints, rows=joints or None, loaded=True, reloads=True, prior=prior,
    )  # fmt: skip


def _whole(
    joints: tuple[int, ...], delay: float, prior: float, between: Callable[[Driven], PPoly]
) -> Candidate:
    """Torque of some drives as it was recorded, less what is recorded later by the delay, there whole.

    That moves the recording to where it belongs, its noise with it; a part of it would take noise away.
    """

    def columns(run: Driven) -> np.ndarray:
        time, recorded = run.motion.time, run.prepared.gain * run.prepared.current
        drives, change = list(joints) or slice(None), np.zeros_like(recorded)
        spline = between(run)
        later = PPoly(spline.c[:, :, drives], spline.x)(np.clip(time + delay, time[0], time[-1]))
        change[:, drives] = recorded[:, drives] - later
        return change[:, :, None]

    bounds = {"delay": Shape("s", *sorted((delay / APART, delay * APART)))}
    return Candidate(
        "time_delay", joints, columns, (UNNAMED,), ("1",), (0.0,), {"delay": delay}, bounds,
        lambda shape: _whole(joints, shape["delay"], prior, between), expected=((1.0, WHOLE),),
        everywhere=not joints, rows=joints or None, loaded=True, reloads=True, prior=prior,
    )  # fmt: skip


def _common(drives: Sequence[int], delay: float, between: Callable[[Driven], PPoly]) -> Candidate:
    """The delay of all drives, and by how much later than the others each one comes."""
    whole = _whole((), delay, 1.0, between)

    def columns(run: Driven) -> np.ndarray:
        deviations = np.concatenate([_of_drives((joint,), -torque_rate(run)) for joint in drives], axis=2)
        # From their mean: what they have in common is the delay.
        return np.concatenate(
            [whole.columns(run), deviations - deviations.mean(axis=2, keepdims=True)], axis=2
        )

    def from_mean(values: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.append(values[:1], values[1:] - values[1:].mean()), std

    count = len(drives)
    return replace(
        whole, columns=columns, names=(UNNAMED, *(f"{DEVIATION}{joint + 1}" for joint in drives)),
        units=("1", *("s",) * count), lower=(0.0, *(-np.inf,) * count),
        expected=((1.0, WHOLE), *((0.0, TELEGRAM),) * count), covers=True, reported_as=from_mean,
        reshape=lambda shape: _common(drives, shape["delay"], between),
    )  # fmt: skip


def _between(run: Driven) -> PPoly:
    """Recorded torque of all drives between the samples of a run [N m].

    A straight line would take noise away there, which favours any delay but whole samples.
    """
    return CubicSpline(run.motion.time, run.prepared.gain * run.prepared.current)


def _of_drives(joints: tuple[int, ...], torque: np.ndarray) -> np.ndarray:
    """A column (t, n, 1) of the torque (t, n) [N m] of some drives; of all where none is given."""
    own = np.isin(np.arange(torque.shape[1]), joints) if joints else True
    return np.where(own, torque, 0.0)[:, :, None]


def _held(arm: Arm, finding: Hypothesis) -> Arm:
    """Efforts of some drives, or of all, that are recorded late; of a drive that surely deviates, its own."""
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
        mistaken_for=("joint_elasticity", "viscous_friction"),
        settled_by="a swept sine (exidyn excite --kind chirp)",
    )
}
