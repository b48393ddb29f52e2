"""Hypotheses of units and order, weighed together: what limits and rigid bodies say of each."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ..arm.robot import Robot
from ..recordings.recording import EFFORT
from .agreement import Sampled, agreement, agreement_odds, sampled
from .mounting import DIRECTIONS, OTHERWISE, Direction, described_direction, found_direction, under
from .odds import posterior
from .units import SLIDING, TIME, TURNING, Units, moves, unit_odds

AS_NUMBERED = {"as numbered": 0.99, "alphabetical": 0.008, "other": 0.002}
"""Prior of the order of joints where columns have numbers: ROS tools sort by name."""
Order = tuple[int, ...]
"""Column of each joint, in the robot's order."""


@dataclass(frozen=True)
class Log:
    """Time (t,) in its unit, and what the families of columns hold, signal -> (t, n)."""

    time: np.ndarray
    values: Mapping[str, np.ndarray]

    def sampled(self, unit: str) -> Sampled:
        """Motion and effort under a unit of time, all else as it is."""
        effort = next(signal for signal in EFFORT if signal in self.values)
        return sampled(self.time * TIME[unit], self.values["position"], self.values[effort])


def factor_of(robot: Robot, unit: str) -> np.ndarray:
    """SI per unit of each joint's position, shape (n,)."""
    factor = {**TURNING, **SLIDING}[unit]
    return np.where(robot.revolute == (unit in TURNING), factor, 1.0)


def units_of(robot: Robot, unit: str, per: str = "") -> list[str]:
    """Unit of each joint's position, or with "/s" velocity, where one is given of joints of one kind."""
    turning = unit not in SLIDING
    other = ("m" if turning else "rad") + (per or ("/s" if unit == "rpm" else ""))
    return [unit + per if revolute == turning else other for revolute in robot.revolute.tolist()]


def joint_odds(
    log: Log, robot: Robot, stated: Units, orders: Mapping[Order, float]
) -> dict[tuple[Units, Order], float]:
    """Log odds of units and orders: by speeds, limits and velocities, and by the rigid bodies.

    Args:
        log: In its own units and order.
        robot: Whose joints are in order.
        stated: What the names state.
        orders: Column of each joint, and the prior of that order.
    """
    odds: dict[tuple[Units, Order], float] = {}
    samples: dict[str, Sampled] = {}
    for order, prior in orders.items():
        each = {signal: values[:, order] for signal, values in log.values.items()}
        seen = moves(log.time, each["position"], each.get("velocity"))
        of_units = unit_odds(seen, robot.limits, robot.revolute, stated)
        # One unit of time for all: under another one the filters would leave other samples to explain.
        time = next(iter(posterior(of_units))).time
        if time not in samples:
            samples[time] = log.sampled(time)
        agreed = {}
        for position in {units.position for units in of_units}:
            sample = samples[time].ordered(order, factor_of(robot, position))
            agreed[position] = agreement_odds(sample, agreement(robot, sample))
        odds |= {(u, order): o + agreed[u.position] + np.log(prior) for u, o in of_units.items()}
    return odds


def mounted_odds(
    log: Log, robot: Robot, stated: Units, orders: Mapping[Order, float]
) -> dict[tuple[Units, Order, Direction | None], float]:
    """The same of units, orders and the direction of gravity, up to its sign: as described, or as found."""
    upright = joint_odds(log, robot, stated, orders)
    described = described_direction(robot)
    odds = {(*one, described): value + np.log1p(-OTHERWISE) for one, value in upright.items()}
    plain = next(iter(orders))
    units, likeliest = next(iter(posterior(upright)))
    sample = log.sampled(units.time)
    for order in dict.fromkeys((plain, likeliest)):
        direction = found_direction(robot, sample.ordered(order, factor_of(robot, units.position)))
        if direction is not None:
            prior = np.log(OTHERWISE / DIRECTIONS)
            found = joint_odds(log, under(robot, direction), stated, orders)
            odds |= {(*one, direction): value + prior for one, value in found.items()}
    return odds


def orders_of(robot: Robot, by_name: bool) -> dict[Order, float]:
    """Orders that are weighed, and the prior of each: as numbered, sorted by name, two swapped."""
    n = robot.dof
    plain = tuple(range(n))
    if by_name or n == 1:
        return {plain: 1.0}
    ranks = tuple(sorted(robot.joints).index(joint) for joint in robot.joints)
    orders = {plain: AS_NUMBERED["as numbered"]}
    orders.setdefault(ranks, AS_NUMBERED["alphabetical"])
    pairs = list(combinations(plain, 2))
    for a, b in pairs:
        swapped = list(plain)
        swapped[a], swapped[b] = b, a
        orders.setdefault(tuple(swapped), AS_NUMBERED["other"] / len(pairs))
    return orders
