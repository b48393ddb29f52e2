"""Contact: something pushes the arm for a while.

A force f on the flange, in the base's axes, asks -J'(q) f of the motors. It happens once, so that no other
block predicts it: a window of a run has a contact where a force explains far more of what is left than forces
at all other times do.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ...model import Model
from ...motion import Motion
from ..candidate import Candidate
from ..driven import Driven
from ..prediction import Prediction

DURATIONS = (0.3, 0.6, 1.0)
"""Of a contact [s]."""
PARTS = 4
"""Starts that are tried in a duration."""
ENDS = 1.0
"""At the beginning and at the end of a run in which no contact is looked for [s]: where an arm starts and
stops, friction that is not quite as modelled looks like a push."""
FORCE = 0.1
"""How large a force is expected to be, share of the arm's weight [-]."""
USUAL = 90.0
"""Percentage of all windows that have no contact: what forces explain there is how wrong the model is."""
APART = 2.0
"""Time from a contact on which a window says what is usual [s]: longer than any contact."""


@dataclass(frozen=True, eq=False)
class Contact:
    """A window of a run, and the force that explains most of what is left in it.

    Attributes:
        run: Its number among the runs.
        name: Of the run.
        start: Of the window, by the run's time [s].
        duration: [s].
        force: On the flange, in the base's axes, shape (3,) [N].
        gains: Logarithm of how much more probable the force makes each joint's rows, shape (n,).
        among: Number of windows.
    """

    run: int
    name: str
    start: float
    duration: float
    force: np.ndarray
    gains: np.ndarray
    among: int

    @property
    def gain(self) -> float:
        """Logarithm of the probability gained, less what choosing the window cost."""
        return float(self.gains.sum() - np.log(self.among))

    @property
    def without_one(self) -> float:
        """The same without the joint that gains most: what one joint alone feels is its own affair."""
        return self.gain - float(self.gains.max())


def share(time: np.ndarray, start: float, duration: float) -> np.ndarray:
    """Of the largest force, at times (t,) [s]: soon there, soon gone."""
    since = np.clip((time - start) / duration, 0.0, 1.0)
    return np.sqrt(np.sin(np.pi * since))


def contacts(model: Model, prediction: Prediction, runs: Sequence[Driven]) -> list[Contact]:
    """All windows of all runs, with how much a force explains in each beyond what is usual elsewhere."""
    information = prediction.weighting.independent / prediction.weighting.variance
    windows = []
    for number, (run, rows) in enumerate(zip(runs, prediction.rows.runs, strict=True)):
        weight = prediction.rows.weight[rows] * information
        windows += _scanned(model, run, prediction.residual[rows], weight, number)
    every = np.array([gains.sum() for *_, gains in windows])
    times = np.array([(number, start + 0.5 * duration) for number, start, duration, *_ in windows])
    found = []
    for place in np.argsort(-every):
        number, start, duration, force, gains = windows[place]
        same = (times[:, 0] == number) & (np.abs(times[:, 1] - times[place, 1]) < APART)
        level, scale = _usual(every[~same])
        beyond = gains * max(every[place] - level, 0.0) / max(every[place], 1e-300) / scale
        name = runs[number].prepared.name
        found.append(Contact(number, name, start, duration, force, beyond, len(windows)))
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


def _scanned(
    model: Model, run: Driven, left: np.ndarray, weight: np.ndarray, number: int
) -> list[tuple[int, float, float, np.ndarray, np.ndarray]]:
    """Windows of one run: number, start, duration, force (3,), and what it explains of each joint (n,)."""
    time, pushed = reach(model, run)
    found = []
    for duration in DURATIONS:
        for start in np.arange(time[0] + ENDS, time[-1] - ENDS - duration, duration / PARTS):
            first, last = np.searchsorted(time, [start, start + duration])
            own = slice(int(first), int(last))
            columns = -pushed[own] * share(time[own], start, duration)[:, None, None]
            slope = np.einsum("tnk,tn->k", columns, weight[own] * left[own])
            matrix = np.einsum("tnk,tn,tnl->kl", columns, weight[own], columns)
            force = np.linalg.solve(matrix + np.eye(3) / _usual_force(model) ** 2, slope)
            torque = columns @ force
            gains = np.sum(weight[own] * (left[own] * torque - 0.5 * torque**2), axis=0)
            found.append((number, float(start), duration, force, gains))
    return found


def reach(model: Model, run: Driven) -> tuple[np.ndarray, np.ndarray]:
    """Times of a run's rows (r,) [s], and what a force on the flange asks of the motors (r, n, 3) [N m/N]."""
    centres = run.prepared.decimation.centres(len(run.motion))[: run.rows]
    motion = run.motion[centres[0] : centres[-1] + 1 : run.prepared.decimation.stride]
    return motion.time, np.einsum("ij,tjk->tik", model.robot.to_motors, jacobian(model, motion))


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
        told={name: (value, "s") for name, value in timing.items()},
    )  # fmt: skip


def jacobian(model: Model, motion: Motion) -> np.ndarray:
    """Velocity of the flange by each joint's, in the base's axes, shape (t, n, 3) [m/rad]."""
    robot = model.robot
    kinematics, last = robot.kinematics, robot.kinematics.njoints - 1
    data = kinematics.createData()
    found = np.empty((*motion.position.shape, 3))
    for row, position in enumerate(motion.position):
        whole = pin.computeJointJacobians(kinematics, data, position)
        frame = data.oMi[last]
        place = frame.act(robot.flange.translation)
        # Columns are twists about the base's origin: the velocity there, and the turn.
        found[row] = (whole[:3] + np.cross(whole[3:], place, axis=0)).T
    return found


def _usual_force(model: Model) -> float:
    """How large a force is expected to be [N]."""
    gravity = float(np.linalg.norm(model.robot.kinematics.gravity.linear)) or 9.81
    return FORCE * gravity * max(sum(body.mass for body in model.robot.kinematics.inertias), 1.0)
