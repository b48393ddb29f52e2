"""Candidates that happen once: something touches the arm for a while.

A force f on the flange, in the base's axes, asks -J'(q) f of the motors. There is a window for every tenth of
a second of every run, so that only those are weighed in which the residual stands out; they count as one of
all.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from scipy import signal

from ...effects import Shape
from ...model import Model
from ...motion import Motion
from ..candidate import Candidate
from ..driven import Driven
from ..solution import Solution

DURATIONS = (0.3, 0.6, 1.0)
"""Of a touch [s]; each within half of the next is refined."""
PARTS = 4
"""Starts that are tried in a duration."""
ENDS = 1.0
"""At the beginning and at the end of a run in which no touch is looked for [s]: where an arm starts and
stops, friction that is not quite as believed looks like a push."""
STANDING_OUT = 2.0
"""How much more a touch has to explain than a force at any other time; what stands out less is a model that
is wrong here and there."""
WEIGHED = 8
"""Windows that are weighed."""
FORCE = 0.1
"""How large a force is expected to be, share of the arm's weight [-]."""


class Touch(NamedTuple):
    """When something touches the arm: number and name of the run, start and duration [s]."""

    run: int
    name: str
    start: float
    duration: float

    def share(self, time: np.ndarray) -> np.ndarray:
        """Of the force, at times (t,) [s]: soon there, soon gone."""
        since = np.clip((time - self.start) / self.duration, 0.0, 1.0)
        return np.sqrt(np.sin(np.pi * since))


class Reach(NamedTuple):
    """What a force on the flange asks of the motors at the rows of a run.

    Attributes:
        time: Of the rows, shape (r,) [s].
        pushed: Shape (r, n, 3) [N m/N].
    """

    time: np.ndarray
    pushed: np.ndarray

    @classmethod
    def of(cls, model: Model, run: Driven) -> "Reach":
        """Of a run, as its rows are compared."""
        centres = run.prepared.decimation.centres(len(run.motion))[: run.rows]
        motion = run.motion[centres[0] : centres[-1] + 1 : run.prepared.decimation.stride]
        pushed = np.einsum("ij,tjk->tik", model.robot.to_motors, jacobian(model, motion))
        return cls(motion.time, pushed)


def touches(
    model: Model, solution: Solution, runs: Sequence[Driven], reaches: Sequence[Reach]
) -> Iterator[Candidate]:
    """Windows in which a force explains most of what is left, if they stand out among all others."""
    scored = [
        pair
        for number, (run, reach) in enumerate(zip(runs, reaches, strict=True))
        for pair in _scored(model, solution, run, reach, number)
    ]
    scored.sort(key=lambda pair: -pair[1])
    if not scored:
        return
    first, score = scored[0]
    elsewhere = max((other for touch, other in scored if not _near(touch, first)), default=0.0)
    if score < STANDING_OUT * elsewhere:
        return
    for touch, _ in scored[:WEIGHED]:
        yield _touch(model, touch, len(scored))


def _near(one: Touch, other: Touch) -> bool:
    """Whether two windows are of the same touch, or of one that follows it at once."""
    middles = one.start + 0.5 * one.duration, other.start + 0.5 * other.duration
    return one.run == other.run and abs(middles[0] - middles[1]) < 2.0 * max(DURATIONS)


def _touch(model: Model, touch: Touch, among: int) -> Candidate:
    def columns(run: Driven) -> np.ndarray:
        found = np.zeros((*run.torque.shape, 3))
        if run.prepared.name != touch.name:
            return found
        within = _within(run.motion.time, touch)
        pushed = jacobian(model, run.motion[within]) * touch.share(run.motion.time[within])[:, None, None]
        found[within] = -np.einsum("ij,tjk->tik", model.robot.to_motors, pushed)
        return found

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return _touch(model, touch._replace(start=given["start"], duration=given["duration"]), among)

    return Candidate(
        "contact_event",
        (),
        columns,
        ("force_x", "force_y", "force_z"),
        ("N", "N", "N"),
        (-np.inf,) * 3,
        {"run": float(touch.run), "start": touch.start, "duration": touch.duration},
        {
            "start": Shape("s", touch.start - 0.5 * touch.duration, touch.start + 0.5 * touch.duration),
            "duration": Shape("s", touch.duration / 1.8, touch.duration * 1.8),
        },
        reshaped,
        expected=((0.0, _force(model)),) * 3,
        among=among,
    )


def _scored(
    model: Model, solution: Solution, run: Driven, reach: Reach, number: int
) -> list[tuple[Touch, float]]:
    """Windows of one run, and about how much likelier a force in each makes what is left there.

    Every window's score takes three sums of products with what is left; against a short push the unknowns
    of the model are taken as known.
    """
    rows, times, pushed = solution.rows.runs[number], reach.time, reach.pushed
    left, gains = _left(solution, rows)
    slope = -np.einsum("tjk,tj->tk", pushed, left)
    curvature = np.einsum("tjk,tj,tjl->tkl", pushed, gains, pushed)
    found = []
    for duration in DURATIONS:
        for start in np.arange(times[0] + ENDS, times[-1] - ENDS - duration, duration / PARTS):
            touch = Touch(number, run.prepared.name, float(start), duration)
            within = _within(times, touch)
            share = touch.share(times[within])
            one = np.einsum("t,tk->k", share, slope[within])
            two = np.einsum("t,tkl->kl", share**2, curvature[within])
            two += np.eye(3) / _force(model) ** 2
            found.append((touch, float(0.5 * one @ np.linalg.solve(two, one))))
    return found


def _left(solution: Solution, rows: slice) -> tuple[np.ndarray, np.ndarray]:
    """What is left as slow columns see it, and how much a slow column of one weighs, each (r, n)."""
    whitening = solution.whitening
    valid = whitening.valid[rows]
    left, gains = np.zeros(valid.shape), np.zeros(valid.shape)
    for joint in range(valid.shape[1]):
        taps, scale = whitening.filters[joint], whitening.scale[joint]
        white = np.zeros(whitening.valid.shape[0])
        white[whitening.valid[:, joint]] = solution.left[joint]
        # The transpose of the filter: each sample tells of those before it.
        left[:, joint] = valid[:, joint] * signal.lfilter(taps, 1.0, white[rows][::-1])[::-1] / scale
        gains[:, joint] = valid[:, joint] * (np.sum(taps) / scale) ** 2
    return left, gains


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


def _force(model: Model) -> float:
    """How large a force is expected to be [N]."""
    return (
        FORCE
        * float(np.linalg.norm(model.robot.kinematics.gravity.linear))
        * sum(body.mass for body in model.robot.kinematics.inertias)
    )


def _within(time: np.ndarray, touch: Touch) -> slice:
    first, last = np.searchsorted(time, [touch.start, touch.start + touch.duration])
    return slice(int(first), int(last))
