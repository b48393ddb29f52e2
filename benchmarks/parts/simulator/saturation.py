"""Limits of servos that saturate: such that an arm spends a share of its samples at the limit.

A joint at its limit lags behind, and so stays there longer. Therefore the limit is searched with the whole
arm, including everything else that is concealed.
"""

from pathlib import Path

import numpy as np

from exidyn.identification.model import Model

from .motions import FAST, SEEDS, commands
from .physics import Item
from .real_arm import Motion, RealArm

SECONDS = 20.0
"""Duration of the motions that size items [s]."""
BISECTIONS = 7
REACHED = 0.999
"""Share of the limit that counts as the limit: torques are means over samples."""


def with_limits(path: Path, nominal: Model, items: list[Item]) -> tuple[Item, ...]:
    """Items in which the share of saturated samples, where there is any, has become a limit [N m]."""
    for index, item in enumerate(items):
        if item.kind == "forcerange":
            others = [*items[:index], *items[index + 1 :]]
            items[index] = _limited(path, nominal, item, others)
    return tuple(items)


def _limited(path: Path, nominal: Model, item: Item, others: list[Item]) -> Item:
    """The item with the limit that an arm with these other items reaches in the item's share of samples."""
    [joint], joints = item.joints, nominal.robot.joints
    unlimited = sizing_motion(RealArm(path, joints, others), nominal)
    lower, upper = 0.0, float(np.max(np.abs(unlimited.torque[:, joint])))
    for _ in range(BISECTIONS):
        limit = 0.5 * (lower + upper)
        arm = RealArm(path, joints, [*others, item._replace(values={"limit": limit})])
        too_low = _saturated(arm, nominal, joint, limit) > item.values["saturated"]
        lower, upper = (limit, upper) if too_low else (lower, limit)
    return item._replace(values={"limit": upper})


def _saturated(arm: RealArm, nominal: Model, joint: int, limit: float) -> float:
    """Share of the samples of all motions at the limit of a servo [-]."""
    motions = [sizing_motion(arm, nominal, seed) for seed in SEEDS.values()]
    torques = np.concatenate([np.abs(motion.torque[:, joint]) for motion in motions])
    return float(np.mean(torques > REACHED * limit))


def sizing_motion(arm: RealArm, nominal: Model, seed: int = 0) -> Motion:
    """The random motion of an arm by which items are sized."""
    return arm.follow(*commands(nominal.robot.limits, SECONDS, 1.0 / FAST, seed))
