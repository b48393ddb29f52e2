"""Rare: what has no name in the vocabulary, but is met in robot cells.

Each takes the torque that several listed effects would otherwise share: a hose looks like a spring on every
joint, a supply that sags like motors that saturate. Found, it is reported in words; an answer in the
vocabulary states that something is unexplained.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from ....model import Model
from ...questions.candidate import Candidate
from ...runs.driven import Driven
from .motors import on_joint

RARE = 0.3
"""How likely each is before the data, beside an effect of the vocabulary [-]."""


def rare(candidate: Candidate) -> Candidate:
    """The candidate as unlikely as it is, and without a name in the vocabulary."""
    return replace(candidate, prior=RARE, listed=False)


def by_another(
    model: Model, name: str, torque: Callable[[Driven, int, int], np.ndarray], names: tuple[str, ...]
) -> Iterator[Candidate]:
    """One joint's torque that depends on another joint, whichever it is."""
    count, dof = len(names), model.robot.dof
    units = ("1",) if count == 1 else ("N m",) * count
    for joint in range(dof):
        for other in [k for k in range(dof) if k != joint]:

            def columns(run: Driven, joint: int = joint, other: int = other) -> np.ndarray:
                return on_joint(run, joint, torque(run, joint, other))

            shape, lower = {"other_joint": other + 1.0}, (-np.inf,) * count
            yield rare(Candidate(name, (joint,), columns, names, units, lower, shape, rows=(joint,)))
