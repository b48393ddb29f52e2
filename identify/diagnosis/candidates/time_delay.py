"""Time delay: currents that are recorded later than positions, or earlier, of all drives or of one."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from ...effects import Shape
from ...model import Model
from ...recordings.recording import EFFORT, Recording, Signal
from ...recordings.servo_error import delayed_command
from ..findings.finding import Finding
from ..findings.kind import Kind, Undo
from ..questions.candidate import UNNAMED, Candidate
from ..runs.driven import Driven
from ..runs.kept import at_any_load, kept
from ..runs.rows import torque_rate
from .parts import RARE

APART = 1.5
"""From one delay that is tried to the next [-]."""
DELAYS = tuple(sign * 4e-3 * APART**step for sign in (-1.0, 1.0) for step in range(6))
"""Delays of cycles of a fieldbus [s], up to 30 ms; what is shorter is in proportion to the torque's rate."""
LINEAR = 4e-3
"""Delay up to which a torque changes in proportion to its rate [s]: the least that is tried whole."""
WHOLE = 1e-6
"""By how much a torque that comes later may be more or less than all of it [-]: not at all."""
OWN_CLOCK = ((0.0, 5e-3),)
"""By how much a clock may be wrong otherwise [s]: a telegram or two of the slowest fieldbus."""


def delays(model: Model) -> Iterator[Candidate]:
    """Delays of all drives, which one controller reads, and of each, which seldom has a bus of its own."""
    drives, between = range(model.robot.dof), kept(_between, at_any_load)
    for joints in [(), *((joint,) for joint in drives)] if len(drives) > 1 else [()]:
        yield _little(joints)
        for delay in DELAYS:
            yield _whole(joints, delay, between)


def _little(joints: tuple[int, ...]) -> Candidate:
    """A delay that is in proportion to how fast torque changes; more is another torque."""

    def columns(run: Driven) -> np.ndarray:
        return _of_drives(joints, -torque_rate(run))

    return Candidate(
        "time_delay", joints, columns, ("delay",), ("s",), (-np.inf,), expected=OWN_CLOCK, most=LINEAR,
        everywhere=not joints, rows=joints or None, loaded=True, reloads=True, prior=RARE if joints else 1.0,
    )  # fmt: skip


def _whole(joints: tuple[int, ...], delay: float, between: Callable[[Driven], PPoly]) -> Candidate:
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
        lambda given: _whole(joints, given["delay"], between), expected=((1.0, WHOLE),),
        everywhere=not joints, rows=joints or None, loaded=True, reloads=True, prior=RARE if joints else 1.0,
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


def earlier(recording: Recording, finding: Finding) -> Recording:
    """The recording with currents, or torques, moved to where they were earlier by the delay.

    Where the error of servos stands for the current, their commands are moved.
    """
    signals, seconds = dict(recording.signals), finding.parameters["delay"].value
    joints = finding.joints or range(recording.robot.dof)
    commanded = delayed_command(recording, -seconds, joints)
    if commanded is not None:
        return commanded
    for name in set(EFFORT) & set(signals):
        time, values = signals[name].time, np.array(signals[name].values)
        for joint in joints:
            values[:, joint] = np.interp(time + seconds, time, signals[name].values[:, joint])
        signals[name] = Signal(time, values)
    return replace(recording, signals=signals)


KINDS = {
    "time_delay": Kind(
        sentence="{late} {delay:size ms} {delay:later|earlier} than the positions recorded with it",
        drawn_against=("acceleration", "velocity"),
        ask=delays,
        sensor=True,
        undo=Undo(earlier, "currents were moved back by that before they were fitted"),
        mistaken_for=("joint_elasticity", "viscous_friction"),
        settled_by="a swept sine (exidyn excite --kind chirp)",
    )
}
