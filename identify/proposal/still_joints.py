"""Joints that stand still throughout a log: no motion identifies them, and the model holds them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..text_table import digits
from .drives import GAIN_OF, gain_guesses
from .hypotheses import factor_of
from .proposal import Proposal
from .quirks import at_rest

STILL = 1e-3
"""Range of a position below which a joint does not move [rad, m]: a loaded gear bends by as much."""


class Still(NamedTuple):
    """What stands still.

    Attributes:
        position: Joint -> where it stands [rad, m].
        column: Column of its position -> between what it stays, in the unit of the log.
    """

    position: Mapping[str, float] = MappingProxyType({})
    column: Mapping[str, tuple[float, float]] = MappingProxyType({})


NOTHING = Still()


def still_joints(proposal: Proposal, robot: Robot, names: Sequence[str], values: np.ndarray) -> Still:
    """Joints that move by less than `STILL` in all of a log, if any other moves.

    Args:
        proposal: For the log.
        robot: As described.
        names: Of the columns of the log.
        values: Shape (t, c).
    """
    columns = proposal.columns["position"]
    position = values[:, [list(names).index(column) for column in columns]]
    factor = factor_of(robot, proposal.units.position)
    resting = np.nanmax(position, axis=0) - np.nanmin(position, axis=0) < STILL / factor
    if resting.all():
        return NOTHING
    middle, about = np.nanmedian(position, axis=0), STILL / factor
    places = np.flatnonzero(resting)
    return Still(
        {robot.joints[j]: float(middle[j] * factor[j]) for j in places},
        {columns[j]: (float(middle[j] - about[j]), float(middle[j] + about[j])) for j in places},
    )


def without_still(proposal: Proposal, robot: Robot, still: Still) -> Proposal:
    """The same without columns and gains of those joints, and a note of each."""
    kept = [j for j, joint in enumerate(robot.joints) if joint not in still.position]
    columns = {
        signal: names if signal == "time" else tuple(names[j] for j in kept)
        for signal, names in proposal.columns.items()
    }
    found = tuple(proposal.gains[j] for j in kept) if proposal.gains else ()
    guesses = [guess for guess in proposal.guesses if not guess.what.startswith(GAIN_OF)]
    guesses += gain_guesses([robot.joints[j] for j in kept], found)
    notes = [note for note in proposal.notes if note not in map(at_rest, still.position)]
    for joint, where in still.position.items():
        unit = "rad" if robot.revolute[robot.index(joint)] else "m"
        notes.append(f"{at_rest(joint)}: the model holds it at {digits(where)} {unit}")
    return replace(proposal, columns=columns, gains=found, guesses=tuple(guesses), notes=tuple(notes))
