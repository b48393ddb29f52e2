"""Time delay: currents that are recorded later than positions, or earlier, of all drives or of one."""

from collections.abc import Iterator

import numpy as np
from scipy.interpolate import CubicSpline

from ...effects import Shape
from ...measurements import TimeDelay
from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..questions.candidate import UNNAMED, Candidate
from ..runs.driven import Driven
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
    drives = range(model.robot.dof)
    for joints in [(), *((joint,) for joint in drives)] if len(drives) > 1 else [()]:
        yield _little(joints)
        for delay in DELAYS:
            yield _whole(joints, delay)


def _little(joints: tuple[int, ...]) -> Candidate:
    """A delay that is in proportion to how fast torque changes; more is another torque."""

    def columns(run: Driven) -> np.ndarray:
        return _of_drives(joints, -torque_rate(run))

    return Candidate(
        "time_delay", joints, columns, ("delay",), ("s",), (-np.inf,), expected=OWN_CLOCK, most=LINEAR,
        everywhere=not joints, rows=joints or None, loaded=True, reloads=True, prior=RARE if joints else 1.0,
    )  # fmt: skip


def _whole(joints: tuple[int, ...], delay: float) -> Candidate:
    """Torque of some drives as it was recorded, less what is recorded later by the delay, there whole.

    That moves the recording to where it belongs, its noise with it; a part of it would take noise away.
    """

    def columns(run: Driven) -> np.ndarray:
        time, recorded = run.motion.time, run.prepared.gain * run.prepared.current
        # Between samples a straight line would take noise away, which favours any delay but whole samples.
        later = CubicSpline(time, recorded)(np.clip(time + delay, time[0], time[-1]))
        return _of_drives(joints, recorded - later)

    bounds = {"delay": Shape("s", *sorted((delay / APART, delay * APART)))}
    return Candidate(
        "time_delay", joints, columns, (UNNAMED,), ("1",), (0.0,), {"delay": delay}, bounds,
        lambda given: _whole(joints, given["delay"]), expected=((1.0, WHOLE),),
        everywhere=not joints, rows=joints or None, loaded=True, reloads=True, prior=RARE if joints else 1.0,
    )  # fmt: skip


def _of_drives(joints: tuple[int, ...], torque: np.ndarray) -> np.ndarray:
    """A column (t, n, 1) of the torque (t, n) [N m] of some drives; of all where none is given."""
    own = np.isin(np.arange(torque.shape[1]), joints) if joints else True
    return np.where(own, torque, 0.0)[:, :, None]


def _held(arm: Arm, finding: Finding) -> Arm:
    """Efforts of some drives, or of all, that are recorded late."""
    joints = tuple(arm.model.robot.joints[joint] for joint in finding.joints) or None
    return arm.with_measurement(TimeDelay(finding.parameters["delay"].value, joints))


KINDS = {
    "time_delay": Kind(
        sentence="{late} {delay:size ms} {delay:later|earlier} than the positions recorded with it",
        drawn_against=("acceleration", "velocity"),
        ask=delays,
        sensor=True,
        held=_held,
        mistaken_for=("joint_elasticity", "viscous_friction"),
        settled_by="a swept sine (exidyn excite --kind chirp)",
    )
}
