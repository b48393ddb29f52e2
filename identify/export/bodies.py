"""Mass, center and inertia of a body in a file: ten numbers, their scales and changes.

A joint may move several bodies that are fixed to each other, of which only the sum is identified. The body
with the joint gets the difference, and the bodies fixed to it stay as they are. In an MJCF, they are scaled
if they exceed the sum: by the ratio of new and old mass, but at most by half of what would leave nothing for
the body.
"""

from collections.abc import Iterator

import numpy as np

from ..arm.robot import Robot
from ..effects.rigid_body import inertial_parameters
from ..fit.estimators.consistent import pseudo_inertia
from .changes import SAME, Change
from .portable import possible

PLACES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
"""Matrix indices of the numbers of an inertia, in the order of `fullinertia` of an MJCF."""
UNITS = ("kg", *("m",) * 3, *("kg m^2",) * 6)
"""Units of the ten numbers of a body."""


def robot_bodies(robot: Robot) -> np.ndarray:
    """Ten parameters of what each joint moves, in the joint's frame, shape (n, 10)."""
    return np.array([inertial_parameters(body) for body in list(robot.kinematics.inertias)[1:]])


def body_numbers(mass: float, center: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """Ten numbers of a body, shape (10,): mass [kg], center (3,) [m] and an inertia (3, 3) [kg m^2]."""
    return np.array([mass, *center, *(inertia[place] for place in PLACES.values())])


def differ(old: np.ndarray, new: np.ndarray) -> bool:
    """Whether ten parameters of a body (10,) have changed beyond rounding."""
    return bool(np.any(np.abs(new - old) > SAME * sizes(new)))


def sizes(values: np.ndarray) -> np.ndarray:
    """Scale of each of ten parameters, from the mass and its distance from the frame, shape (10,)."""
    mass, squares = abs(values[9]), abs(values[0]) + abs(values[3]) + abs(values[5])
    return np.array([squares] * 6 + [np.sqrt(mass * squares)] * 3 + [mass]) + np.finfo(float).tiny


def number_scales(numbers: np.ndarray) -> np.ndarray:
    """Scale of each of the ten numbers of a body, from its mass and extent, shape (10,)."""
    mass, moments = numbers[0], float(np.sum(numbers[4:7]))
    reach = np.sqrt(moments / mass) + np.linalg.norm(numbers[1:4])
    return np.array([mass] + [reach] * 3 + [moments] * 6)


def number_changes(
    where: str, center: str, inertia: str, old: np.ndarray, new: np.ndarray, halves: np.ndarray
) -> Iterator[Change]:
    """Changes of the ten numbers of a body beyond rounding, with `halves` (10,) of their 95 % intervals.

    `where` is the body, and `center` and `inertia` are the words before an axis and a pair of axes.
    """
    names = ["mass", *(f"{center} {axis}" for axis in "xyz"), *(f"{inertia}{pair}" for pair in PLACES)]
    for name, unit, scale, *numbers in zip(names, UNITS, number_scales(new), old, new, halves, strict=True):
        before, now, half = map(float, numbers)
        if abs(now - before) > SAME * scale:
            yield Change(where, name, unit, before, now, half)


def fixed_share(old: np.ndarray, new: np.ndarray, fixed: np.ndarray, largest: float) -> float:
    """Share that bodies fixed to a body keep, such that a body with positive mass and inertia is left.

    Parameters (10,) are those of all these bodies together in the file and as identified, and those of the
    fixed bodies in the file; `largest` is the largest of all bodies of the arm.
    """
    remainder = new - fixed
    if not np.any(fixed) or np.all(possible(remainder, largest) == remainder):
        return 1.0
    shares = np.linalg.eigvals(np.linalg.solve(pseudo_inertia(new), pseudo_inertia(fixed))).real
    return float(min(new[9] / old[9], 0.5 / max(shares)))
