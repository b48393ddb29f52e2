"""Contact event: something pushes the arm for a while.

A force f on the flange, in the base's axes, asks -J'(q) f of the motors. It happens once, so that no other
block predicts it: a window of a run has a contact where a force explains far more of what is left than forces
at all other times do.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ...arm.motion import Motion
from ...model import Model
from ...positive_definite import ROUNDING
from ..blocks.prediction import Prediction
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven

DURATIONS = (0.3, 0.6, 1.0)
"""Durations of a contact [s]."""
PARTS = 4
"""Starts that are tried in a duration."""
TOGETHER = 1000
"""Windows that are solved side by side: some tens of megabytes."""
ENDS = 1.0
"""At the beginning and at the end of a run in which no contact is looked for [s]: where an arm starts and
stops, friction that is not quite as modelled looks like a push."""
FORCE = 0.1
"""How large a force is expected to be, share of the arm's weight [-]."""
USUAL = 90.0
"""Percentage of all windows that have no contact: what forces explain there is how wrong the model is."""
APART = 2.0
"""Time from a contact on which a window shows what is usual [s]: longer than any contact."""


class Contact(NamedTuple):
    """A window of a run, and the force that explains most of what is left in it."""

    run: int  # its number among the runs
    name: str  # of the run
    start: float  # of the window, by the run's time [s]
    duration: float  # [s]
    force: np.ndarray  # on the flange, in the base's axes, shape (3,) [N]
    gains: np.ndarray  # logarithm of how much more probable the force makes each joint's rows, shape (n,)
    among: int = 1  # number of windows

    @property
    def middle(self) -> float:
        """Middle of the window [s]."""
        return self.start + 0.5 * self.duration

    @property
    def gain(self) -> float:
        """Logarithm of the probability gained, less what choosing the window cost."""
        return float(self.gains.sum() - np.log(self.among))

    @property
    def without_one(self) -> float:
        """The same without the joint that gains most: what one joint alone feels is no contact."""
        return self.gain - float(self.gains.max())


def share(time: np.ndarray, start: float | np.ndarray, duration: float) -> np.ndarray:
    """Share of the largest force at times (t,) [s], which rises and falls fast."""
    since = np.clip((time - start) / duration, 0.0, 1.0)
    return np.sqrt(np.sin(np.pi * since))


class Reach(NamedTuple):
    """What a force on the flange asks of the motors of one run."""

    time: np.ndarray  # of its rows, shape (r,) [s]
    torque: np.ndarray  # shape (r, n, 3) [N m/N]

    @classmethod
    def of(cls, model: Model, run: Driven) -> "Reach":
        """What it asks at the rows of a run."""
        motion = run.motion[run.centres[0] : run.centres[-1] + 1 : run.prepared.decimation.stride]
        return cls(motion.time, -np.einsum("ij,tjk->tik", model.robot.to_motors, jacobian(model, motion)))


