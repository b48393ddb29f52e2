"""Contact event: something pushes the arm for a while.

A force f on the flange, in the base's axes, requires the torque -J'(q) f. It happens once, so no other block
predicts it: a window of a run contains a contact if a force explains far more of the residual there than at
all other times.
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
"""Number of start times that are tried per duration."""
TOGETHER = 1000
"""Windows that are solved at once: some tens of megabytes."""
ENDS = 1.0
"""Time at the beginning and end of a run in which no contact is searched [s]: where an arm starts and stops,
friction that differs from the model looks like a push."""
FORCE = 0.1
"""Expected force, share of the arm's weight [-]."""
USUAL = 90.0
"""Percentage of windows without a contact, in which the gain of a force shows the error of the model."""
APART = 2.0
"""Time from a contact beyond which a window shows the usual gain [s]: longer than any contact."""


class Contact(NamedTuple):
    """A window of a run, and the force that explains most of its residual."""

    run: int  # index of the run
    name: str  # name of the run
    start: float  # start of the window in the run's time [s]
    duration: float  # duration of the window [s]
    force: np.ndarray  # force on the flange, in the base's axes, shape (3,) [N]
    gains: np.ndarray  # gain in log probability of each joint's rows, shape (n,)
    among: int = 1  # number of windows

    @property
    def middle(self) -> float:
        """Middle of the window [s]."""
        return self.start + 0.5 * self.duration

    @property
    def gain(self) -> float:
        """Gain in log probability, less the cost of choosing the window."""
        return float(self.gains.sum() - np.log(self.among))

    @property
    def gain_without_best_joint(self) -> float:
        """Gain without the joint that gains most: an effect on one joint alone is no contact."""
        return self.gain - float(self.gains.max())


def share(time: np.ndarray, start: float | np.ndarray, duration: float) -> np.ndarray:
    """Force over its largest value at times (t,) [s]; it rises and falls fast."""
    since = np.clip((time - start) / duration, 0.0, 1.0)
    return np.sqrt(np.sin(np.pi * since))


class FlangeTorque(NamedTuple):
    """Motor torque per unit of force on the flange, over one run."""

    time: np.ndarray  # time of each row, shape (r,) [s]
    torque: np.ndarray  # torque per unit of force, shape (r, n, 3) [N m/N]

    @classmethod
    def of(cls, model: Model, run: Driven) -> "FlangeTorque":
        """Compute it at the rows of a run."""
        motion = run.motion[run.centres[0] : run.centres[-1] + 1 : run.prepared.decimation.stride]
        return cls(motion.time, -np.einsum("ij,tjk->tik", model.robot.to_motors, jacobian(model, motion)))


