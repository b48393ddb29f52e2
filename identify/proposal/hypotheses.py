"""Hypotheses of units and order, weighed together: what limits and rigid bodies say of each."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..recordings.recording import EFFORT
from ..text_table import digits
from .agreement import Guess, Sampled, agreement, agreement_odds, posterior, sampled
from .column_names import Family
from .mounting import DIRECTIONS, OTHERWISE, Direction, described_direction, found_direction, under
from .units import SLIDING, TIME, TURNING, Units, moves, other_unit_odds, unit_odds

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

    The log is in its own units and order; `orders` has the column of each joint, and the prior of that order.
    """
    odds: dict[tuple[Units, Order], float] = {}
    samples: dict[str, Sampled] = {}
    for order, prior in orders.items():
        each = {signal: values[:, order] for signal, values in log.values.items()}
        seen = moves(log.time, each["position"], each.get("velocity"))
        driven = np.any([each[one].any(axis=0) for one in EFFORT if one in each], axis=0)
        if driven.any():  # what no drive moves falls as fast as it falls, whatever its limit
            seen = seen._replace(speed=seen.speed * driven)
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


def _mounted_odds(
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


def _orders_of(robot: Robot, by_name: bool) -> dict[Order, float]:
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


class Likeliest(NamedTuple):
    """What is likeliest, and what is guessed.

    Attributes:
        units: Units of time, position and velocity; "" for a velocity that is left out.
        order: Order of the joints among the columns.
        directions: Probability of each direction of gravity, up to its sign; empty without gravity.
        guesses: Guesses of units and order.
    """

    units: Units
    order: Order
    directions: dict[Direction, float]
    guesses: list[Guess]


def units_and_order(log: Log, robot: Robot, chosen: Mapping[str, Family], clock: str) -> Likeliest:
    """The likeliest units and order, each with its own probability, whatever the others are."""
    stated = Units(clock, chosen["position"].unit, chosen["velocity"].unit if "velocity" in chosen else "")
    orders = _orders_of(robot, chosen["position"].by_name)
    likely: dict[tuple[Units, Order], float] = {}
    directions: dict[Direction, float] = {}
    for (one, ordered, direction), p in posterior(_mounted_odds(log, robot, stated, orders)).items():
        likely[one, ordered] = likely.get((one, ordered), 0.0) + p
        if direction is not None:
            directions[direction] = directions.get(direction, 0.0) + p
    best, order = max(likely, key=lambda one: likely[one])
    why = _reasons(log, robot, best)
    guesses = [_unit_guess(robot, part, best, why[part], likely) for part in why]
    guesses[list(why).index("position")] = _among_known(
        log, robot, best, guesses[list(why).index("position")]
    )
    if len(orders) > 1:
        probability = sum(p for (_, one), p in likely.items() if one == order)
        value = "as numbered" if order == tuple(range(robot.dof)) else ", ".join(str(k + 1) for k in order)
        reason, option = f"bodies; {len(orders)} orders", "[position] column in a preset"
        guesses.append(Guess("order of joints", value, probability, reason, option))
    units = best if "velocity" in why else best._replace(velocity="")
    return Likeliest(units, order, directions, guesses)


def _among_known(log: Log, robot: Robot, units: Units, guess: Guess) -> Guess:
    """A guess of the unit of positions, which may be none of those that are weighed."""
    seen = moves(log.time, log.values["position"], log.values.get("velocity"))
    among = float(1 / (1 + np.exp(other_unit_odds(seen, robot.limits, robot.revolute, units))))
    if among < 0.5:
        return replace(guess, value="", probability=0.0, option="positions in radians, or metres")
    return replace(guess, probability=guess.probability * among)


def _reasons(log: Log, robot: Robot, units: Units) -> dict[str, str]:
    """What speaks for the unit of time, position and, where there is one, velocity."""
    seen = moves(log.time, log.values["position"], log.values.get("velocity"))
    rate = 1.0 / (seen.period * TIME[units.time])
    fast = float(np.max(seen.speed * factor_of(robot, units.position) / TIME[units.time]))
    speed = f"{digits(fast)} {'rad' if robot.revolute.any() else 'm'}/s at most"
    found = {"time": f"{digits(rate)} Hz, {speed}", "position": "limits, speeds, bodies"}
    return found | ({"velocity": "derivative of position"} if np.isfinite(seen.ratio) else {})


def _unit_guess(
    robot: Robot, part: str, best: Units, why: str, likely: Mapping[tuple[Units, Order], float]
) -> Guess:
    """Of time, position or velocity; of both kinds of joints where the robot has both."""
    unit = getattr(best, part)
    both = part != "time" and robot.revolute.any() and not robot.revolute.all()
    probability = sum(p for (units, _), p in likely.items() if getattr(units, part) == unit)
    per = "/s" if part == "velocity" and unit != "rpm" else ""
    value = ", ".join(dict.fromkeys(units_of(robot, unit, per))) if both else unit + per
    return Guess(f"unit of {part}", value, probability, why, f"[{part}] unit in a preset")