def contacts(
    model: Model, prediction: Prediction, runs: Sequence[Driven], reaches: Sequence[Reach]
) -> list[Contact]:
    """All windows of all runs, with how much a force explains in each beyond what is usual elsewhere."""
    information = prediction.weighting.independent / prediction.weighting.variance
    stiffness = _usual_force(model) ** -2.0
    windows: list[Contact] = []
    for number, (reach, rows) in enumerate(zip(reaches, prediction.rows.runs, strict=True)):
        left, weight = prediction.residual[rows], prediction.rows.weight[rows] * information
        first, last = reach.time[0] + ENDS, reach.time[-1] - ENDS
        for duration in DURATIONS:
            starts = np.arange(first, last - duration, duration / PARTS)
            for some in np.array_split(starts, len(starts) // TOGETHER + 1):
                for start, force, gain in _pushed(reach, left, weight, stiffness, some, duration):
                    name = runs[number].prepared.name
                    windows.append(Contact(number, name, float(start), duration, force, gain))
    every = np.array([one.gains.sum() for one in windows])
    times = np.array([(one.run, one.middle) for one in windows])
    found = []
    for place in np.argsort(-every):
        one = windows[place]
        same = (times[:, 0] == one.run) & (np.abs(times[:, 1] - times[place, 1]) < APART)
        level, scale = _usual(every[~same])
        beyond = one.gains * max(every[place] - level, 0.0) / max(every[place], 1e-300) / scale
        found.append(one._replace(gains=beyond, among=len(windows)))
        if found[-1].gain < 0.0:
            break  # no other can stand out more
    return found


def _usual(gains: np.ndarray) -> tuple[float, float]:
    """Level that most windows stay below, and the mean by which the others exceed it: one for white noise."""
    if not len(gains):
        return 0.0, 1.0
    level = float(np.percentile(gains, USUAL))
    above = gains[gains > level]
    return level, max(1.0, float(np.mean(above - level)) if len(above) else 1.0)


def _pushed(
    reach: Reach, left: np.ndarray, weight: np.ndarray, stiffness: float, starts: np.ndarray, duration: float
) -> Iterator[tuple[float, np.ndarray, np.ndarray]]:
    """Start [s], force (3,) [N] and gains (n,) of windows of one duration [s], solved side by side.

    Args:
        reach: What a force asks of the motors in the run.
        left: What the fit leaves of it, shape (r, n) [N m].
        weight: Information of each row, shape (r, n) [1/(N m)^2].
        stiffness: Inverse square of the expected force [1/N^2].
        starts: When the windows begin, shape (w,) [s].
        duration: [s].
    """
    if not len(starts):
        return
    count = int(np.ceil(duration / float(np.median(np.diff(reach.time))))) + 1
    rows = np.minimum(np.searchsorted(reach.time, starts)[:, None] + np.arange(count), len(reach.time) - 1)
    own = share(reach.time[rows], starts[:, None], duration)
    columns = reach.torque[rows] * own[:, :, None, None]
    weighted = columns * weight[rows][:, :, :, None]
    slope = np.einsum("wrnk,wrn->wk", weighted, left[rows])
    flat, wide = (one.reshape(len(rows), -1, 3) for one in (columns, weighted))
    matrix = flat.transpose(0, 2, 1) @ wide
    # No arm feels every force: along what it does not feel rounding may outweigh what is expected of it.
    held = np.maximum(stiffness, ROUNDING * np.trace(matrix, axis1=1, axis2=2))
    forces = np.linalg.solve(matrix + held[:, None, None] * np.eye(3), slope[:, :, None])[:, :, 0]
    torque = np.einsum("wrnk,wk->wrn", columns, forces)
    gains = np.sum(weight[rows] * (left[rows] * torque - 0.5 * torque**2), axis=1)
    yield from zip(starts, forces, gains, strict=True)


def candidate(model: Model, contact: Contact) -> Candidate:
    """The contact as columns."""
    timing = {"start": contact.start, "duration": contact.duration}

    def columns(run: Driven) -> np.ndarray:
        found = np.zeros((*run.torque.shape, 3))
        if run.prepared.name == contact.name:
            own = share(run.motion.time, contact.start, contact.duration)
            pushed = jacobian(model, run.motion)
            found = -np.einsum("ij,tjk->tik", model.robot.to_motors, pushed * own[:, None, None])
        return found

    return Candidate(
        "contact_event", (), columns, ("fx", "fy", "fz"), ("N", "N", "N"), (-np.inf,) * 3,
        kind=f"{contact.name} at {contact.start:.2f} s",
        reported={name: (value, "s") for name, value in timing.items()},
    )  # fmt: skip


def jacobian(model: Model, motion: Motion) -> np.ndarray:
    """Velocity of the flange by each joint's, in the base's axes, shape (t, n, 3) [m/rad]."""
    robot = model.robot
    kinematics, last = robot.kinematics, robot.kinematics.njoints - 1
    data = kinematics.createData()
    found = np.empty((*motion.position.shape, 3))
    places = np.empty((len(found), 3))
    turns = np.empty(found.shape)
    for row, position in enumerate(motion.position):
        whole = pin.computeJointJacobians(kinematics, data, position)
        places[row] = data.oMi[last].act(robot.flange.translation)
        found[row], turns[row] = whole[:3].T, whole[3:].T
    # Columns are twists about the base's origin: the velocity there, and the turn.
    return found + np.cross(turns, places[:, None])


def _usual_force(model: Model) -> float:
    """How large a force is expected to be [N]."""
    gravity = float(np.linalg.norm(model.robot.kinematics.gravity.linear)) or 9.81
    return FORCE * gravity * max(sum(body.mass for body in model.robot.kinematics.inertias), 1.0)


KINDS = {
    "contact_event": Kind(
        family="event",
        sentence="The arm was in contact with something[ at {start}][ for {duration}]",
        drawn_against=("time", "position"),
        ask=lambda model: iter(()),  # where and when it happens is searched for in `search/once.py`
        of_body=True,
    )
}
