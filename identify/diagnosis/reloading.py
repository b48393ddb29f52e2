"""Reloading: the load that gears transmit as it is known after a fit, with everything found that they carry.

A link floats in its play, and rubs by its load, where its load is small: some thousandths of it decide when.
"""

from collections.abc import Sequence

import numpy as np

from ..model import Model
from .candidate import Candidate, Thinned
from .driven import Driven
from .hypothesis import Hypothesis
from .solution import Solution

LOADED = ("joint_elasticity", "backlash", "load_dependent_friction")
"""Effects that depend on the load."""
CARRIED = ("payload", "link_inertia", "base_tilt", "encoder_offset", "spring_balancer", "joint_spring")
"""Effects whose torque gears transmit."""
ALIKE = 2e-3
"""Change of a load over the load [-] that moves no link: its play is crossed some milliseconds sooner."""


def reloaded(
    model: Model, runs: Sequence[Driven], solution: Solution, found: Sequence[Hypothesis]
) -> list[Driven]:
    """The runs with the torque and load of a solution whose last unknowns are what was found."""
    count = sum(len(one.values) for one in found)
    own = np.split(solution.values[len(solution.values) - count :], np.cumsum([len(f.values) for f in found]))
    fresh = [run.after(model, model.believed_values + solution.values[: len(model.names)]) for run in runs]
    for one, values in zip(found, own, strict=False):
        if one.candidate.effect in CARRIED:
            fresh = [run.bearing(_on_joints(model, one.candidate.columns(run) @ values)) for run in fresh]
    return fresh


def alike(before: Sequence[Driven], after: Sequence[Driven]) -> bool:
    """Whether the load has hardly changed."""
    pairs = [(one.motion.load, other.motion.load) for one, other in zip(before, after, strict=True)]
    load = np.concatenate([one for one, _ in pairs])
    change = np.concatenate([other - one for one, other in pairs])
    return bool(np.all(np.linalg.norm(change, axis=0) <= ALIKE * np.linalg.norm(load, axis=0)))


def anew(candidate: Candidate, columns: Thinned, runs: Sequence[Driven]) -> Thinned:
    """Columns of a candidate over runs whose load has changed."""
    return Thinned.of(candidate, runs) if candidate.effect in LOADED else columns


def _on_joints(model: Model, torque: np.ndarray) -> np.ndarray:
    """Torque of motors (t, n) [N m], seen from the joints."""
    return np.linalg.solve(model.robot.to_motors, torque.T).T
