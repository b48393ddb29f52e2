"""Candidates that are faults of the measurement: gains, saturation, clipping, clocks, encoder zeros."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from ...effects import JointSpring, Shape, SpringBalancer
from ...errors import NotRecorded
from ...model import Model
from ..candidate import UNNAMED, Candidate
from ..driven import Driven
from ..nuisances import torque_rate

KNEES = (0.3, 0.5, 0.7)
"""Torque over the largest of all runs from which on a motor gives less per ampere [-]."""
CLIPS = (0.6, 0.8, 0.9, 0.97)
"""Torque over the largest of all runs at which a current ends [-]."""
ENDS = 0.15
"""By how much that which lies beyond may be more or less than all that is missing [-]: the torque is known so
well."""
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
SPRINGS = (SpringBalancer, JointSpring)
"""Effects besides bodies whose torque goes with position."""
MISSET = 0.03
"""How far a joint may stand from where its encoder says [rad]: a tooth of a belt, a mark set by eye."""
ZERO_STEP = 1e-4
"""Of the difference by an encoder's zero [rad]."""


def gains(model: Model) -> Iterator[Candidate]:
    """A drive whose torque per ampere is another than its tolerance allows."""
    for joint in range(model.robot.dof):

        def columns(run: Driven, joint: int = joint) -> np.ndarray:
            _require_current(run)
            return on_joint(run, joint, -run.torque[:, joint])

        yield Candidate(
            "drive_gain", (joint,), columns, ("share",), ("1",), (-np.inf,), rows=(joint,), told_as=_of_gain
        )


def _require_current(run: Driven) -> None:
    """Raise where torque was recorded, which has no gain.

    Raises:
        NotRecorded: It was.
    """
    if run.prepared.measures != "current":
        raise NotRecorded("current was not recorded")


def _of_gain(lacking: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By what share a gain is greater, where a share of the torque is lacking."""
    return lacking / (1.0 - lacking), std / (1.0 - lacking) ** 2


def saturations(model: Model) -> Iterator[Candidate]:
    """A motor that takes more and more current for its torque, from a knee on."""
    for joint in range(model.robot.dof):
        for knee in KNEES:
            yield _saturation(joint, knee)


def _saturation(joint: int, knee: float) -> Candidate:
    def columns(run: Driven) -> np.ndarray:
        _require_current(run)
        torque = run.torque[:, joint]
        most = run.most[joint]
        beyond = np.maximum(np.abs(torque) - knee * most, 0.0)
        return on_joint(run, joint, np.sign(torque) * beyond**2 / max(most, 1e-12))

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return _saturation(joint, given["knee"])

    bounds = {"knee": Shape("1", 0.05, 0.9)}
    return Candidate(
        "drive_gain_saturation", (joint,), columns, ("curvature",), ("1",), (0.0,), {"knee": knee}, bounds,
        reshaped, rows=(joint,),
    )  # fmt: skip


def clips(model: Model) -> Iterator[Candidate]:
    """A current that ends while the torque goes on."""
    for joint in range(model.robot.dof):
        for level in CLIPS:
            yield _clip(joint, level)


def _clip(joint: int, level: float) -> Candidate:
    def columns(run: Driven) -> np.ndarray:
        torque = run.torque[:, joint]
        beyond = np.maximum(np.abs(torque) - level * run.most[joint], 0.0)
        return on_joint(run, joint, -np.sign(torque) * beyond)

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return _clip(joint, given["level"])

    bounds = {"level": Shape("1", 0.3, 0.999)}
    return Candidate(
        "current_clipping", (joint,), columns, ("slope",), ("1",), (0.0,), {"level": level}, bounds, reshaped,
        rows=(joint,), expected=((1.0, ENDS),),
    )  # fmt: skip


def delays(model: Model) -> Iterator[Candidate]:
    """Currents that are recorded later than positions, or earlier, of all drives.

    Little is in proportion to how fast torque changes; much is another torque. One controller reads all
    drives, so that a delay of one alone is no delay; by how much their clocks differ is a nuisance.
    """

    def all_drives(run: Driven) -> np.ndarray:
        return -torque_rate(run)[:, :, None]

    yield Candidate(
        "time_delay", (), all_drives, ("delay",), ("s",), (-np.inf,), expected=OWN_CLOCK, everywhere=True,
        most=LINEAR,
    )  # fmt: skip
    for delay in DELAYS:
        yield _delay(delay)


def _delay(delay: float) -> Candidate:
    """All drives' torque as it was recorded, less what is recorded later by the delay.

    To take that away moves the recording to where it belongs, its noise with it. Nothing but the whole of it
    does so: of a part of it, the part would count that takes away noise.
    """

    def columns(run: Driven) -> np.ndarray:
        time, recorded = run.motion.time, run.prepared.gain * run.prepared.current
        # Between samples a straight line would take noise away, which speaks for any delay but whole samples.
        later = CubicSpline(time, recorded)(np.clip(time + delay, time[0], time[-1]))
        return (recorded - later)[:, :, None]

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return _delay(given["delay"])

    nearer, farther = sorted((delay / APART, delay * APART))
    return Candidate(
        "time_delay", (), columns, (UNNAMED,), ("1",), (0.0,), {"delay": delay},
        {"delay": Shape("s", nearer, farther)}, reshaped, expected=((1.0, WHOLE),),
        everywhere=True,
    )  # fmt: skip


def encoder_zeros(model: Model) -> Iterator[Candidate]:
    """A joint that is elsewhere than its encoder says, by a constant angle."""
    springs = replace(model, effects=tuple(e for e in model.effects if isinstance(e, SPRINGS)))
    for joint in range(model.robot.dof):

        def columns(run: Driven, joint: int = joint) -> np.ndarray:
            bodies = run.tangent.position[joint] @ model.robot.to_motors.T
            return (bodies + _by_position(springs, model, run, joint))[:, :, None]

        yield Candidate(
            "encoder_offset", (joint,), columns, ("zero",), ("rad",), (-np.inf,), expected=((0.0, MISSET),)
        )


def _by_position(springs: Model, model: Model, run: Driven, joint: int) -> np.ndarray:
    """Derivative of the springs' believed torque by a joint's position, shape (t, n) [N m/rad]."""
    known, shift = dict(zip(model.names, model.believed_values, strict=True)), np.zeros(model.robot.dof)
    values, shift[joint] = np.array([known[name] for name in springs.names]), ZERO_STEP
    if not springs.effects:
        return np.zeros_like(run.torque)
    sides = [
        springs.torque(replace(run.motion, position=run.motion.position + sign * shift), values)
        for sign in (1, -1)
    ]
    return (sides[0] - sides[1]) / (2 * ZERO_STEP) @ model.robot.to_motors.T


def on_joint(run: Driven, joint: int, torque: np.ndarray) -> np.ndarray:
    """Columns (t, n, p) that act on one joint, of its torque (t,) or (t, p) [N m]."""
    own = torque[:, None] if torque.ndim == 1 else torque
    columns = np.zeros((*run.torque.shape, own.shape[1]))
    columns[:, joint] = own
    return columns
