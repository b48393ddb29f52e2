"""A run of one kind as a plan."""

from collections.abc import Sequence

from exidyn.identify.model import Model

from ..joint_names_in_errors import in_words_of
from ..limits.usable_limits import usable
from ..planning.wishes import Wishes
from ..plans.plan import Plan
from . import KINDS


def by_rule(kind: str, model: Model, wishes: Wishes, joints: Sequence[int] = ()) -> Plan:
    """A run of a kind.

    Args:
        kind: A name in `KINDS`.
        model: Of the arm.
        wishes: What is wanted of it.
        joints: That move, from 0; all by default.
    """
    limits, assumed = usable(model.robot, wishes.margins, wishes.window, wishes.start)
    with in_words_of(model.robot):
        made = KINDS[kind](model, wishes, limits, joints or range(model.robot.dof))
    return Plan.of(
        made.trajectory,
        model,
        margins=vars(wishes.margins),
        tick=wishes.tick,
        assumed=(*assumed, *made.notes),
        details={"kind": kind},
    )
