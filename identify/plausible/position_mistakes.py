"""Mistakes in columns and positions: order, unit, sign or scale."""

from collections.abc import Callable, Iterator
from itertools import combinations, permutations
from types import MappingProxyType

import numpy as np

from ..arm.robot import Robot
from ..text_table import digits
from .mistake import Case, Change, LogFacts
from .units import LEAST_PERCENT, PERCENT

ANGLES = MappingProxyType(
    {
        "in degrees": np.pi / 180,
        "in radians, but read as degrees": 180 / np.pi,
        "in counts of 12 bits per turn": 2 * np.pi / 2**12,
    }
)
"""Confused unit of positions -> its size in the stated unit."""
POSITION_SCALES = (1 / 10, 1 / 4, 1 / 3, 1 / 2, 2.0, 3.0, 4.0, 10.0)
ONE_SCALE = (1 / 4, 1 / 2, 2.0, 4.0)
"""True angle over logged angle if gears or encoders were assumed wrongly, for all joints and for one."""
CHAINS = 24
"""Maximum number of permutations of equal chains that are tested, enough for four legs."""


def exchanges(position: bool, effort: bool, words: str) -> Callable[[LogFacts], Iterator[Case]]:
    """Exchanged columns of two joints."""

    def cases(facts: LogFacts) -> Iterator[Case]:
        for a, b in _likely_pairs(facts):
            order = np.arange(facts.robot.dof)
            order[[a, b]] = b, a
            change = Change(position=order if position else None, effort=order if effort else None)
            yield f"{words} of {facts.joints[a]} and {facts.joints[b]} are exchanged", change, (a, b)

    return cases


def _likely_pairs(facts: LogFacts) -> Iterator[tuple[int, int]]:
    """Pairs of joints that are easily confused: in one chain, or at the same place of equal chains."""
    chains = equal_chains(facts.robot)
    place = {joint: (chain, k) for chain, joints in enumerate(chains) for k, joint in enumerate(joints)}
    for a, b in combinations(facts.moving, 2):
        if not chains or place[a][0] == place[b][0] or place[a][1] == place[b][1]:
            yield a, b


def orders(facts: LogFacts) -> Iterator[Case]:
    """Columns of all joints in another order."""
    n = facts.robot.dof
    plain = np.arange(n)
    ranks = np.array([sorted(facts.joints).index(joint) for joint in facts.joints])
    orders = {
        "are in reverse order": plain[::-1],
        "begin one late": np.roll(plain, 1),
        "begin one early": np.roll(plain, -1),
        "are sorted by name": ranks,
    }
    for words, order in orders.items():
        if n > 2 and not np.array_equal(order, plain):
            yield facts.of_all(f"the columns {words}", Change(order, order))


def exchanged_chains(facts: LogFacts) -> Iterator[Case]:
    """Exchanged columns of whole chains, such as legs."""
    chains = equal_chains(facts.robot)
    usual = tuple(range(len(chains)))
    for place, order in enumerate(permutations(usual)):
        if order == usual or place >= CHAINS:
            continue
        columns = np.arange(facts.robot.dof)
        for chain, other in zip(chains, order, strict=True):
            columns[list(chain)] = chains[other]
        first = [facts.joints[chain[0]] for chain in chains]
        names = " and ".join(first[k] for k in usual if order[k] != k)
        moved = tuple(j for k in usual if order[k] != k for j in chains[k])
        read = ", ".join(first[order.index(k)] for k in usual)
        words = f"whole chains are exchanged: those of {names}; the log has {read}"
        yield words, Change(columns, columns), moved


def equal_chains(robot: Robot) -> list[list[int]]:
    """Joints of each chain from the base if there are several of the same length, else none."""
    parents = [int(parent) - 1 for parent in list(robot.kinematics.parents)[1:]]
    root = list(range(len(parents)))
    for joint, parent in enumerate(parents):
        root[joint] = joint if parent < 0 else root[parent]
    chains = [[j for j, base in enumerate(root) if base == start] for start in sorted(set(root))]
    return chains if len(chains) > 1 and len({len(chain) for chain in chains}) == 1 else []


def turned_positions(facts: LogFacts) -> Iterator[Case]:
    """Wrong sign of the position of one joint."""
    for j in facts.moving:
        words = f"the position of {facts.joints[j]} has the opposite sign"
        yield words, Change(scale=facts.where({j: -1.0})), (j,)


def other_angles(facts: LogFacts) -> Iterator[Case]:
    """Positions in another unit of angle."""
    turning = [j for j in facts.moving if facts.robot.revolute[j]]
    for words, factor in ANGLES.items():
        if turning:
            change = Change(scale=facts.where(dict.fromkeys(turning, factor)))
            yield f"the positions are {words}", change, tuple(turning)
    for j in turning if len(turning) > 1 else ():
        change = Change(scale=facts.where({j: ANGLES["in degrees"]}))
        yield f"the position of {facts.joints[j]} is in degrees", change, (j,)


def shares_of_travel(facts: LogFacts) -> Iterator[Case]:
    """Positions in percent of each joint's travel."""
    limits, position = facts.robot.limits, facts.log.motion.position
    if not np.isfinite([limits.position_lower, limits.position_upper]).all():
        return
    span, middle = (sign(limits.position_upper, limits.position_lower) for sign in (np.subtract, np.add))
    for unit, words in ((1.0, ""), (180 / np.pi, ", but read as degrees")):
        numbers = np.abs(position * unit)
        if LEAST_PERCENT < numbers.max() < PERCENT:
            change = Change(scale=unit * span / 200.0, zero=middle / 2)
            yield facts.of_all(f"the positions are percent of each joint's travel{words}", change)


def gear_ratios(facts: LogFacts) -> Iterator[Case]:
    """Wrong gear ratio of one joint, which affects its position and its effort."""
    for j in facts.moving:
        for scale in ONE_SCALE:
            change = Change(scale=facts.where({j: scale}), factor=facts.where({j: 1.0 / scale}))
            share = digits(1.0 / scale, 2)
            words = f"the gear ratio of {facts.joints[j]} is about {share} times the stated one"
            yield f"{words}, which affects positions and efforts", change, (j,)


def position_scales(facts: LogFacts) -> Iterator[Case]:
    """Positions that are a fraction or a multiple of the angle."""
    turning = [j for j in facts.moving if facts.robot.revolute[j]]
    for scale in POSITION_SCALES:
        share = f"{digits(1 / scale, 2)} of the angle"
        if len(turning) > 1:
            change = Change(scale=facts.where(dict.fromkeys(turning, scale)))
            yield f"the positions look as if they were about {share} on all joints", change, tuple(turning)
        for j in turning if scale in ONE_SCALE else ():
            words = f"the positions of {facts.joints[j]} look as if they were about {share}"
            yield words, Change(scale=facts.where({j: scale})), (j,)
