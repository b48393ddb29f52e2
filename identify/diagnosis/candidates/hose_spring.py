"""Hose: a hose or dress pack that pulls the flange to some place, in proportion to how far it is."""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from ...model import Model
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from .contact_event import jacobian
from .parts.motors import on_motors
from .parts.rare import rare

REACH = 1.5
"""How far from the base a hose is fixed, about [m]; evidence depends on its logarithm only."""


def hoses(model: Model) -> Iterator[Candidate]:
    """Fixed anywhere."""
    robot = model.robot

    def columns(run: Driven) -> np.ndarray:
        pushed = jacobian(model, run.motion)
        stretched = np.einsum("tnk,tk->tn", pushed, flange_places(model, run.motion.position))
        return on_motors(robot, np.concatenate([stretched[:, :, None], -pushed], axis=2))

    names, lower = ("stiffness", "pull_x", "pull_y", "pull_z"), (0.0, *(-np.inf,) * 3)
    yield rare(
        Candidate(
            "hose_spring", (), columns, names, ("N/m", "N", "N", "N"), lower, smooth=True,
            proportion=(1.0, REACH, REACH, REACH),
            led=1,
        )
    )  # fmt: skip


def flange_places(model: Model, positions: np.ndarray) -> np.ndarray:
    """Where the flange is at joint positions (t, n), shape (t, 3) [m] in the base."""
    robot, data = model.robot, model.robot.kinematics.createData()
    last, found = robot.kinematics.njoints - 1, np.empty((len(positions), 3))
    for row, position in enumerate(positions):
        pin.forwardKinematics(robot.kinematics, data, position)
        found[row] = data.oMi[last].act(robot.flange.translation)
    return found


KIND = Kind(
    sentence="A spring pulls the flange towards one point, as hoses and dress packs do[: {stiffness}]",
    drawn_against=("position", "load"),
    ask=hoses,
    of_body=True,
)