def contacts(
    model: Model, prediction: Prediction, runs: Sequence[Driven], flange_torques: Sequence[FlangeTorque]
) -> list[Contact]:
    """Windows of all runs, with the gain of a force beyond the gain that is usual elsewhere, best first."""
    information = prediction.weighting.independent / prediction.weighting.variance
    stiffness = _usual_force(model) ** -2.0
    windows: list[Contact] = []
    for number, (flange_torque, rows) in enumerate(zip(flange_torques, prediction.rows.runs, strict=True)):
        residual, weight = prediction.residual[rows], prediction.rows.weight[rows] * information
        first, last = flange_torque.time[0] + ENDS, flange_torque.time[-1] - ENDS
        for duration in DURATIONS:
            starts = np.arange(first, last - duration, duration / PARTS)
            for batch in np.array_split(starts, len(starts) // TOGETHER + 1):
                for start, force, gain in _pushed(
                    flange_torque, residual, weight, stiffness, batch, duration
                ):
                    name = runs[number].prepared.name
                    windows.append(Contact(number, name, float(start), duration, force, gain))
    gains = np.array([window.gains.sum() for window in windows])
    times = np.array([(window.run, window.middle) for window in windows])
    best = []
    for place in np.argsort(-gains):
        window = windows[place]
        same = (times[:, 0] == window.run) & (np.abs(times[:, 1] - times[place, 1]) < APART)
        level, scale = _usual(gains[~same])
        beyond = window.gains * max(gains[place] - level, 0.0) / max(gains[place], 1e-300) / scale
        best.append(window._replace(gains=beyond, among=len(windows)))
        if best[-1].gain < 0.0:
            break  # no further window can stand out more
    return best


def _usual(gains: np.ndarray) -> tuple[float, float]:
    """Level that most windows stay below, and the mean excess of the others over it: 1 for white noise."""
    if not len(gains):
        return 0.0, 1.0
    level = float(np.percentile(gains, USUAL))
    above = gains[gains > level]
    return level, max(1.0, float(np.mean(above - level)) if len(above) else 1.0)


def _pushed(
    flange_torque: FlangeTorque,
    residual: np.ndarray,
    weight: np.ndarray,
    stiffness: float,
    starts: np.ndarray,
    duration: float,
) -> Iterator[tuple[float, np.ndarray, np.ndarray]]:
    """Start [s], force (3,) [N] and gains (n,) of windows of one duration, solved at once."""
    if not len(starts):
        return
    count = int(np.ceil(duration / float(np.median(np.diff(flange_torque.time))))) + 1
    rows = np.minimum(
        np.searchsorted(flange_torque.time, starts)[:, None] + np.arange(count), len(flange_torque.time) - 1
    )
    shares = share(flange_torque.time[rows], starts[:, None], duration)
    columns = flange_torque.torque[rows] * shares[:, :, None, None]
    weighted = columns * weight[rows][:, :, :, None]
    slope = np.einsum("wrnk,wrn->wk", weighted, residual[rows])
    flat, flat_weighted = (values.reshape(len(rows), -1, 3) for values in (columns, weighted))
    matrix = flat.transpose(0, 2, 1) @ flat_weighted
    # Some force directions need no motor torque: rounding there may exceed the prior.
    held = np.maximum(stiffness, ROUNDING * np.trace(matrix, axis1=1, axis2=2))
    forces = np.linalg.solve(matrix + held[:, None, None] * np.eye(3), slope[:, :, None])[:, :, 0]
    torque = np.einsum("wrnk,wk->wrn", columns, forces)
    gains = np.sum(weight[rows] * (residual[rows] * torque - 0.5 * torque**2), axis=1)
    yield from zip(starts, forces, gains, strict=True)


def candidate(model: Model, contact: Contact) -> Candidate:
    """The contact as a candidate."""
    timing = {"start": contact.start, "duration": contact.duration}

    def columns(run: Driven) -> np.ndarray:
        torque = np.zeros((*run.torque.shape, 3))
        if run.prepared.name == contact.name:
            shares = share(run.motion.time, contact.start, contact.duration)
            pushed = jacobian(model, run.motion)
            torque = -np.einsum("ij,tjk->tik", model.robot.to_motors, pushed * shares[:, None, None])
        return torque

    return Candidate(
        "contact_event", (), columns, ("fx", "fy", "fz"), ("N", "N", "N"), (-np.inf,) * 3,
        kind=f"{contact.name} at {contact.start:.2f} s",
        reported={name: (value, "s") for name, value in timing.items()},
    )  # fmt: skip


def jacobian(model: Model, motion: Motion) -> np.ndarray:
    """Velocity of the flange per unit of each joint's velocity, in the base's axes, (t, n, 3) [m/rad]."""
    return flange(model, motion)[1]


def flange(model: Model, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Places of the flange in the base frame, (t, 3) [m], and its `jacobian`."""
    robot, kinematics = model.robot, model.robot.kinematics
    data, last = kinematics.createData(), kinematics.njoints - 1
    places, twists = np.empty((len(motion), 3)), np.empty((len(motion), 6, robot.dof))
    for row, position in enumerate(motion.position):
        # Pinocchio gives a vector for a single joint.
        twists[row] = pin.computeJointJacobians(kinematics, data, position).reshape(6, -1)
        places[row] = data.oMi[last].act(robot.flange.translation)
    # Twists are about the base's origin: linear velocity there, and angular velocity.
    linear, angular = np.moveaxis(twists[:, :3], 1, 2), np.moveaxis(twists[:, 3:], 1, 2)
    return places, linear + np.cross(angular, places[:, None])


def _usual_force(model: Model) -> float:
    """Expected force [N]."""
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
