"""Discrepancy: what no model has, as smooth functions of what was recorded.

Not physics but features: powers, waves and products. They name nothing; what they explain beyond all findings
is what is missing without a name, and with what it goes.
"""

from collections.abc import Callable, Iterator

import numpy as np

from ...effects.smooth_sign import smooth_sign
from ...model import Model
from ..questions.candidate import Candidate
from ..runs.driven import Driven

Feature = Callable[[Driven, int], list[np.ndarray]]
WAVES = 6
"""Half waves over a run of what wanders with time; faster than seconds it is noise."""


def features(model: Model) -> Iterator[Candidate]:
    """All kinds of features on each joint."""
    for joint in range(model.robot.dof):
        for kind, make in KINDS.items():
            count = _count(kind, model.robot.dof)
            if not count:
                continue

            def columns(run: Driven, joint: int = joint, make: Feature = make) -> np.ndarray:
                own = np.stack(make(run, joint), axis=1)
                whole = np.zeros((*run.torque.shape, own.shape[1]))
                whole[:, joint] = own
                return whole

            yield Candidate(kind, (joint,), columns, ("",) * count, ("",) * count, (-np.inf,) * count)


def _position(run: Driven, joint: int) -> list[np.ndarray]:
    q = run.motion.position[:, joint]
    return [f(k * q) for k in (1, 2, 3) for f in (np.cos, np.sin)]


def _velocity(run: Driven, joint: int) -> list[np.ndarray]:
    v = run.motion.velocity[:, joint]
    return [*(smooth_sign(v, width) for width in (0.01, 0.03, 0.1, 0.3)), np.abs(v), v**3]


def _position_and_direction(run: Driven, joint: int) -> list[np.ndarray]:
    sign = smooth_sign(run.motion.velocity[:, joint], 0.003)
    return [sign * one for one in _position(run, joint)]


def _load(run: Driven, joint: int) -> list[np.ndarray]:
    load, v = run.motion.load[:, joint], run.motion.velocity[:, joint]
    share, sign = load / max(float(run.most[joint]), 1e-9), smooth_sign(v, 0.003)
    return [share, share**2, share**3, sign * share, sign * np.abs(share), sign * share**2]


def _acceleration(run: Driven, joint: int) -> list[np.ndarray]:
    return [run.motion.acceleration[:, k] for k in range(run.torque.shape[1])]


def _time(run: Driven, joint: int) -> list[np.ndarray]:
    """Offsets and dry friction that wander, in half waves over the run."""
    t = run.motion.time - run.motion.time[0]
    turn = np.pi * t / max(float(t[-1]), 1e-9)
    sign = smooth_sign(run.motion.velocity[:, joint], 0.003)
    return [kind * np.cos(k * turn) for k in range(1, WAVES + 1) for kind in (np.ones_like(sign), sign)]


def _other_joints(run: Driven, joint: int) -> list[np.ndarray]:
    others = [k for k in range(run.torque.shape[1]) if k != joint]
    torques = [run.torque[:, k] for k in others]
    signs = [smooth_sign(run.motion.velocity[:, k], 0.003) for k in others]
    return torques + signs


def _other_positions(run: Driven, joint: int) -> list[np.ndarray]:
    others = [k for k in range(run.torque.shape[1]) if k != joint]
    q = run.motion.position
    return [f(q[:, k]) for k in others for f in (np.cos, np.sin)]


KINDS: dict[str, Feature] = {
    "position": _position,
    "velocity": _velocity,
    "position and direction": _position_and_direction,
    "load": _load,
    "acceleration": _acceleration,
    "time": _time,
    "other joints' torque or direction": _other_joints,
    "other joints' position": _other_positions,
}


def _count(kind: str, dof: int) -> int:
    fixed = {"position": 6, "velocity": 6, "position and direction": 6, "load": 6, "time": 2 * WAVES}
    return fixed.get(kind, {"acceleration": dof}.get(kind, 2 * (dof - 1)))
