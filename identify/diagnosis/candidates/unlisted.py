"""Candidates for what has no name in the vocabulary, but is met in robot cells.

Each takes the torque that several listed effects would otherwise share: a hose looks like a spring on every
joint, a supply that sags like motors that saturate. Found, it is told in words; an answer in the vocabulary
says that something is unexplained.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...effects.smooth_sign import smooth_sign
from ...model import Model
from ..candidate import Candidate
from ..driven import Driven
from .contact import jacobian
from .measurement import on_joint
from .motors import on_motors

RARE = 0.3
"""How likely each is before the data, beside an effect of the vocabulary [-]."""
REACH = 1.5
"""How far from the base a hose is fixed, about [m]; evidence depends on its logarithm only."""
SIGN = 0.003
"""Speed within which dry friction turns [rad/s]."""


def hoses(model: Model) -> Iterator[Candidate]:
    """A hose or dress pack that pulls the flange to some place, in proportion to how far it is."""
    robot = model.robot

    def columns(run: Driven) -> np.ndarray:
        pushed = jacobian(model, run.motion)
        stretched = np.einsum("tnk,tk->tn", pushed, flange_places(model, run.motion.position))
        return on_motors(robot, np.concatenate([stretched[:, :, None], -pushed], axis=2))

    names, lower = ("stiffness", "pull_x", "pull_y", "pull_z"), (0.0, *(-np.inf,) * 3)
    yield _rare(
        Candidate(
            "hose_spring", (), columns, names, ("N/m", "N", "N", "N"), lower, smooth=True,
            proportion=(1.0, REACH, REACH, REACH),
            led=1,
        )
    )  # fmt: skip


def sags(model: Model) -> Iterator[Candidate]:
    """A supply whose voltage gives way: all drives need more current while the arm draws power."""

    def columns(run: Driven) -> np.ndarray:
        power = np.sum(np.maximum(run.torque * run.motion.velocity, 0.0), axis=1)
        return (run.torque * power[:, None])[:, :, None]

    yield _rare(Candidate("supply_sag", (), columns, ("sag",), ("1/W",), (0.0,)))


def crosstalks(model: Model) -> Iterator[Candidate]:
    """A current sensor that also reads another joint's current."""

    def torque(run: Driven, joint: int, other: int) -> np.ndarray:
        return run.torque[:, other]

    yield from _by_another(model, "current_crosstalk", torque, ("leak",))


def neighbours(model: Model) -> Iterator[Candidate]:
    """Dry friction that goes with where another joint stands: a bearing that its weight bends."""

    def torque(run: Driven, joint: int, other: int) -> np.ndarray:
        sign, q = smooth_sign(run.motion.velocity[:, joint], SIGN), run.motion.position[:, other]
        return np.stack([sign * np.cos(q), sign * np.sin(q)], axis=1)

    yield from _by_another(model, "neighbour_friction", torque, ("Ncos", "Nsin"))


def flange_places(model: Model, positions: np.ndarray) -> np.ndarray:
    """Where the flange is at joint positions (t, n), shape (t, 3) [m] in the base."""
    robot, data = model.robot, model.robot.kinematics.createData()
    last, found = robot.kinematics.njoints - 1, np.empty((len(positions), 3))
    for row, position in enumerate(positions):
        pin.forwardKinematics(robot.kinematics, data, position)
        found[row] = data.oMi[last].act(robot.flange.translation)
    return found


def _by_another(
    model: Model, name: str, torque: Callable[[Driven, int, int], np.ndarray], names: tuple[str, ...]
) -> Iterator[Candidate]:
    """One joint's torque that goes with another joint, whichever it is."""
    count, dof = len(names), model.robot.dof
    units = ("1",) if count == 1 else ("N m",) * count
    for joint in range(dof):
        for other in [k for k in range(dof) if k != joint]:

            def columns(run: Driven, joint: int = joint, other: int = other) -> np.ndarray:
                return on_joint(run, joint, torque(run, joint, other))

            shape, lower = {"other_joint": other + 1.0}, (-np.inf,) * count
            yield _rare(Candidate(name, (joint,), columns, names, units, lower, shape, rows=(joint,)))


def _rare(candidate: Candidate) -> Candidate:
    return replace(candidate, prior=RARE)


UNLISTED: dict[str, Callable[[Model], Iterator[Candidate]]] = {
    "hose_spring": hoses,
    "supply_sag": sags,
    "current_crosstalk": crosstalks,
    "neighbour_friction": neighbours,
}
"""Name outside the vocabulary -> its hypotheses for a model."""
